// SPDX-License-Identifier: Apache-2.0
// Source, Transform, Sink: where samples come from, what is made of them, where they go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/sample.hpp"

namespace binnacle {

enum class SourceStatus { sample, wait, end, error };

/// What open() and next() found worth telling: gaps, repaired values. Kept by the kernel with the run's summary.
class Reporter {
 public:
  virtual ~Reporter() = default;
  /// `code` is a warning code of the reference (B065 …); file and line where it was seen, line 0 for the whole file.
  virtual void warn(const std::string& code, const std::string& file, int line, const std::string& message) = 0;
};

/// Emits samples in order of time. After open() it is immutable: cursor and random state lie in `memory`.
///
/// The constructor must be cheap and check what can be checked without reading everything (the file exists, its header
/// has the columns), so that `binnacle check` can use it. open() reads; it is called once before the first next() and
/// may throw ComponentError::in_data.
class Source {
 public:
  virtual ~Source() = default;

  virtual const std::vector<ChannelDeclaration>& channels() const noexcept = 0;
  virtual void open(Reporter& /*reporter*/) {}
  virtual std::size_t memory_bytes() const noexcept = 0;
  /// Initialises memory. `seed` is unique to (study seed, run, this component); equal seeds give equal samples.
  virtual void start(std::uint64_t seed, std::byte* memory) const = 0;
  /// Writes the next sample into slots[channel] and sets channel. Times never decrease. `wait`: nothing yet (live input).
  virtual SourceStatus next(std::byte* memory, SampleSlot* slots, int& channel) const = 0;
};

/// Receives what a transform makes of a sample.
class Emitter {
 public:
  virtual ~Emitter() = default;
  /// The slot of an output channel, cleared to NaN; fill it and call emit(). One sample per channel and call of on().
  virtual SampleSlot& slot(int channel) = 0;
  virtual void emit(int channel) = 0;
};

/// Makes samples of samples: detectors, coarse alignment, rotations. Immutable after open().
class Transform {
 public:
  virtual ~Transform() = default;

  virtual const std::vector<ChannelDeclaration>& channels() const noexcept = 0;
  virtual std::size_t memory_bytes() const noexcept = 0;
  virtual void start(std::uint64_t /*seed*/, std::byte* /*memory*/) const {}
  /// input: index into ComponentSpec::inputs.
  virtual void on(int input, const SampleView& sample, std::byte* memory, Emitter& emitter) const = 0;
};

/// Takes samples out of the composition: recorders, live output. The one component with a life outside the arena.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void open() {}
  virtual void on(int input, const SampleView& sample) = 0;
  virtual void close() {}
};

}  // namespace binnacle
