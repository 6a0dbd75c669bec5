# SPDX-License-Identifier: Apache-2.0
# binnacle_plugin(): a plugin of this project, and its objects for tests to link.
include_guard(GLOBAL)

include(BinnaclePlugin)

add_custom_target(binnacle_plugins COMMENT "All plugins are built")
if(PROJECT_IS_TOP_LEVEL)
  add_custom_target(plugins DEPENDS binnacle_plugins)
endif()

# The precompiled header of all plugins, and of the libraries that they share.
binnacle_precompiled_headers(binnacle_plugin_precompiled
  <binnacle/plugin.hpp> <binnacle/geodesy.hpp> <binnacle/jacobian.hpp> <Eigen/Dense> <algorithm> <array> <cmath> <functional> <map> <memory>
  <optional> <span> <string> <string_view> <vector>)
binnacle_plugin_compile_options(binnacle_plugin_precompiled)
target_link_libraries(binnacle_plugin_precompiled PRIVATE Binnacle::headers)

# binnacle_plugin(NAME SOURCES plugin.cpp … [LIBRARIES …])
#
# Makes   NAME_plugin   the MODULE library lib/binnacle/NAME.so: the objects;
#         NAME_objects  everything, compiled once, for tests too: link it and include "NAME/….hpp". The entry is weak.
# Sources see the kernel's public headers and their own folder, and link no kernel library.
function(binnacle_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LIBRARIES")
  if(arg_UNPARSED_ARGUMENTS OR NOT "plugin.cpp" IN_LIST arg_SOURCES)
    message(FATAL_ERROR "binnacle_plugin(${name}): SOURCES must list plugin.cpp; unparsed: '${arg_UNPARSED_ARGUMENTS}'")
  endif()

  add_library(${name}_objects OBJECT ${arg_SOURCES})
  binnacle_plugin_compile_options(${name}_objects)
  binnacle_reuse_precompiled(${name}_objects binnacle_plugin_precompiled)
  target_include_directories(${name}_objects
    PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}"
    PUBLIC "${PROJECT_SOURCE_DIR}/plugins")
  target_link_libraries(${name}_objects PUBLIC Binnacle::headers ${arg_LIBRARIES})

  binnacle_add_plugin(${name}_plugin SOURCES $<TARGET_OBJECTS:${name}_objects> LIBRARIES ${arg_LIBRARIES})
  set_target_properties(${name}_plugin PROPERTIES LINKER_LANGUAGE CXX)
  set_target_properties(${name}_plugin PROPERTIES
    OUTPUT_NAME ${name}
    LIBRARY_OUTPUT_DIRECTORY "${BINNACLE_PLUGIN_OUTPUT_DIRECTORY}")

  add_dependencies(binnacle_plugins ${name}_plugin)
  set_property(GLOBAL APPEND PROPERTY BINNACLE_PLUGINS ${name})
endfunction()
