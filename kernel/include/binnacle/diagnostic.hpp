// SPDX-License-Identifier: Apache-2.0
// Diagnostics: what is wrong, where it stands, and the errors that carry it.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace binnacle {

/// A place in a file. line and column count from 1; 0 means unknown. `--set` and `--var` stand in for a file.
struct Origin {
  std::string file;
  int line = 0;
  int column = 0;

  bool operator==(const Origin&) const = default;
};

/// An error stops what was asked for, a warning does not.
enum class Severity { error, warning };

/// One error or warning: its code, its place and a message.
struct Diagnostic {
  Severity severity = Severity::error;
  std::string code;  ///< "B012"; every code is explained in sdk/docs/diagnostics.md
  Origin origin;
  std::string pointer;  ///< JSON pointer into the resolved config; empty where there is none
  std::string message;  ///< one line, no full stop

  bool operator==(const Diagnostic&) const = default;
};

/// `file.json:14:9: error[B012] /filters/ins: message`; what is unknown is left out.
std::string to_string(const Diagnostic& diagnostic);

/// A collection without duplicates: everything that is wrong is reported at once.
class Diagnostics {
 public:
  Diagnostics() = default;
  explicit Diagnostics(Diagnostic only) { add(std::move(only)); }
  void add(Diagnostic diagnostic);
  void error(std::string code, Origin origin, std::string pointer, std::string message);
  void warning(std::string code, Origin origin, std::string pointer, std::string message);
  void merge(const Diagnostics& other);

  bool has_errors() const;
  bool empty() const { return items_.empty(); }
  /// In the order of arrival.
  const std::vector<Diagnostic>& items() const { return items_; }
  /// By file, line and column; those of one place in the order of arrival.
  std::vector<Diagnostic> sorted() const;
  /// sorted(), one per line, without a final newline.
  std::string text() const;

 private:
  std::vector<Diagnostic> items_;
};

/// Base of what the kernel throws; what() is diagnostics().text().
class Error : public std::runtime_error {
 public:
  Error(int exit_status, Diagnostics diagnostics);

  int exit_status() const { return exit_status_; }
  const Diagnostics& diagnostics() const { return diagnostics_; }

 private:
  int exit_status_;
  Diagnostics diagnostics_;
};

/// An Error with one exit status of the command.
template <int status>
class ErrorOf : public Error {
 public:
  explicit ErrorOf(Diagnostics diagnostics) : Error(status, std::move(diagnostics)) {}
  explicit ErrorOf(Diagnostic diagnostic) : Error(status, Diagnostics(std::move(diagnostic))) {}
};

using FilterError = ErrorOf<1>;  ///< a filter broke or a check failed: exit status 1
using ConfigError = ErrorOf<3>;  ///< the config is wrong: exit status 3
using LoadError = ErrorOf<4>;    ///< a plugin cannot be loaded: exit status 4
using DataError = ErrorOf<5>;    ///< data are missing or unusable: exit status 5

/// The candidate that was most likely meant by `name`, or "" if none is near. Case and `-`/`_` hardly count;
/// a transposition counts less than another edit, and a name cut short or run on is near its whole.
std::string closest(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace binnacle
