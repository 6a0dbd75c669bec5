// SPDX-License-Identifier: Apache-2.0
// What a call of the C interface catches, and where it keeps it.
#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include "binnacle.h"
#include "binnacle/diagnostic.hpp"

namespace binnacle::c {

/// A wrong argument: BINNACLE_USAGE.
class UsageError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// A name that the composition does not have: BINNACLE_USAGE, with the diagnostics of the look-up.
class UnknownName : public Error {
 public:
  explicit UnknownName(const Error& error) : Error(BINNACLE_USAGE, error.diagnostics()) {}
};

/// Keeps the exception that is being handled as this thread's last error; its status.
binnacle_status keep_exception(const char* function) noexcept;

/// Every function that can fail: no exception leaves it. `function` heads the messages about its arguments.
template <class Call>
binnacle_status guarded(const char* function, Call&& call) noexcept {
  try {
    call();
    return BINNACLE_OK;
  } catch (...) {
    return keep_exception(function);
  }
}

/// JSON text of diagnostics.
std::string json_text(const Diagnostics& diagnostics);

template <class Pointee>
Pointee& not_null(Pointee* pointer, const char* name) {
  if (!pointer) throw UsageError(std::string(name) + " is null");
  return *pointer;
}

/// Structs that begin with their size: no caller's is smaller than now, and none is that large.
inline constexpr std::uint64_t largest_struct = 4096;

template <class Struct>
void check_size(const Struct* given, const char* name) {
  const std::uint64_t size = not_null(given, name).size;
  if (size < sizeof(Struct) || size > largest_struct)
    throw UsageError(std::string(name) + "->size is " + std::to_string(size) + "; set it to sizeof, " +
                     std::to_string(sizeof(Struct)));
}

/// A struct that the caller filled in. What is beyond the known part must be zero: else it asks for what is not known here.
template <class Struct>
Struct taken(const Struct* given, const char* name) {
  check_size(given, name);
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  for (std::uint64_t i = sizeof(Struct); i < given->size; ++i)
    if (bytes[i] != 0)
      throw UsageError(std::string(name) + " has a part that this version of the library does not know");
  return *given;
}

/// Fills in the caller's struct, which keeps its size; what is beyond the known part becomes zero.
template <class Struct>
void give(Struct* into, Struct content) {
  content.size = into->size;
  auto* const bytes = reinterpret_cast<unsigned char*>(into);
  std::memset(bytes + sizeof(Struct), 0, static_cast<std::size_t>(content.size - sizeof(Struct)));
  std::memcpy(bytes, &content, sizeof(Struct));
}

}  // namespace binnacle::c
