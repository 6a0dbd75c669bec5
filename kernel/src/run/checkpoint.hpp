// SPDX-License-Identifier: Apache-2.0
// Checkpoints of a run: all that it is between two instants, as bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "binnacle/run.hpp"
#include "run/runtime.hpp"

namespace binnacle::internal::runtime {

/// Keeps checkpoints of one run as RunOptions::checkpoints asks, and takes one in.
class Checkpointing {
 public:
  /// exchange: of all that the run is beside the Runtime.
  Checkpointing(Runtime& runtime, std::uint64_t composition, const RunOptions& options,
                std::function<void(StateBytes& bytes)> exchange);

  /// Before the first instant: goes on where the run was left, and keeps the first.
  void begin();
  void after_instant() {
    if (options_.checkpoints.keeper && runtime_.time() >= next_) keep();
  }

 private:
  struct Head;
  Head head(std::uint64_t size) const;
  void exchange(StateBytes& bytes);
  void keep();
  void resume();
  void restore(std::span<const std::byte> from);

  Runtime& runtime_;
  std::uint64_t composition_;
  std::uint64_t data_ = 0;  // checksum of the files of its sources
  const RunOptions& options_;
  std::function<void(StateBytes& bytes)> exchange_;
  Time next_ = no_time;
  std::vector<std::byte> bytes_;
};

}  // namespace binnacle::internal::runtime
