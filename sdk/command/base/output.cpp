// SPDX-License-Identifier: Apache-2.0
#include "output.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "table.hpp"
#include "verbs.hpp"
#include "wording/diagnostics_json.hpp"
#include "wording/wording.hpp"

namespace binnacle::command {

namespace {

bool has_colour() {
  const char* const wish = std::getenv("NO_COLOR");
  return stderr_is_terminal() && !(wish && *wish);
}

std::string coloured(const std::string& text, Severity severity) {
  return (severity == Severity::error ? "\x1b[1;31m" : "\x1b[1;33m") + text + "\x1b[0m";
}

/// Names and titles of a config are anybody's.
std::string safe(std::string_view text) { return wording::visible(text, "\n\t"); }

std::string line_of(const Diagnostic& diagnostic) {
  std::string line = safe(to_string(diagnostic));
  if (!has_colour()) return line;
  std::string mark = diagnostic.severity == Severity::error ? "error" : "warning";
  if (!diagnostic.code.empty()) mark += "[" + diagnostic.code + "]";
  const auto at = line.find(mark);
  if (at != std::string::npos) line.replace(at, mark.size(), coloured(mark, diagnostic.severity));
  return line;
}

std::string count_line(const Diagnostics& diagnostics) {
  std::size_t errors = 0, warnings = 0;
  for (const auto& item : diagnostics.items()) ++(item.severity == Severity::error ? errors : warnings);
  std::string line = errors ? counted(errors, "error") : "";
  if (warnings) line += (line.empty() ? "" : ", ") + counted(warnings, "warning");
  return line;
}

/// Why stdout took no more, the first time; 0: it took all.
int stdout_fault = 0;

void to_stdout(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() && stdout_fault == 0) stdout_fault = errno;
}

std::vector<std::string>& kept_words() {
  static std::vector<std::string> kept;
  return kept;
}

std::string command_line() {
  std::string line = "binnacle";
  for (const auto& word : kept_words()) line += " " + shell_quoted(word);
  return line;
}

}  // namespace

void hold_standard_streams() {
  // The lowest number that is free is the one that was found closed. Without /dev/null there is nothing to be done.
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0 && ::open("/dev/null", O_RDONLY) != stream) return;
}

void to_stderr(std::string_view line, bool is_whole) {
  std::fwrite(line.data(), 1, line.size(), stderr);
  if (is_whole) std::fputc('\n', stderr);
  std::fflush(stderr);
}

void keep_command_line(int argc, const char* const* argv) {
  kept_words().assign(argv + std::min(argc, 1), argv + argc);
}

const std::vector<std::string>& command_words() { return kept_words(); }

bool stderr_is_terminal() { return isatty(STDERR_FILENO) == 1; }

void print(std::string_view text) { to_stdout(safe(text)); }

void print_json(const Json& json) { to_stdout(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"); }

void flush_stdout() {
  if (std::fflush(stdout) != 0 && stdout_fault == 0) stdout_fault = errno;
  if (stdout_fault != 0) throw OutputError(fmt::format("stdout could not be written: {}", std::strerror(stdout_fault)));
  if (std::ferror(stdout)) throw OutputError("stdout could not be written");  // by a library, which kept no reason
}

void print_error(const std::string& message) {
  to_stderr((has_colour() ? coloured("error", Severity::error) : "error") + ": " + safe(message));
}

void print_note(const std::string& message) { to_stderr("note: " + safe(message)); }

void print_diagnostics(const Diagnostics& diagnostics) {
  if (diagnostics.empty()) return;
  for (const auto& item : diagnostics.sorted()) to_stderr(line_of(item));
  to_stderr(count_line(diagnostics));
  const auto is_untrusted = [](const Diagnostic& item) { return item.code == "B048"; };
  if (std::ranges::any_of(diagnostics.items(), is_untrusted))
    print_note("to run that code: " + command_line() + " --allow-plugins");
}

void print_diagnostic(const Diagnostic& diagnostic) { to_stderr(line_of(diagnostic)); }

void print_abridged(const Diagnostics& diagnostics, const std::string& hint) {
  constexpr std::size_t most_of_a_code = 3;
  if (diagnostics.empty()) return;
  std::map<std::string, std::size_t> seen;
  std::size_t left_out = 0;
  for (const auto& item : diagnostics.sorted()) {
    if (++seen[item.code] <= most_of_a_code || item.severity == Severity::error)
      to_stderr(line_of(item));
    else
      ++left_out;
  }
  to_stderr(count_line(diagnostics) + (left_out ? fmt::format(" ({} not shown; {})", left_out, hint) : ""));
}

Json to_json(const Diagnostics& diagnostics) { return wording::to_json(diagnostics); }

}  // namespace binnacle::command
