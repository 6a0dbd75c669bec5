# SPDX-License-Identifier: Apache-2.0
# binnacle_add_plugin() and binnacle_add_conformance_test(): used by the project for its own plugins, and installed for
# everybody else's.
include_guard(GLOBAL)

include(CheckCXXCompilerFlag)
check_cxx_compiler_flag(-fno-gnu-unique BINNACLE_HAS_NO_GNU_UNIQUE)

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

# What makes a shared library of them: only its entry symbols leave it, and everything it needs it has.
function(binnacle_plugin_link_options target)
  set(version_script "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/binnacle_plugin.map")
  set_target_properties(${target} PROPERTIES
    PREFIX ""
    SUFFIX ".so"
    LINK_DEPENDS "${version_script}")
  target_link_options(${target} PRIVATE "LINKER:--version-script=${version_script}")
  # clang leaves the sanitizer runtime to the executable.
  if(NOT (BINNACLE_SANITIZE AND CMAKE_CXX_COMPILER_ID MATCHES "Clang"))
    target_link_options(${target} PRIVATE LINKER:--no-undefined)
  endif()
  # The loader refuses a plugin that others may write, which a umask of 0 would make of it; and it lets a config name one
  # that was built here: FILE.built holds inode and time of change, which no archive can carry along.
  add_custom_command(TARGET ${target} POST_BUILD
    COMMAND chmod go-w "$<TARGET_FILE:${target}>"
    COMMAND sh -c "stat -c '%i %.9Z' \"$1\" >\"$1.built\" || rm -f \"$1.built\"" sh "$<TARGET_FILE:${target}>"
    VERBATIM)
endfunction()

# binnacle_add_plugin(NAME SOURCES … [LIBRARIES …])
#
# Makes the MODULE library NAME, the file NAME.so: a plugin that sees Binnacle's public headers and links no kernel
# library. One of the sources holds BINNACLE_PLUGIN(…). The word SOURCES may be left out.
function(binnacle_add_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LIBRARIES")
  set(sources ${arg_SOURCES} ${arg_UNPARSED_ARGUMENTS})
  if(NOT sources)
    message(FATAL_ERROR "binnacle_add_plugin(${name}): it has no sources")
  endif()
  add_library(${name} MODULE ${sources})
  binnacle_plugin_compile_options(${name})
  binnacle_plugin_link_options(${name})
  target_link_libraries(${name} PRIVATE Binnacle::headers ${arg_LIBRARIES})
endfunction()

# binnacle_add_conformance_test(TARGET [LEVEL n])
#
# Adds the test conform.TARGET: `binnacle conform` on that plugin, 1 (quick) to 10 (thorough). Its exit status decides.
# Needs enable_testing() or include(CTest) before it.
function(binnacle_add_conformance_test target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LEVEL" "")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "binnacle_add_conformance_test(${target}): not understood: '${arg_UNPARSED_ARGUMENTS}'")
  endif()
  if(NOT arg_LEVEL)
    set(arg_LEVEL 5)
  endif()
  add_test(NAME conform.${target}
    COMMAND "$<TARGET_FILE:Binnacle::binnacle>" conform "$<TARGET_FILE:${target}>" --level ${arg_LEVEL})
  set_tests_properties(conform.${target} PROPERTIES LABELS conform TIMEOUT 1800)
endfunction()
