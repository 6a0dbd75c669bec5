// SPDX-License-Identifier: Apache-2.0
// A shared library as a file: what it exports and what its guard says, before any of its code may run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/abi.hpp"

namespace binnacle::plugin {

inline constexpr const char* guard_symbol = "binnacle_guard_v1";
inline constexpr const char* register_symbol = "binnacle_register_v1";

struct LibraryFile {
  std::string unreadable;             // why it cannot be read as a library of this machine; "" when it can
  std::string other_guard;            // "binnacle_guard_v2" where there is one of another version
  std::vector<std::string> exported;  // symbols that other libraries could bind to
  bool has_register = false;          // exports register_symbol
  std::optional<abi::Guard> guard;    // as it lies in the file; its unread tail is zero when it is a shorter one
};

/// Reads the dynamic symbol table, which a stripped library has as well (Boost.DLL's library_info up to 1.8x reads the
/// static one, and bounds nothing). Never throws for what the file holds.
LibraryFile inspect_library(const std::filesystem::path& file);

}  // namespace binnacle::plugin
