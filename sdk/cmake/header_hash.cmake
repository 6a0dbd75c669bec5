# SPDX-License-Identifier: Apache-2.0
# Writes OUTPUT, the hash of the public headers in FOLDER; leaves it alone while they are the same.
file(GLOB headers RELATIVE "${FOLDER}" "${FOLDER}/*.hpp")
list(SORT headers)
set(digests "")
foreach(header IN LISTS headers)
  file(SHA256 "${FOLDER}/${header}" digest)
  string(APPEND digests "${header} ${digest}\n")
endforeach()
string(SHA256 hash "${digests}")
string(SUBSTRING "${hash}" 0 16 hash)

set(text "// SPDX-License-Identifier: Apache-2.0
// Generated: the hash of the public headers that a plugin or host was compiled with.
#pragma once

#define BINNACLE_HEADER_HASH 0x${hash}ull
")
set(present "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" present)
endif()
if(NOT text STREQUAL present)
  file(WRITE "${OUTPUT}" "${text}")
endif()
