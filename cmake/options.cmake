# Options, and the compiler settings shared by every target.

option(BUILD_TESTING "Build the tests" ON)
option(RECURSE_LTO "Optimise across translation units (interprocedural optimisation)" OFF)
option(RECURSE_WERROR "Warnings are errors" OFF)
option(RECURSE_BENCHMARKS "Build the benchmarks (Google Benchmark)" ON)
option(RECURSE_FUZZ "Build the libFuzzer targets (clang)" OFF)
set(RECURSE_PROCESSOR "x86-64-v3" CACHE STRING
    "The x86-64 processor to build for, as for -march=: x86-64-v3 has AVX2, native is this machine, empty is any")
set(RECURSE_SANITIZE "" CACHE STRING "Sanitizers, as for -fsanitize=")

# Most of the time to compile a source goes into headers, and into templates that its neighbours need too.
option(CMAKE_UNITY_BUILD "Compile the sources of a folder together" ON)
set(CMAKE_UNITY_BUILD_BATCH_SIZE 0)
find_program(RECURSE_GIT git)
set(RECURSE_UNCOMMITTED)
if(RECURSE_GIT)
    execute_process(COMMAND ${RECURSE_GIT} ls-files --others --exclude-standard -- src/*.cpp
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE RECURSE_UNCOMMITTED ERROR_QUIET)
    string(REGEX MATCHALL "[^\n]+" RECURSE_UNCOMMITTED "${RECURSE_UNCOMMITTED}")
    list(TRANSFORM RECURSE_UNCOMMITTED PREPEND ${PROJECT_SOURCE_DIR}/)
endif()

set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, RelWithDebInfo or Debug" FORCE)
endif()
find_program(RECURSE_CCACHE ccache)
if(RECURSE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${RECURSE_CCACHE})
endif()
if(RECURSE_LTO)
    include(CheckIPOSupported)
    check_ipo_supported(LANGUAGES CXX)
    set(CMAKE_INTERPROCEDURAL_OPTIMIZATION ON)
endif()

add_library(recurse_options INTERFACE)
add_library(recurse::options ALIAS recurse_options)
set_target_properties(recurse_options PROPERTIES EXPORT_NAME options)
target_compile_features(recurse_options INTERFACE cxx_std_20)
target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-Wall;-Wextra;-Wpedantic>)
# Contraction of a*b+c would make results depend on the compiler; the photon index relies on exact distances.
target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-ffp-contract=off;-fno-math-errno>)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # Sees overlaps in "text" + std::string where there are none (GCC bug 105651, mended in 13).
    target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-Wno-restrict>)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_UNITY_BUILD)
    # Takes the sources that are included for headers, where a nameless namespace would be a mistake.
    target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-Wno-subobject-linkage>)
endif()
if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
    # Its intrinsics are macros with compound literals.
    target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-Wno-c99-extensions>)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND NOT RECURSE_PROCESSOR)
    # Vectors of eight go between functions of one file only.
    target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-Wno-psabi>)
endif()
if(RECURSE_WERROR)
    target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-Werror>)
endif()
if(RECURSE_PROCESSOR AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    # The kernels are written for 8 lanes of AVX2; wider registers gain nothing here.
    target_compile_options(recurse_options INTERFACE
        $<BUILD_INTERFACE:-march=${RECURSE_PROCESSOR};-mprefer-vector-width=256>)
endif()
if(RECURSE_SANITIZE)
    # A null pointer ends in a report of AddressSanitizer in any case. Checks of null, alignment and dynamic type at
    # each access take half of the time of the tests.
    set(without "")
    if(RECURSE_SANITIZE MATCHES "undefined")
        set(without ";-fno-sanitize=null,alignment,vptr")
    endif()
    target_compile_options(recurse_options INTERFACE
        $<BUILD_INTERFACE:-fsanitize=${RECURSE_SANITIZE}${without};-fno-omit-frame-pointer;-fno-sanitize-recover=all>)
    target_link_options(recurse_options INTERFACE -fsanitize=${RECURSE_SANITIZE})
endif()
# OpenImageIO alone loads 250 libraries, a fifth of a second; what does not use it shall not wait for it.
target_link_options(recurse_options INTERFACE $<BUILD_INTERFACE:-Wl,--as-needed>)
