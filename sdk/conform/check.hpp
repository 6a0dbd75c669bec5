// SPDX-License-Identifier: Apache-2.0
// A check of the conformance suite: what it is called, what it applies to, and what it reports.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/catalog.hpp"

namespace binnacle::conform {

/// `skip` has a reason: a prerequisite failed, the check could not be tried, or it does not apply.
enum class Status { pass, warn, fail, crash, timeout, skip };
const char* status_name(Status status);

/// Where a check's process says what it found; read by the driver while it runs.
class Report {
 public:
  virtual ~Report() = default;
  virtual void failed(const std::string& message) = 0;
  virtual void warned(const std::string& message) = 0;
  /// What is being called, for the message when it crashes or never ends. Text with static lifetime.
  virtual void stage(const char* call) = 0;
};

/// Thrown by a check that could not be tried, or does not apply to this component; the reason stands in the report.
struct Skip {
  std::string reason;
  bool applies = true;
};

/// Thrown where Source::open refuses, which it may: what it reported, kept by the host.
class OpenRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One check of one component (or of the library, where `type` is empty), in a process of its own.
class Trial {
 public:
  /// of_library: "" where the component is of a plugin of the program, which the options name.
  Trial(std::filesystem::path of_library, std::string of_type, Role of_role, int at_level, std::uint64_t with_seed,
        std::filesystem::path in_scratch, Report& report, LoadOptions with_options = {})
      : library(std::move(of_library)),
        type(std::move(of_type)),
        role(of_role),
        level(at_level),
        seed(with_seed),
        scratch(std::move(in_scratch)),
        options(std::move(with_options)),
        report_(report) {}

  const std::filesystem::path library;
  const std::string type;  // "core/vector"
  const Role role;
  const int level;
  const std::uint64_t seed;
  const std::filesystem::path scratch;  // an empty folder that is removed afterwards
  const LoadOptions options;

  /// How often something random is tried: more on higher levels.
  int repeats(int at_level_5) const { return at_level_5 * level / 5 > 0 ? at_level_5 * level / 5 : 1; }
  std::mt19937_64 random(std::uint64_t stream) const { return std::mt19937_64(seed * 0x9e3779b97f4a7c15ull + stream); }

  template <class... Parts>
  void fail(const Parts&... parts) {
    has_failed_ = true;
    report_.failed(text(parts...));
  }
  template <class... Parts>
  void warn(const Parts&... parts) {
    report_.warned(text(parts...));
  }
  /// Fails with the message unless `holds`.
  template <class... Parts>
  bool expect(bool holds, const Parts&... parts) {
    if (!holds) fail(parts...);
    return holds;
  }
  bool has_failed() const { return has_failed_; }
  void stage(const char* call) { report_.stage(call); }
  /// What should hold could not be tried.
  [[noreturn]] static void skip(std::string reason) { throw Skip{std::move(reason), true}; }
  /// There is nothing that should hold.
  [[noreturn]] static void not_applicable(std::string reason) { throw Skip{std::move(reason), false}; }
  /// Fails with each; whether there was none.
  template <class Complaints>
  bool expect_none(const Complaints& complaints) {
    for (const auto& line : complaints.lines()) fail(line);
    return complaints.empty();
  }

 private:
  template <class... Parts>
  static std::string text(const Parts&... parts) {
    std::ostringstream line;
    line.precision(9);
    (line << ... << parts);
    return line.str();
  }

  Report& report_;
  std::atomic<bool> has_failed_ = false;  // by any thread of a check
};

struct Check {
  std::string id;                  // "numbers.process.jacobian": stable, with an entry in the reference
  int level = 1;                   // runs from this level on
  std::vector<Role> roles;         // empty: once for the library
  std::vector<std::string> needs;  // ids that must not have failed for the same component (or the library)
  std::string text;                // what holds when it passes, one line
  void (*run)(Trial&) = nullptr;
};

inline Check check(std::string id, int level, std::vector<Role> roles, std::vector<std::string> needs, std::string text,
                   void (*run)(Trial&)) {
  return {std::move(id), level, std::move(roles), std::move(needs), std::move(text), run};
}

/// All checks, prerequisites before what needs them.
const std::vector<Check>& all_checks();

std::vector<Check> load_checks();
std::vector<Check> metadata_checks();
std::vector<Check> life_checks();
std::vector<Check> block_checks();
std::vector<Check> process_checks();
std::vector<Check> measurement_checks();
std::vector<Check> derived_checks();
std::vector<Check> noise_checks();
std::vector<Check> stream_checks();
std::vector<Check> robustness_checks();
std::vector<Check> speed_checks();

}  // namespace binnacle::conform
