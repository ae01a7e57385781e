# Finds the libraries that Recurse stands on. Read by the build and by the installed CMake package alike.
# Sets RECURSE_MISSING: one line for each library that is not there, with the Debian package that has it.

set(RECURSE_MISSING)
macro(recurse_need FOUND WHAT PACKAGE)
    if(NOT ${FOUND})
        list(APPEND RECURSE_MISSING "${WHAT} (Debian package ${PACKAGE})")
    endif()
endmacro()

find_package(glm CONFIG QUIET)
recurse_need(glm_FOUND GLM libglm-dev)

find_package(TBB CONFIG QUIET)
recurse_need(TBB_FOUND TBB libtbb-dev)

find_package(ZLIB QUIET)
recurse_need(ZLIB_FOUND zlib zlib1g-dev)

find_package(embree 4 CONFIG QUIET)
if(NOT embree_FOUND)
    find_package(embree 3 CONFIG QUIET)
endif()
recurse_need(embree_FOUND Embree libembree-dev)

# Libraries without a CMake package that would do: an imported TARGET of a header's folder and of the LIBRARIES.
function(recurse_find TARGET HEADER WHAT PACKAGE)
    string(MAKE_C_IDENTIFIER "RECURSE_${WHAT}" NAME)
    string(TOUPPER ${NAME} NAME)
    find_path(${NAME}_INCLUDE ${HEADER})
    set(LIBRARIES)
    set(FOUND ${${NAME}_INCLUDE})
    foreach(LIBRARY ${ARGN})
        string(TOUPPER "${NAME}_${LIBRARY}" PLACE)
        find_library(${PLACE} ${LIBRARY})
        list(APPEND LIBRARIES ${${PLACE}})
        if(NOT ${PLACE})
            set(FOUND FALSE)
        endif()
    endforeach()
    if(FOUND AND NOT TARGET ${TARGET})
        add_library(${TARGET} INTERFACE IMPORTED GLOBAL)
        set_target_properties(${TARGET} PROPERTIES
            INTERFACE_INCLUDE_DIRECTORIES "${${NAME}_INCLUDE}" INTERFACE_LINK_LIBRARIES "${LIBRARIES}")
    endif()
    recurse_need(FOUND ${WHAT} ${PACKAGE})
    set(RECURSE_MISSING ${RECURSE_MISSING} PARENT_SCOPE)
endfunction()

# The CMake package and the pkg-config file of OpenImageIO, and those of FLANN, ask for packages that a program
# which links the two has no use for.
recurse_find(OpenImageIO::OpenImageIO OpenImageIO/imageio.h OpenImageIO libopenimageio-dev OpenImageIO OpenImageIO_Util)
# FLANN's templates are all in headers; saving an index, which they also can, wants lz4.
recurse_find(RecurseFlann::headers flann/algorithms/kdtree_single_index.h FLANN libflann-dev lz4)
# The archives of games.
recurse_find(RecurseZip::zip zip.h libzip libzip-dev zip)
# Models of every common kind. The CMake package names a target of another path on each system.
recurse_find(RecurseAssimp::assimp assimp/Importer.hpp Assimp libassimp-dev assimp)
# Subdivision surfaces. The CMake package wants the part for graphics cards too.
recurse_find(RecurseSubdivision::far opensubdiv/far/primvarRefiner.h OpenSubdiv libosd-dev osdCPU)
# The fast Fourier transforms of bloom.
recurse_find(RecurseFftw::fftw fftw3.h FFTW libfftw3-dev fftw3)
