# `cmake --install`: the tool, the public headers, and the package that find_package(Planegraph) finds.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Planegraph)
get_property(exported GLOBAL PROPERTY PLANEGRAPH_MODULES)
get_property(packages GLOBAL PROPERTY PLANEGRAPH_PACKAGES)
list(REMOVE_DUPLICATES packages)
list(TRANSFORM packages REPLACE "(.+)" "find_dependency(\\1)")
list(JOIN packages "\n" PLANEGRAPH_FIND_DEPENDENCIES)

set_target_properties(planegraph_options PROPERTIES EXPORT_NAME options)
install(TARGETS ${exported} planegraph_options EXPORT PlanegraphTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS planegraph_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/planegraph DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.h")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(EXPORT PlanegraphTargets NAMESPACE Planegraph:: DESTINATION ${package_dir})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/PlanegraphConfig.cmake.in
  ${PROJECT_BINARY_DIR}/generated/PlanegraphConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/generated/PlanegraphConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/generated/PlanegraphConfig.cmake
              ${PROJECT_BINARY_DIR}/generated/PlanegraphConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindGeographicLib.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindCholmod.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindLibExif.cmake
        DESTINATION ${package_dir})
