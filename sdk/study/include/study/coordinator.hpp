// SPDX-License-Identifier: Apache-2.0
// Coordinator: a study carried out by a team. Rank 0 leads: it hands out runs, enters what comes back, and is the only one that
// prints or writes; the others serve.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

#include "study/study.hpp"
#include "study/team.hpp"
#include "study/workers.hpp"

namespace binnacle::study {

/// How soon one side misses the other. mpirun ends a job when a process of it dies; this is for what it cannot see: one that
/// is stopped, or a machine that hangs.
struct Timeouts {
  std::chrono::milliseconds sign_of_life{5000};  // each side gives one at least so often, while it loads too
  std::chrono::milliseconds silence{60000};      // after which the other is taken for dead
};

class Coordinator {
 public:
  explicit Coordinator(Team& team, Timeouts timeouts = {});
  /// Dismisses the others if that was not done.
  ~Coordinator();
  Coordinator(const Coordinator&) = delete;
  Coordinator& operator=(const Coordinator&) = delete;

  /// Reads the study of this process, and lets the others know meanwhile that it is alive.
  Study load(const std::function<Study()>& load);

  /// Waits until all have read their study. Throws Error where one could not, or has another study: another config, program
  /// or plugin, or a processor whose last digits differ; or where one is silent for too long. False once
  /// `goes_on` says so.
  bool assemble(const Study& study, const std::function<bool()>& goes_on);

  /// Of the others, all together.
  int threads() const;

  /// As study::carry_out_all(), with `jobs` threads of this process and those of the others. Throws Error where a rank is
  /// silent for too long.
  void carry_out_all(const Study& study, Results& results, int jobs, const std::function<bool()>& goes_on,
                     const OnRun& on_run);

  /// Lets the others go. Waits for them; false where one has not come to its end.
  bool dismiss();

 private:
  using Clock = std::chrono::steady_clock;
  struct Rank {
    bool has_reported = false;
    std::string machine;
    int jobs = 0;
    std::size_t given = 0;  // batches that it has not brought back
    Clock::time_point last_message;
    std::string trouble;  // why it cannot serve
    int status = 0;       // exit status of that
  };
  void take_report(const Study& study, int rank, const std::string& text);
  void refuse_troubled();
  void give_sign_of_life();
  void look_for_silent();
  void look_for_late();
  std::string name_of(int rank) const;

  Team& team_;
  Timeouts timeouts_;
  std::vector<Rank> ranks_;
  std::vector<Message> early_;  // reports of those that were sooner ready
  Clock::time_point last_sign_ = Clock::now(), last_look_ = Clock::now(), loaded_ = Clock::now();
  Clock::duration loading_{0};
  bool is_over_ = false;
};

/// What the others do: `load`, then runs until rank 0 dismisses them (true) or `goes_on` says no (false). Throws Error where
/// rank 0 is silent for too long.
bool serve(Team& team, const std::function<Study()>& load, int jobs, const std::function<bool()>& goes_on,
           Timeouts timeouts = {});

/// Of what this processor and C library make of sines, logarithms and the like: where it differs, last digits do.
std::uint64_t arithmetic_hash();

}  // namespace binnacle::study
