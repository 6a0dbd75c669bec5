# SPDX-License-Identifier: Apache-2.0
# binnacle_plugin(): a plugin's shared library, and its objects for tests to link.
include_guard(GLOBAL)

include(CheckCXXCompilerFlag)
check_cxx_compiler_flag(-fno-gnu-unique BINNACLE_HAS_NO_GNU_UNIQUE)

set(BINNACLE_PLUGIN_VERSION_SCRIPT "${CMAKE_CURRENT_LIST_DIR}/binnacle_plugin.map")

add_custom_target(plugins COMMENT "All plugins are built")

# What makes the objects of a plugin: hidden symbols, and none that would pin the library in memory.
function(binnacle_plugin_compile_options target)
  set_target_properties(${target} PROPERTIES
    POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON)
  if(BINNACLE_HAS_NO_GNU_UNIQUE)
    target_compile_options(${target} PRIVATE -fno-gnu-unique)
  endif()
endfunction()

# What makes a shared library of them: only the two entry symbols leave it, and everything it needs it has.
function(binnacle_plugin_link_options target)
  set_target_properties(${target} PROPERTIES
    PREFIX ""
    SUFFIX ".so"
    LINK_DEPENDS "${BINNACLE_PLUGIN_VERSION_SCRIPT}")
  target_link_options(${target} PRIVATE "LINKER:--version-script=${BINNACLE_PLUGIN_VERSION_SCRIPT}")
  # clang leaves the sanitizer runtime to the executable.
  if(NOT (BINNACLE_SANITIZE AND CMAKE_CXX_COMPILER_ID MATCHES "Clang"))
    target_link_options(${target} PRIVATE LINKER:--no-undefined)
  endif()
  # The loader refuses a plugin that anybody may write, which a umask of 0 would make of it.
  add_custom_command(TARGET ${target} POST_BUILD COMMAND chmod o-w "$<TARGET_FILE:${target}>" VERBATIM)
endfunction()

# binnacle_plugin(NAME SOURCES plugin.cpp … [LIBRARIES …])
#
# Makes   NAME_plugin   the MODULE library lib/binnacle/NAME.so: plugin.cpp and the objects;
#         NAME_objects  everything but plugin.cpp, for tests: link it and include "NAME/….hpp".
# Sources see the kernel's public headers and their own folder, and link no kernel library.
function(binnacle_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LIBRARIES")
  if(arg_UNPARSED_ARGUMENTS OR NOT "plugin.cpp" IN_LIST arg_SOURCES)
    message(FATAL_ERROR "binnacle_plugin(${name}): SOURCES must list plugin.cpp; unparsed: '${arg_UNPARSED_ARGUMENTS}'")
  endif()
  list(REMOVE_ITEM arg_SOURCES plugin.cpp)

  if(arg_SOURCES)
    add_library(${name}_objects OBJECT ${arg_SOURCES})
    binnacle_plugin_compile_options(${name}_objects)
    target_include_directories(${name}_objects
      PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}"
      PUBLIC "${PROJECT_SOURCE_DIR}/plugins")
    target_link_libraries(${name}_objects PUBLIC Binnacle::headers ${arg_LIBRARIES})
  else()
    add_library(${name}_objects INTERFACE)
    target_include_directories(${name}_objects INTERFACE "${PROJECT_SOURCE_DIR}/plugins")
    target_link_libraries(${name}_objects INTERFACE Binnacle::headers ${arg_LIBRARIES})
  endif()

  add_library(${name}_plugin MODULE plugin.cpp)
  set_target_properties(${name}_plugin PROPERTIES
    OUTPUT_NAME ${name}
    LIBRARY_OUTPUT_DIRECTORY "${BINNACLE_PLUGIN_OUTPUT_DIRECTORY}")
  binnacle_plugin_compile_options(${name}_plugin)
  binnacle_plugin_link_options(${name}_plugin)
  target_link_libraries(${name}_plugin PRIVATE ${name}_objects)

  add_dependencies(plugins ${name}_plugin)
  set_property(GLOBAL APPEND PROPERTY BINNACLE_PLUGINS ${name})
endfunction()
