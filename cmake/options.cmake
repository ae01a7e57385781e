# Compiler settings shared by every target.

option(RECURSE_NATIVE "Build for this very machine; otherwise for x86-64-v3" ON)
option(RECURSE_WERROR "Warnings are errors" OFF)
option(RECURSE_BENCHMARKS "Build the benchmarks (Google Benchmark)" ON)
option(RECURSE_FUZZ "Build the libFuzzer targets (clang)" OFF)
set(RECURSE_SANITIZE "" CACHE STRING "Sanitizers, as for -fsanitize=")

set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
find_program(CCACHE ccache)
if(CCACHE)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

add_library(recurse_options INTERFACE)
target_compile_features(recurse_options INTERFACE cxx_std_20)
target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-Wall -Wextra -Wpedantic>)
# Contraction of a*b+c would make results depend on the compiler; the photon index relies on exact distances.
target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-ffp-contract=off -fno-math-errno>)
if(RECURSE_WERROR)
    target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-Werror>)
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    if(RECURSE_NATIVE)
        # The kernels are written for 8 lanes of AVX2; wider registers gain nothing here.
        target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-march=native -mprefer-vector-width=256>)
    else()
        target_compile_options(recurse_options INTERFACE $<BUILD_INTERFACE:-march=x86-64-v3>)
    endif()
endif()
if(RECURSE_SANITIZE)
    target_compile_options(recurse_options INTERFACE
        $<BUILD_INTERFACE:-fsanitize=${RECURSE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all>)
    target_link_options(recurse_options INTERFACE $<BUILD_INTERFACE:-fsanitize=${RECURSE_SANITIZE}>)
endif()
