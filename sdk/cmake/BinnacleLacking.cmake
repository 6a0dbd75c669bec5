# SPDX-License-Identifier: Apache-2.0
# binnacle_lacks(): configuring succeeds with the packages of section `run` of sdk/packages.txt alone. What needs others is
# left out aloud, and its target, if it is asked for, fails with the line that installs them.
include_guard(GLOBAL)

# One line for each target, by which sdk/run and tests/run know that configuring again may find more.
file(WRITE "${PROJECT_BINARY_DIR}/left_out.txt" "")

# binnacle_lacks(TARGET SECTION PACKAGE…): PACKAGE… of that section are missing. Whoever may do without TARGET leaves it out.
function(binnacle_lacks target section)
  list(JOIN ARGN " " packages)
  set(command "sdk/run --all")
  if(section STREQUAL "python")
    set(command "sdk/run --python")
  elseif(section STREQUAL "tests")
    set(command "tests/run")
  endif()
  set(text "${target}, without all of the Debian packages ${packages} (section ${section} of sdk/packages.txt); ${command} installs them")
  message(STATUS "Left out: ${text}")
  file(APPEND "${PROJECT_BINARY_DIR}/left_out.txt" "${text}\n")
  set_property(GLOBAL APPEND PROPERTY BINNACLE_LACKING ${target})
  # An optional module has no target then: what installs it asks for that.
  if(NOT target STREQUAL "binnacle_mpi")
    add_custom_target(${target}
      COMMAND "${CMAKE_COMMAND}" -E echo "Left out when this was configured: ${text}"
      COMMAND "${CMAKE_COMMAND}" -E false
      VERBATIM)
  endif()
endfunction()
