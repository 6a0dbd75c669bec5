// SPDX-License-Identifier: Apache-2.0
// Runs the checks of a library, each in its own process with a time limit, prerequisites first.
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
  std::string message;
  double seconds = 0;
  bool is_wanted = true;  // false: it ran only because another check needs it
};

struct Component {
  Role role = Role::state_block;
  std::string type;
};

struct Verdict {
  std::string enumeration;  // why the components could not be told; "" when they could
  std::vector<Component> components;
  std::vector<Outcome> outcomes;  // by component, then in the order of the checks

  int count(Status status) const;
  /// Nothing failed, crashed or ran out of time, every component was told, and something that was asked for ran.
  bool passes(bool warnings_fail) const;
};

/// `progress`: after each check.
Verdict run_checks(const Options& options, const std::function<void(const Outcome&)>& progress);

}  // namespace binnacle::conform
