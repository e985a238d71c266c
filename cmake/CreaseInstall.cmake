include(CMakePackageConfigHelpers)
include(GNUInstallDirs)
set(crease_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/crease)
install(EXPORT creaseTargets NAMESPACE crease:: DESTINATION ${crease_cmake_dir})
configure_package_config_file(cmake/creaseConfig.cmake.in creaseConfig.cmake INSTALL_DESTINATION ${crease_cmake_dir})
write_basic_package_version_file(creaseConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/creaseConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/creaseConfigVersion.cmake
              cmake/FindCHOLMOD.cmake cmake/FindIpopt.cmake DESTINATION ${crease_cmake_dir})
