// SPDX-License-Identifier: Apache-2.0
// Source, Transform, Sink: where samples come from, what is made of them, where they go.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/declaration.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/state_bytes.hpp"

namespace binnacle {

/// What Source::next() answers: a sample, none yet (live), none any more, or data that it cannot read.
enum class SourceStatus { sample, wait, end, error };

/// What a source or a sink found worth a warning: gaps, repaired values, lines that a slow receiver lost. Kept by the kernel
/// with the run's summary, and lives as long as the component's last call.
class Reporter {
 public:
  virtual ~Reporter() = default;
  /// `code` is a warning code of the reference (B065 …); file and line where it was seen, line 0 for the whole file.
  virtual void warn(const std::string& code, const std::string& file, int line, const std::string& message) = 0;
};

/// What a bound transform emits and remembers; a source says besides whether it is live.
struct StreamDeclaration : MemoryDeclaration {
  std::vector<ChannelDeclaration> channels;

  OutputChannel emits(ChannelDeclaration channel) {
    channels.push_back(std::move(channel));
    return OutputChannel(static_cast<int>(channels.size()) - 1);
  }
};
/// What a bound source emits and remembers.
struct SourceDeclaration : StreamDeclaration {
  bool live = false;  // samples come as they are measured: next() may answer `wait`
};

/// The sample that a call of Source::next() gives.
class SourceOutput {
 public:
  /// The kernel's: a writer per channel.
  constexpr explicit SourceOutput(SampleWriter* by_channel) noexcept : by_channel_(by_channel) {}

  /// The sample is on this channel. One a call; all numbers are NaN at first.
  SampleWriter& on(OutputChannel channel) noexcept {
    channel_ = channel.index();
    return by_channel_[channel_];
  }
  /// −1: none was chosen.
  constexpr int channel() const noexcept { return channel_; }

 private:
  SampleWriter* by_channel_;
  int channel_ = -1;
};

/// How a live source fares.
struct SourceFigures {
  Time arrival = no_time;     // of the newest sample that it gave, on the monotonic clock; no_time: when it was asked
  std::int64_t waiting = 0;   // samples that came and were not asked for yet
  std::int64_t lost = 0;      // came, and could not be kept
  std::int64_t unusable = 0;  // came, and were no samples
};

/// Emits samples in order of time. After open() it is immutable: cursor and random state lie in its memory.
///
/// The constructor fills `declaration_`. It must be cheap and check what can be checked without reading everything (the
/// file exists, its header has the columns), so that `binnacle check` can use it. open() reads; it is called once before
/// the first next() and may throw ComponentError::in_data.
class Source : public DeclaredModel<SourceDeclaration, std::uint64_t> {
 public:
  virtual void open(Reporter& /*reporter*/) {}
  /// The next sample. Times never decrease. `wait`: nothing yet (live input); it does not block.
  virtual SourceStatus next(const MemoryView& memory, SourceOutput& out) const = 0;
  /// Of a live source, once it is open: a file descriptor that poll() finds readable when next() may give more than `wait`;
  /// −1: none, it is asked every few milliseconds.
  virtual int wait_handle() const { return -1; }
  virtual SourceFigures figures() const { return {}; }
};

/// Receives what a transform makes of a sample.
class Emitter {
 public:
  virtual ~Emitter() = default;
  /// A sample on this channel, cleared to NaN; fill it and call emit(). One per channel and call of Transform::on().
  virtual SampleWriter& on(OutputChannel channel) = 0;
  virtual void emit(OutputChannel channel) = 0;
  /// What was emitted comes once more, after all that this instant brings about.
  virtual void emit_again(OutputChannel channel) = 0;
};

/// What Transform::on() is given: one sample of one of its inputs.
struct TransformInput {
  Input from;         // a handle of Binding::input()
  SampleView sample;  // the fields declared for it
  MemoryView memory;
};

/// Makes samples of samples: detectors, coarse alignment, rotations. Immutable. The constructor fills `declaration_`.
class Transform : public DeclaredModel<StreamDeclaration, std::uint64_t> {
 public:
  virtual void on(const TransformInput& in, Emitter& out) const = 0;
  /// Why it has emitted nothing yet, with figure and limit, for a filter that waited in vain; empty: unknown.
  virtual std::string waits_for(const MemoryView& /*memory*/) const { return {}; }
};

/// Takes samples out of the composition: recorders, live output. The one component with a life outside the arena.
class Sink {
 public:
  virtual ~Sink() = default;
  /// Before open(), in every run: where its warnings go until close() has returned, from the thread that calls it.
  virtual void report_to(Reporter& /*reporter*/) {}
  virtual void open() {}
  virtual void on(Input from, const SampleView& sample) = 0;
  virtual void close() {}
  /// For checkpoints of a run: what it is now; read back after open(), it goes on from there, and what was written later is
  /// gone. What is sent to others can not be taken back. False: it knows no way, and no checkpoint is made.
  virtual bool exchange(StateBytes& /*bytes*/) { return false; }
};

}  // namespace binnacle
