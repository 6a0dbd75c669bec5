// SPDX-License-Identifier: Apache-2.0
// What the command prints where: results to stdout, diagnostics to stderr, and the exit status that goes with them.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/diagnostic.hpp"

namespace binnacle::command {

using Json = nlohmann::ordered_json;

/// What the process returns, besides Error::exit_status().
enum ExitStatus { ok = 0, failed = 1, usage = 2, config = 3, load = 4, data = 5 };

/// The command line is wrong, or names a file that cannot be written: exit status 2.
class UsageError : public std::runtime_error {
 public:
  explicit UsageError(const std::string& message) : std::runtime_error(message) {}
};

/// A result could not be written to its end (disk full): exit status 5.
class OutputError : public std::runtime_error {
 public:
  explicit OutputError(const std::string& message) : std::runtime_error(message) {}
};

/// First of all: a standard stream that is closed is held open, on /dev/null for reading, so that no file of results is given
/// its number. What is printed on it fails as before.
void hold_standard_streams();

bool stderr_is_terminal();
/// A line, or with `is_whole` false a part of one. Where nobody can read it nothing else is lost: what fails is no error.
void to_stderr(std::string_view line, bool is_whole = true);

/// The command as it was typed, which messages repeat with the option that it lacks.
void keep_command_line(int argc, const char* const* argv);
/// Its words without the program's name.
const std::vector<std::string>& command_words();

/// To stdout, control characters but those of lines and tabs made visible.
void print(std::string_view text);
void print_json(const Json& json);
/// Throws OutputError when stdout did not take everything.
void flush_stdout();

/// "error: message", coloured on a terminal.
void print_error(const std::string& message);
/// "note: message" to stderr.
void print_note(const std::string& message);
/// Errors and warnings, one per line as to_string writes them, then their number: "2 errors, 1 warning".
void print_diagnostics(const Diagnostics& diagnostics);
/// One of them at once.
void print_diagnostic(const Diagnostic& diagnostic);
/// As above, with no more than a few of each code; `hint` says where the rest stands.
void print_abridged(const Diagnostics& diagnostics, const std::string& hint);

Json to_json(const Diagnostics& diagnostics);

}  // namespace binnacle::command
