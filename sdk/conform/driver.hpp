// SPDX-License-Identifier: Apache-2.0
// Runs the checks of a library, each in its own process with a time limit, prerequisites first; or one in this process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "check.hpp"

namespace binnacle::conform {

struct Options {
  std::filesystem::path library;
  int level = 5;
  std::uint64_t seed = 1;
  double time_limit = 60;  // seconds, of one check
  int jobs = 1;
  std::vector<std::string> filters;  // globs on "TYPE:CHECK"; none: everything
};

struct Outcome {
  std::string type;  // "core/vector"; "" for the library
  std::string role;
  std::string check;
  Status status = Status::pass;
  bool applies = true;  // false: skipped, because there is nothing that should hold
  std::string message;
  double seconds = 0;
  bool is_wanted = true;  // false: it ran only because another check needs it
};

struct Component {
  Role role = Role::state_block;
  std::string type;
};

struct Verdict {
  std::string enumeration;  // why the components could not be found out; "" when they could
  std::vector<Component> components;
  std::vector<Outcome> outcomes;  // by component, then in the order of the checks

  int count(Status status) const;
  int tried() const;
  int skipped() const;  // could not be tried, or a prerequisite failed
  int not_applicable() const;
  int failed() const;  // crashed and ran out of time included
  /// Components whose checks of numbers were asked for and apply, and none of them could be tried.
  std::vector<std::string> untried() const;
  /// Nothing failed, crashed or ran out of time, every component was found and has numbers that were tried, and
  /// something that was asked for ran.
  bool passes(bool warnings_fail) const;
};

/// Runs the one check of one component that the options' filters name, in this process: for a debugger. Its messages go
/// to stderr. Returns an exit status; throws std::invalid_argument where the filters name none, or several.
int run_in_process(const Options& options);

/// `progress`: after each check.
Verdict run_checks(const Options& options, const std::function<void(const Outcome&)>& progress);

}  // namespace binnacle::conform
