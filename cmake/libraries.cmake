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

# The CMake package and the pkg-config file of OpenImageIO, and those of FLANN, ask for packages that a program
# which links the two has no use for; headers and libraries are found directly.
find_path(RECURSE_OPENIMAGEIO_INCLUDE OpenImageIO/imageio.h)
find_library(RECURSE_OPENIMAGEIO_LIBRARY OpenImageIO)
find_library(RECURSE_OPENIMAGEIO_UTIL_LIBRARY OpenImageIO_Util)
if(RECURSE_OPENIMAGEIO_INCLUDE AND RECURSE_OPENIMAGEIO_LIBRARY AND RECURSE_OPENIMAGEIO_UTIL_LIBRARY)
    set(RECURSE_OPENIMAGEIO_FOUND TRUE)
    if(NOT TARGET OpenImageIO::OpenImageIO)
        add_library(OpenImageIO::OpenImageIO INTERFACE IMPORTED)
        set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
            INTERFACE_INCLUDE_DIRECTORIES "${RECURSE_OPENIMAGEIO_INCLUDE}"
            INTERFACE_LINK_LIBRARIES "${RECURSE_OPENIMAGEIO_LIBRARY};${RECURSE_OPENIMAGEIO_UTIL_LIBRARY}")
    endif()
endif()
recurse_need(RECURSE_OPENIMAGEIO_FOUND OpenImageIO libopenimageio-dev)

# FLANN's templates are all in headers; saving an index, which they also can, wants lz4.
find_path(RECURSE_FLANN_INCLUDE flann/algorithms/kdtree_single_index.h)
find_library(RECURSE_LZ4_LIBRARY lz4)
if(RECURSE_FLANN_INCLUDE AND RECURSE_LZ4_LIBRARY)
    set(RECURSE_FLANN_FOUND TRUE)
    if(NOT TARGET RecurseFlann::headers)
        add_library(RecurseFlann::headers INTERFACE IMPORTED)
        set_target_properties(RecurseFlann::headers PROPERTIES
            INTERFACE_INCLUDE_DIRECTORIES "${RECURSE_FLANN_INCLUDE}"
            INTERFACE_LINK_LIBRARIES "${RECURSE_LZ4_LIBRARY}")
    endif()
endif()
recurse_need(RECURSE_FLANN_FOUND FLANN libflann-dev)

# The archives of games.
find_path(RECURSE_ZIP_INCLUDE zip.h)
find_library(RECURSE_ZIP_LIBRARY zip)
if(RECURSE_ZIP_INCLUDE AND RECURSE_ZIP_LIBRARY)
    set(RECURSE_ZIP_FOUND TRUE)
    if(NOT TARGET RecurseZip::zip)
        add_library(RecurseZip::zip INTERFACE IMPORTED)
        set_target_properties(RecurseZip::zip PROPERTIES
            INTERFACE_INCLUDE_DIRECTORIES "${RECURSE_ZIP_INCLUDE}" INTERFACE_LINK_LIBRARIES "${RECURSE_ZIP_LIBRARY}")
    endif()
endif()
recurse_need(RECURSE_ZIP_FOUND libzip libzip-dev)

# Models of every common kind. The CMake package names a target of another path on each system.
find_path(RECURSE_ASSIMP_INCLUDE assimp/Importer.hpp)
find_library(RECURSE_ASSIMP_LIBRARY assimp)
if(RECURSE_ASSIMP_INCLUDE AND RECURSE_ASSIMP_LIBRARY)
    set(RECURSE_ASSIMP_FOUND TRUE)
    if(NOT TARGET RecurseAssimp::assimp)
        add_library(RecurseAssimp::assimp INTERFACE IMPORTED)
        set_target_properties(RecurseAssimp::assimp PROPERTIES
            INTERFACE_INCLUDE_DIRECTORIES "${RECURSE_ASSIMP_INCLUDE}"
            INTERFACE_LINK_LIBRARIES "${RECURSE_ASSIMP_LIBRARY}")
    endif()
endif()
recurse_need(RECURSE_ASSIMP_FOUND Assimp libassimp-dev)

# The fast Fourier transforms of bloom.
find_path(RECURSE_FFTW_INCLUDE fftw3.h)
find_library(RECURSE_FFTW_LIBRARY fftw3)
if(RECURSE_FFTW_INCLUDE AND RECURSE_FFTW_LIBRARY)
    set(RECURSE_FFTW_FOUND TRUE)
    if(NOT TARGET RecurseFftw::fftw)
        add_library(RecurseFftw::fftw INTERFACE IMPORTED)
        set_target_properties(RecurseFftw::fftw PROPERTIES
            INTERFACE_INCLUDE_DIRECTORIES "${RECURSE_FFTW_INCLUDE}" INTERFACE_LINK_LIBRARIES "${RECURSE_FFTW_LIBRARY}")
    endif()
endif()
recurse_need(RECURSE_FFTW_FOUND FFTW libfftw3-dev)
