# What the build needs. Everything comes from Debian packages, and all that is missing is named in one message.

include(${CMAKE_CURRENT_LIST_DIR}/libraries.cmake)

find_package(nlohmann_json CONFIG QUIET)
recurse_need(nlohmann_json_FOUND nlohmann-json nlohmann-json3-dev)
find_package(CLI11 CONFIG QUIET)
recurse_need(CLI11_FOUND CLI11 libcli11-dev)
# `recurse-mpi`, which is left out where there is no MPI.
option(RECURSE_MPI "Build recurse-mpi where MPI is found" ON)
if(RECURSE_MPI)
    set(MPI_CXX_SKIP_MPICXX ON)
    find_package(MPI QUIET COMPONENTS CXX)
endif()
# The Python module, which is left out where pybind11, NumPy or Python's headers are missing.
option(RECURSE_PYTHON "Build the Python module where pybind11 is found" ON)
if(RECURSE_PYTHON AND NOT RECURSE_SANITIZE)
    # The system's Python, whose packages have the two; -DPython_EXECUTABLE=... asks for another one.
    find_program(Python_EXECUTABLE python3 PATHS /usr/bin NO_DEFAULT_PATH)
    find_package(Python QUIET COMPONENTS Interpreter Development.Module NumPy)
    set(PYBIND11_FINDPYTHON ON)
    if(Python_NumPy_FOUND)
        find_package(pybind11 CONFIG QUIET)
    endif()
endif()
# The plots of the page of `recurse converge`; goes into the program as it is.
find_file(RECURSE_CHART_JS chart.min.js PATH_SUFFIXES share/javascript/chart.js share/nodejs/chart.js/dist)
recurse_need(RECURSE_CHART_JS Chart.js libjs-chart.js)
# The scene in 3D on the page of `recurse inspect`; goes into the program as it is.
find_file(RECURSE_THREE_JS three.min.js PATH_SUFFIXES share/javascript/three)
find_file(RECURSE_ORBIT_CONTROLS_JS OrbitControls.js PATH_SUFFIXES share/javascript/three/examples/js/controls)
if(RECURSE_THREE_JS AND RECURSE_ORBIT_CONTROLS_JS)
    set(RECURSE_THREE_FOUND TRUE)
endif()
recurse_need(RECURSE_THREE_FOUND three.js libjs-three)
if(BUILD_TESTING)
    find_package(GTest CONFIG QUIET)
    recurse_need(GTest_FOUND GoogleTest libgtest-dev)
endif()
if(RECURSE_BENCHMARKS)
    find_package(benchmark CONFIG QUIET)
    recurse_need(benchmark_FOUND "Google Benchmark" libbenchmark-dev)
endif()

if(RECURSE_MISSING)
    set(PACKAGES ${RECURSE_MISSING})
    list(TRANSFORM PACKAGES REPLACE ".*Debian package (.*)\\)$" "\\1")
    list(JOIN PACKAGES " " PACKAGES)
    list(JOIN RECURSE_MISSING "\n  " RECURSE_MISSING)
    message(FATAL_ERROR "Recurse needs libraries that are not installed:\n  ${RECURSE_MISSING}\n"
                        "Install them with\n  apt-get install ${PACKAGES}\n"
                        "or run scripts/render or scripts/test, which do so by themselves.")
endif()
