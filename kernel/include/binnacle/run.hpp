// SPDX-License-Identifier: Apache-2.0
// run: a composition with its sources, from the first sample to the last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/session.hpp"
#include "binnacle/state_bytes.hpp"

namespace binnacle {

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
  /// At once: a new note of a model (B083), or of a sample that is invalid. RunResult::warnings has them too, with their
  /// number.
  virtual void noted(const Diagnostic& /*note*/) {}
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
  Time every = 0;                                             // of the run's time, from one to the next
  std::function<void(std::span<const std::byte>)> keep = {};  // the first comes before the first instant; empty: none
  /// Taken in by run(): the run goes on there. Throws ConfigError (B084) with the reason where they are of another config,
  /// other data, plugins, options or kind of machine, or torn. Empty: the run begins at its beginning.
  std::span<const std::byte> from = {};
};

struct RunOptions {
  std::uint64_t seed = 1;
  int run = 0;  // random streams are keyed by (seed, run, component)
  RunObserver* observer = nullptr;
  Estimates estimates = Estimates::settled;  // what the observer sees of filters with `history`
  bool feeds_sinks = true;                   // false where several runs share the composition's sinks
  Checkpoints checkpoints = {};
};

struct RunResult {
  Diagnostics warnings;  // gaps and repairs in the data, notes of models
  Diagnostics failures;  // B080 broken, B081 never started; empty when all went well
};

/// In RunObserver::finished(): takes the run back to a snapshot that was made in after_instant(), and from there over so
/// many instants again, to its very end where they reach it. Channels that sections subscribe to are shown again;
/// sinks, notes and after_instant() are left alone. `each` is called after every instant, and once more after the end.
void rerun(Session& session, std::span<const std::byte> from, std::int64_t instants, const std::function<void()>& each);

/// Runs to the end of all sources. Throws DataError when data turn out unusable. Sources are opened on the first run of
/// a composition and stay open. Several threads may run one composition at a time.
RunResult run(const std::shared_ptr<const Composition>& composition, const RunOptions& options = {});

}  // namespace binnacle
