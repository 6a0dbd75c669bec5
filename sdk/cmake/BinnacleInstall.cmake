# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where, in two components: `runtime` runs filters, `dev` builds plugins and programs.
# The folders are fixed, not those of GNUInstallDirs: the command finds its plugins at ../lib/binnacle and its templates
# at ../share/binnacle, so that the whole may be moved.
include_guard(GLOBAL)

include(CMakePackageConfigHelpers)

set(package_folder lib/cmake/Binnacle)

# ---- runtime: the command, the plugins, what `binnacle new plugin` copies

add_executable(Binnacle::binnacle ALIAS binnacle)
install(TARGETS binnacle EXPORT BinnacleTargets RUNTIME DESTINATION bin COMPONENT runtime)
if(TARGET binnacle-conform)
  install(TARGETS binnacle-conform RUNTIME DESTINATION bin COMPONENT runtime)
endif()

get_property(plugins GLOBAL PROPERTY BINNACLE_PLUGINS)
list(TRANSFORM plugins APPEND _plugin)
install(TARGETS ${plugins} LIBRARY DESTINATION lib/binnacle COMPONENT runtime)

install(DIRECTORY "${PROJECT_SOURCE_DIR}/sdk/template" DESTINATION share/binnacle COMPONENT runtime)
# The same place beside the command in the build tree.
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/share/binnacle")
file(CREATE_LINK "${PROJECT_SOURCE_DIR}/sdk/template" "${PROJECT_BINARY_DIR}/share/binnacle/template" SYMBOLIC)

install(FILES "${PROJECT_SOURCE_DIR}/README.md" "${PROJECT_SOURCE_DIR}/LICENSE"
  DESTINATION share/doc/binnacle COMPONENT runtime)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/sdk/docs/" DESTINATION share/doc/binnacle COMPONENT runtime)

# ---- dev: headers, the kernel's library, the CMake package

install(DIRECTORY "${PROJECT_SOURCE_DIR}/kernel/include/binnacle" "${PROJECT_BINARY_DIR}/kernel/include/binnacle"
  DESTINATION include COMPONENT dev FILES_MATCHING PATTERN "*.hpp")

# Whoever writes plugins needs no Boost: the kernel's library is an export set of its own.
install(TARGETS binnacle_headers EXPORT BinnacleTargets INCLUDES DESTINATION include)
# The suite's checkers, for a plugin's own tests.
install(DIRECTORY "${PROJECT_SOURCE_DIR}/sdk/testing/include/binnacle" DESTINATION include COMPONENT dev
  FILES_MATCHING PATTERN "*.hpp")
install(TARGETS binnacle_testing EXPORT BinnacleTargets ARCHIVE DESTINATION lib COMPONENT dev INCLUDES DESTINATION include)
install(TARGETS binnacle_kernel EXPORT BinnacleKernelTargets
  ARCHIVE DESTINATION lib COMPONENT dev
  INCLUDES DESTINATION include)
foreach(set IN ITEMS BinnacleTargets BinnacleKernelTargets)
  install(EXPORT ${set} NAMESPACE Binnacle:: DESTINATION ${package_folder} COMPONENT dev)
endforeach()

configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/BinnacleConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/package/BinnacleConfig.cmake"
  INSTALL_DESTINATION ${package_folder}
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/package/BinnacleConfigVersion.cmake"
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(
  FILES
    "${PROJECT_BINARY_DIR}/package/BinnacleConfig.cmake"
    "${PROJECT_BINARY_DIR}/package/BinnacleConfigVersion.cmake"
    "${CMAKE_CURRENT_LIST_DIR}/BinnaclePlugin.cmake"
    "${CMAKE_CURRENT_LIST_DIR}/binnacle_plugin.map"
  DESTINATION ${package_folder} COMPONENT dev)
