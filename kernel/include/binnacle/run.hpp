// SPDX-License-Identifier: Apache-2.0
// run: a composition with its sources, from the first sample to the last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/session.hpp"
#include "binnacle/state_bytes.hpp"

namespace binnacle {

/// A sample of a source on its way into a run.
struct Arrival {
  Time at = 0;       // since the begin of the run, by its clock [ns]; one for all that make an instant
  int channel = -1;  // -1: none, filters with a budget of `history` went on with what was left
  const SampleView* sample = nullptr;  // for the time of the call
  std::int64_t sequence = 0;           // among the samples of its source, where filters have `history`
};

/// What arrived in an earlier run, in place of the composition's sources.
class RecordedInput {
 public:
  virtual ~RecordedInput() = default;
  /// Begins the next instant; false: there is no further one.
  virtual bool next_instant() = 0;
  /// The next arrival of that instant, at most one a channel, valid until the next call; null: there is no further one.
  virtual const Arrival* next() = 0;
};

/// What a run that goes by the clock leaves of its own.
struct LiveFigures {
  /// Latency: from a sample's arrival (at a pace: from when it was due) until all that it brings about is done, records and
  /// observers included [s].
  struct Channel {
    std::string name;
    std::int64_t samples = 0;
    std::int64_t behind = 0;  // older than one before
    double p50 = 0, p99 = 0, longest = 0;
  };
  /// Samples of a live source: the most that waited at a time, how many were lost, how many unusable.
  struct Source {
    std::string name;
    std::int64_t longest_queue = 0, lost = 0, unusable = 0;
  };
  std::vector<Channel> channels;  // that samples arrived on
  std::vector<Source> sources;    // live ones
  double seconds = 0;             // from the first arrival to the end
};

/// Watches a run while it happens.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  /// Before the first sample. The session lives until finished() has returned; step observers are attached here.
  virtual void begin(Session& /*session*/) {}
  /// A sample on a channel that a section subscribes to, once its instant is done.
  virtual void sampled(int /*channel*/, const SampleView& /*sample*/) {}
  /// The same in order of time, once no sample can come before it: with filters that have `history`, and after what these
  /// settle at its time.
  virtual void settled(int /*channel*/, const SampleView& /*sample*/) {}
  /// At once: a new note of a model (B083), or of a sample that is invalid. RunResult::warnings has their number.
  virtual void noted(const Diagnostic& /*note*/) {}
  /// Whether arrived() is wanted.
  virtual bool wants_arrivals() const { return false; }
  /// A sample of a source arrived, before it is worked on.
  virtual void arrived(const Arrival& /*arrival*/) {}
  /// After each instant, and once more after the last.
  virtual void after_instant() {}
  /// Every now and then: the run's time. Return false to stop the run (it ends as if the data had).
  virtual bool progress(Time /*t*/) { return true; }
  /// All is done but closing the sinks.
  virtual void finished() {}
  /// For checkpoints: all that it keeps of the run so far. Read back after begin(), in a run with equal options.
  virtual void exchange(StateBytes& /*bytes*/) {}
};

/// What a run is at some instant, to go on from there later. A run that was resumed leaves what one leaves that was not
/// stopped, to the last bit; live sources go on with what arrives next.
struct Checkpoints {
  /// Takes each checkpoint as it is made, and keeps it where the run can find it again.
  struct Keeper {
    virtual ~Keeper() = default;
    virtual void keep(std::span<const std::byte> checkpoint) = 0;
  };
  Time every = 0;            // of the run's time, from one to the next
  Keeper* keeper = nullptr;  // the first comes before the first instant; null: none
  /// Taken in by run(): the run goes on there. Throws ConfigError (B084) with the reason where they are of another config,
  /// other data, plugins, options or kind of machine, or torn. Empty: the run begins at its beginning.
  std::span<const std::byte> from = {};
};

/// What run() takes besides the composition.
struct RunOptions {
  std::uint64_t seed = 1;
  int run = 0;  // random streams are keyed by (seed, run, component)
  RunObserver* observer = nullptr;
  Estimates estimates = Estimates::settled;  // what the observer sees of filters with `history`
  bool feeds_sinks = true;                   // false where several runs share the composition's sinks
  Checkpoints checkpoints = {};
  double pace = 0;  // of recorded data: so many seconds of them in one, as if live; 0: as fast as it goes
  RecordedInput* input = nullptr;  // null: the composition's sources, which else are not opened
};

/// What run() returns; estimates and figures go to its observer.
struct RunResult {
  Diagnostics warnings;             // gaps and repairs in the data, notes of models
  Diagnostics failures;             // B080 broken, B081 never started; empty when all went well
  std::optional<LiveFigures> live;  // of a run with live sources, at a pace, or whose observer wants arrivals
};

/// Whether rerun() can be: what live sources gave, or recorded input, does not come again.
bool can_rerun(const Session& session);

/// In RunObserver::finished(): takes the run back to a snapshot that was made in after_instant(), and from there over so
/// many instants again, to its very end where they reach it. Channels that sections subscribe to are shown again;
/// sinks and notes are left alone. Of the observer only after_instant() is called: after each instant and after the end.
void rerun(Session& session, std::span<const std::byte> from, std::int64_t instants, RunObserver& observer);

/// Runs to the end of all sources. Throws DataError when data turn out unusable. Sources are opened on the first run of
/// a composition and stay open. Several threads may run one composition at a time.
RunResult run(const std::shared_ptr<const Composition>& composition, const RunOptions& options = {});

}  // namespace binnacle
