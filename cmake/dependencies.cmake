# Finds what Recurse stands on. Everything comes from Debian packages; a missing one is named with its package.

function(recurse_missing WHAT PACKAGE)
    set_property(GLOBAL APPEND PROPERTY RECURSE_MISSING "  ${WHAT}: apt-get install ${PACKAGE}")
endfunction()

find_package(glm CONFIG QUIET)
find_package(TBB CONFIG QUIET)
find_package(nlohmann_json CONFIG QUIET)
find_package(CLI11 CONFIG QUIET)
find_package(ZLIB QUIET)
find_package(PkgConfig QUIET)
find_package(embree 4 CONFIG QUIET)
if(NOT embree_FOUND)
    find_package(embree 3 CONFIG QUIET)
endif()
if(PkgConfig_FOUND)
    # OpenImageIO's CMake package asks for its tools and Python module as well; its pkg-config file does not.
    pkg_check_modules(OpenImageIO QUIET IMPORTED_TARGET GLOBAL OpenImageIO)
    pkg_check_modules(FLANN QUIET IMPORTED_TARGET GLOBAL flann)
endif()

foreach(PAIR "glm:libglm-dev" "TBB:libtbb-dev" "OpenImageIO:libopenimageio-dev" "nlohmann_json:nlohmann-json3-dev"
             "CLI11:libcli11-dev" "ZLIB:zlib1g-dev" "PkgConfig:pkg-config" "embree:libembree-dev" "FLANN:libflann-dev")
    string(REPLACE ":" ";" PAIR ${PAIR})
    list(GET PAIR 0 NAME)
    list(GET PAIR 1 PACKAGE)
    if(NOT ${NAME}_FOUND)
        recurse_missing(${NAME} ${PACKAGE})
    endif()
endforeach()

if(BUILD_TESTING OR NOT DEFINED BUILD_TESTING)
    find_package(GTest CONFIG QUIET)
    if(NOT GTest_FOUND)
        recurse_missing(GoogleTest libgtest-dev)
    endif()
endif()

get_property(MISSING GLOBAL PROPERTY RECURSE_MISSING)
if(MISSING)
    list(JOIN MISSING "\n" MISSING)
    message(FATAL_ERROR "Recurse needs libraries that are not installed:\n${MISSING}\n"
                        "scripts/render and scripts/test install them by themselves.")
endif()

