# SPDX-License-Identifier: Apache-2.0
# Tests by tiers.txt: which carry the label `quick`, and how executables of Catch2 cases are split between tiers.
include_guard(GLOBAL)

set(BINNACLE_TIERS_FILE "${CMAKE_CURRENT_LIST_DIR}/tiers.txt")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${BINNACLE_TIERS_FILE}")
set(BINNACLE_JUNIT_FOLDER "${PROJECT_BINARY_DIR}/junit")
file(MAKE_DIRECTORY "${BINNACLE_JUNIT_FOLDER}")
# One line for each executable: "LABEL FILE", for tests/run --case and tests/tiers.py.
set(BINNACLE_EXECUTABLES_FILE "${PROJECT_BINARY_DIR}/tests/executables.txt")
file(WRITE "${BINNACLE_EXECUTABLES_FILE}" "")

# TIER UNITS PATTERN # FINDS: a * in the pattern is any text. Three lists.
file(STRINGS "${BINNACLE_TIERS_FILE}" lines REGEX "^[a-z]")
foreach(line IN LISTS lines)
  if(NOT line MATCHES "^(quick|all) +([0-9]+[.]?[0-9]*) +([^][#;]*[^][#; ]) +# [^ ]")
    message(FATAL_ERROR "${BINNACLE_TIERS_FILE}: not understood: ${line}")
  endif()
  list(APPEND BINNACLE_TIERS ${CMAKE_MATCH_1})
  list(APPEND BINNACLE_TIER_UNITS ${CMAKE_MATCH_2})
  list(APPEND BINNACLE_TIER_PATTERNS "${CMAKE_MATCH_3}")
  string(REGEX REPLACE "([+.^$()|?\\])" "\\\\\\1" pattern "${CMAKE_MATCH_3}")
  string(REPLACE "*" ".*" pattern "${pattern}")
  list(APPEND BINNACLE_TIER_REGEXES "^${pattern}$")
endforeach()

# binnacle_tier_of(TEST TIER UNITS): by the first line whose pattern matches; "" without one (tests/tiers.py finds it).
function(binnacle_tier_of test tier units)
  set(${tier} "" PARENT_SCOPE)
  set(${units} 1 PARENT_SCOPE)
  foreach(line_tier line_units regex IN ZIP_LISTS BINNACLE_TIERS BINNACLE_TIER_UNITS BINNACLE_TIER_REGEXES)
    if(test MATCHES "${regex}")
      set(${tier} ${line_tier} PARENT_SCOPE)
      set(${units} ${line_units} PARENT_SCOPE)
      return()
    endif()
  endforeach()
endfunction()

# Labels and costs of this folder's tests; called at the folder's end, since CMake 3.25 sets them nowhere else.
function(binnacle_apply_tiers)
  get_property(tests DIRECTORY PROPERTY TESTS)
  foreach(test IN LISTS tests)
    if(test MATCHES ": cases, (quick|all)$")
      set(tier ${CMAKE_MATCH_1})
    else()
      binnacle_tier_of("${test}" tier units)
      set_property(TEST "${test}" PROPERTY COST ${units})
    endif()
    if(tier STREQUAL "quick")
      set_property(TEST "${test}" APPEND PROPERTY LABELS quick)
    endif()
  endforeach()
endfunction()

# Each folder with tests calls this, or binnacle_test(), which does.
macro(binnacle_tiers)
  get_property(binnacle_has_tiers DIRECTORY PROPERTY BINNACLE_HAS_TIERS)
  if(NOT binnacle_has_tiers)
    set_property(DIRECTORY PROPERTY BINNACLE_HAS_TIERS TRUE)
    cmake_language(DEFER CALL binnacle_apply_tiers)
  endif()
endmacro()

# binnacle_catch_tests(TARGET LABEL): the cases of an executable as one test, "LABEL: cases"; those that tiers.txt gives
# another tier, by lines "LABEL: cases: PATTERN", as a second one, "LABEL: cases, TIER".
function(binnacle_catch_tests target label)
  binnacle_tiers()
  file(APPEND "${BINNACLE_EXECUTABLES_FILE}" "${label} ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/${target}\n")
  binnacle_tier_of("${label}: cases" own_tier units)
  set(others "")
  set(other_units 0)
  set(without_others "")
  foreach(line_tier line_units pattern IN ZIP_LISTS BINNACLE_TIERS BINNACLE_TIER_UNITS BINNACLE_TIER_PATTERNS)
    if(pattern MATCHES "^${label}: cases: (.*)$" AND NOT line_tier STREQUAL own_tier)
      string(REPLACE "," "\\," pattern "${CMAKE_MATCH_1}")
      list(APPEND others "${pattern}")
      list(APPEND without_others "~${pattern}")
      set(other_tier ${line_tier})
      string(REGEX REPLACE "[.].*" "" line_units "${line_units}")
      math(EXPR other_units "${other_units} + ${line_units} + 1")
    endif()
  endforeach()
  list(APPEND without_others ${BINNACLE_CASES_LEFT_OUT})  # set by a folder for one preset
  binnacle_add_catch_test("${label}: cases" ${target} ${label} "${units}" "${without_others}")
  if(others)
    list(JOIN others "," others)  # Catch2's "or"
    binnacle_add_catch_test("${label}: cases, ${other_tier}" ${target} ${label} "${other_units}" "${others}")
  endif()
endfunction()

function(binnacle_add_catch_test name target label units patterns)
  # A unit takes some eight seconds; on a busy machine several times as long.
  string(REGEX REPLACE "[.].*" "" units "${units}")
  math(EXPR timeout "300 + 40 * ${units}")
  binnacle_timeout(timeout ${timeout})
  string(REGEX REPLACE "[^a-z0-9_]+" "_" file "${name}")
  add_test(NAME "${name}" COMMAND ${target} ${patterns} ${no_tests_is_failure})
  set_tests_properties("${name}" PROPERTIES LABELS ${label} TIMEOUT ${timeout} COST ${units} SKIP_RETURN_CODE 77
    ENVIRONMENT "BINNACLE_JUNIT=${BINNACLE_JUNIT_FOLDER}/${file}.xml")
endfunction()
