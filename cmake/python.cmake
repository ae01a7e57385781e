# The Python package `recurse`: its module in C++, its files in Python, and type stubs that these write.

file(GLOB PYTHON_CPP CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/src/python/*.cpp)
file(GLOB PYTHON_FILES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/src/python/recurse/*)
list(FILTER PYTHON_FILES EXCLUDE REGEX "README")
set(PYTHON_PACKAGE ${CMAKE_CURRENT_BINARY_DIR}/python/recurse)
pybind11_add_module(recurse_python MODULE NO_EXTRAS ${PYTHON_CPP})
target_compile_definitions(recurse_python PRIVATE RECURSE_VERSION="${PROJECT_VERSION}")
target_link_libraries(recurse_python PRIVATE recurse_apps CLI11::CLI11)
set_target_properties(recurse_python PROPERTIES OUTPUT_NAME _core LIBRARY_OUTPUT_DIRECTORY ${PYTHON_PACKAGE})
add_custom_command(OUTPUT ${PYTHON_PACKAGE}/plug_ins.pyi
    COMMAND ${CMAKE_COMMAND} -E copy ${PYTHON_FILES} ${PYTHON_PACKAGE}
    COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${CMAKE_CURRENT_BINARY_DIR}/python
        ${Python_EXECUTABLE} -B -m recurse.stubs ${PYTHON_PACKAGE}/plug_ins.pyi
    DEPENDS recurse_python ${PYTHON_FILES} VERBATIM)
add_custom_target(recurse_python_package ALL DEPENDS ${PYTHON_PACKAGE}/plug_ins.pyi)

set(PYTHON_INSTALLED lib/python${Python_VERSION_MAJOR}/dist-packages/recurse)
install(TARGETS recurse_python LIBRARY DESTINATION ${PYTHON_INSTALLED} COMPONENT python)
install(FILES ${PYTHON_FILES} ${PYTHON_PACKAGE}/plug_ins.pyi DESTINATION ${PYTHON_INSTALLED} COMPONENT python)
