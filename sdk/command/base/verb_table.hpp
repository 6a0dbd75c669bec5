// SPDX-License-Identifier: Apache-2.0
// All verbs of the command, and the program beside it that carries each out.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

namespace binnacle::command {

struct KnownVerb {
  std::string_view name;
  std::string_view summary;  // the line of `binnacle --help`
  std::string_view module;   // a program in the command's folder; "": the command itself
};

/// In the order of `binnacle --help`.
std::span<const KnownVerb> known_verbs();
/// Null where there is no such verb.
const KnownVerb* known_verb(std::string_view name);

/// The subcommand of a known verb, with its summary.
CLI::App* add_verb(CLI::App& command, std::string_view name);

/// Replaces this process by the module, which gets `words` as its arguments and keeps this process's number, streams and
/// ignored signals. Throws UsageError where it cannot be run: `what` ("'tune'") is what this build then lacks.
[[noreturn]] void hand_over(std::string_view module, const std::string& what, const std::vector<std::string>& words);
/// The same for a verb, whose name is the first of the words.
[[noreturn]] void hand_over(const KnownVerb& verb, std::vector<std::string> words);

}  // namespace binnacle::command
