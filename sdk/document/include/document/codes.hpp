// SPDX-License-Identifier: Apache-2.0
// The one table of diagnostic codes, with the cause and the remedy of each.
#pragma once

#include <span>

namespace binnacle::document {

struct CodeEntry {
  const char* code;
  const char* title;
  const char* cause;
  const char* remedy;
};

/// Sorted by code.
std::span<const CodeEntry> diagnostic_codes();

}  // namespace binnacle::document
