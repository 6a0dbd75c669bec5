# SPDX-License-Identifier: Apache-2.0
# How everything in this project is compiled: standard, warnings, sanitizers, ccache, where results lie.
include_guard(GLOBAL)

option(BINNACLE_WERROR "Warnings are errors (CI)" OFF)
option(BINNACLE_FUZZ "Instrument everything for libFuzzer, and build the fuzz targets with it (clang)")
set(BINNACLE_SANITIZE "" CACHE STRING "Sanitizers to build with, as -fsanitize takes them")

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# The command finds its plugins at ../lib/binnacle and its templates at ../share/binnacle, built or installed.
set(BINNACLE_SHARE_FOLDER share/binnacle)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
set(BINNACLE_PLUGIN_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib/binnacle")

add_compile_options(-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wold-style-cast -Wnon-virtual-dtor)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  add_compile_options(-Wno-restrict)  # false for "a" + std::to_string(n): GCC bug 105651
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
  add_compile_options(-Wno-dangling-reference)  # false for a reference that a call returns of its own object
endif()
if(BINNACLE_WERROR)
  add_compile_options(-Werror)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # These come from the optimizer and name code inside Eigen and the standard library as often as ours.
    add_compile_options(-Wno-error=maybe-uninitialized -Wno-error=array-bounds
      -Wno-error=stringop-overflow -Wno-error=stringop-overread -Wno-error=free-nonheap-object)
  endif()
endif()

# A library that nothing of is used costs every start its relocations; Boost.Filesystem is one.
add_link_options(LINKER:--as-needed)

if(BINNACLE_SANITIZE)
  add_compile_options(-fsanitize=${BINNACLE_SANITIZE} -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${BINNACLE_SANITIZE})
  if(BINNACLE_SANITIZE MATCHES "undefined")
    # In Eigen's expressions these two double the time of a build and of its tests. A null pointer ends the program anyway;
    # what runs of the kernel, on objects in its arena, keeps the check of alignment (kernel/CMakeLists.txt).
    add_compile_options(-fno-sanitize=null,alignment)
  endif()
endif()

if(BINNACLE_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

find_program(BINNACLE_CCACHE ccache)
mark_as_advanced(BINNACLE_CCACHE)
if(BINNACLE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # The sloppiness is what precompiled headers need, and no more: a header that changes while it is compiled must not be
  # cached. The base directory lets another clone hit the same entries.
  set(CMAKE_CXX_COMPILER_LAUNCHER env
    "CCACHE_SLOPPINESS=pch_defines,time_macros"
    "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}"
    "${BINNACLE_CCACHE}")
endif()

# Unity batches and shared precompiled headers take two thirds of the compile time away. In the preset `dev` each source
# compiles alone, so a change of one compiles one; tests/structure compiles each source and header alone.
option(BINNACLE_UNITY "Compile sources in batches, behind a precompiled header" ON)
set(CMAKE_UNITY_BUILD ${BINNACLE_UNITY})
if(BINNACLE_UNITY AND CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  add_compile_options(-Wno-shadow)  # a local of one file that is named as a constant of another; the preset dev reports shadows
endif()
set(CMAKE_UNITY_BUILD_BATCH_SIZE 64)

# binnacle_precompile(TARGET HEADER …): a precompiled header for TARGET, and for those that reuse it.
function(binnacle_precompile target)
  target_precompile_headers(${target} PRIVATE ${ARGN})
  binnacle_keep_precompiled(${target})
endfunction()

# binnacle_cold(TARGET): TARGET has no arithmetic with matrices or long data. -Os takes a quarter of the compile time of -O1
# away; `observe` took twice its time with it, `inspect` 1.4 times, so they are not cold.
function(binnacle_cold target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-Os>)
  set_target_properties(${target} PROPERTIES BINNACLE_COLD ON)
endfunction()

# binnacle_reuse_precompiled(TARGET FROM [COLD]): TARGET is compiled behind the precompiled header of FROM, or of COLD where
# TARGET is cold. Both have the same processor and language options; levels of optimization from -O1 to -O3 may differ.
function(binnacle_reuse_precompiled target from)
  get_target_property(cold ${target} BINNACLE_COLD)
  if(cold AND ARGC GREATER 2)
    set(from ${ARGV2})
  endif()
  get_target_property(type ${target} TYPE)
  get_target_property(own ${target} PRECOMPILE_HEADERS)
  if(own OR NOT type MATCHES "STATIC|SHARED|OBJECT|MODULE|EXECUTABLE")
    return()
  endif()
  if(type STREQUAL "EXECUTABLE")
    # Objects of a program are compiled as those of a library, which the header is for.
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${target} PRIVATE -fPIC)
  endif()
  target_precompile_headers(${target} REUSE_FROM ${from})
  binnacle_keep_precompiled(${target})
endfunction()

# binnacle_precompiled_headers(NAME HEADER …): an object library that has nothing but a precompiled header.
function(binnacle_precompiled_headers name)
  set(source "${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp")
  file(CONFIGURE OUTPUT "${source}" CONTENT "// Nothing: the precompiled header is all.\n" @ONLY)
  add_library(${name} OBJECT "${source}")
  binnacle_precompile(${name} ${ARGN})
endfunction()

# What ccache needs to keep objects that were compiled behind a precompiled header.
function(binnacle_keep_precompiled target)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND BINNACLE_CCACHE)
    target_compile_options(${target} PRIVATE -fpch-preprocess)
  elseif(CMAKE_CXX_COMPILER_ID MATCHES "Clang" AND BINNACLE_CCACHE)
    target_compile_options(${target} PRIVATE "SHELL:-Xclang -fno-pch-timestamp")
  endif()
endfunction()
