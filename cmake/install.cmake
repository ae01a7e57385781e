# cmake --install: the program, the scenes, and one CMake package that gives users of the library
# recurse::recurse.

include(CMakePackageConfigHelpers)
set(RECURSE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/recurse)

get_property(MODULES GLOBAL PROPERTY RECURSE_MODULES)
install(TARGETS recurse_library recurse_options ${MODULES} EXPORT recurseTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT recurseTargets NAMESPACE recurse:: DESTINATION ${RECURSE_PACKAGE_DIR})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/recurseConfig.cmake.in
    ${CMAKE_CURRENT_BINARY_DIR}/cmake/recurseConfig.cmake INSTALL_DESTINATION ${RECURSE_PACKAGE_DIR})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/cmake/recurseConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/cmake/recurseConfig.cmake
    ${CMAKE_CURRENT_BINARY_DIR}/cmake/recurseConfigVersion.cmake ${CMAKE_CURRENT_LIST_DIR}/libraries.cmake
    DESTINATION ${RECURSE_PACKAGE_DIR})

install(DIRECTORY include/recurse DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(TARGETS recurse RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(TARGET recurse-mpi)
    install(TARGETS recurse-mpi RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT mpi)
endif()
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/recurse)
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
# The solutions of the course, and folders where it was built, stay in the source tree.
install(DIRECTORY doc-files DESTINATION ${CMAKE_INSTALL_DOCDIR}
    PATTERN "course/solutions" EXCLUDE PATTERN "course/handout" EXCLUDE PATTERN "course/build*" EXCLUDE)
