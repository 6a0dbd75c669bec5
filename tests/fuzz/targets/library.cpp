// SPDX-License-Identifier: Apache-2.0
// What is read of a plugin file before any of its code runs: ELF, the guard, the list of types.
#include "plugin/library.hpp"
#include "../reader.hpp"
#include "binnacle/catalog.hpp"

void binnacle::fuzz::try_bytes(std::string_view bytes) {
  static const test::Folder folder;
  const std::string file = folder.write("plugin.so", std::string(bytes));
  const auto found = internal::plugin::inspect_library(internal::plugin::OpenFile(file));
  Diagnostics diagnostics;
  internal::plugin::examine_plugin(file, {}, diagnostics);
  // One that agrees in every byte of its guard may be loaded; all others are refused with words.
  if (!found.guard && diagnostics.empty()) throw std::logic_error("a library without a guard was not refused");
}
