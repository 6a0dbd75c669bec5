// SPDX-License-Identifier: Apache-2.0
// What a fuzz target is: a function of bytes that returns, whatever they are. An answer may be an error with a message; what
// must not come is a crash, a hang, undefined behaviour, memory without bound, or another exception.
#pragma once

#include <cstddef>
#include <string_view>

namespace binnacle::fuzz {

/// Defined by each target.
void try_bytes(std::string_view bytes);

/// Structure-aware: another input made of this one, at most `capacity` bytes into `out`; 0: change the bytes instead.
/// Targets of JSON define it in json_mutation.cpp, the others in byte_mutation.cpp.
std::size_t mutate(std::string_view bytes, unsigned seed, char* out, std::size_t capacity);

}  // namespace binnacle::fuzz
