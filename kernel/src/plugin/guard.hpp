// SPDX-License-Identifier: Apache-2.0
// The host's half of the ABI guard: its own values, and the comparison field by field.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "binnacle/abi.hpp"

namespace binnacle::abi {

enum class Severity { warned, refused };

/// One field in which host and plugin differ.
struct Difference {
  std::string field;
  std::string host;
  std::string plugin;
  Severity severity = Severity::refused;
  std::string remedy;  // one line
};

/// What this program was compiled with.
const Guard& guard_of_host();

/// Nothing when they agree. Magic or size wrong: that alone, the rest being unreadable. `host_supports`: instruction
/// sets that this processor has.
std::vector<Difference> compare(const Guard& host, const Guard& plugin, std::uint64_t host_supports);

/// Instruction sets of the processor at hand, as bits of Guard::instruction_sets.
std::uint64_t processor_instruction_sets();

/// "sizeof(ComponentSpec): host 400, plugin 392; rebuild …"
std::string to_string(const Difference& difference);

/// Every field but the table of types as readable text.
std::vector<std::pair<std::string, std::string>> fields_of(const Guard& guard);

/// The text in a fixed array, which may lack its final zero.
template <std::size_t N>
std::string text_of(const char (&text)[N]) {
  const std::string_view view(text, N);
  return std::string(view.substr(0, view.find('\0')));
}

}  // namespace binnacle::abi
