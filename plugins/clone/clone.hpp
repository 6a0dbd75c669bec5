// SPDX-License-Identifier: Apache-2.0
// A copy of blocks as they were at an instant.
#pragma once

#include <array>
#include <vector>

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::clone {

/// Stochastic cloning (Roumeliotis and Burdick, ICRA 2002, section III): in a step from t₀ that begins at an instant to be
/// kept,
///     c⁺ = x(t₀)    δc⁺ = δx(t₀):  Φ(c, x) = I, Φ(c, c) = 0, Qd = 0
/// and in every other step c⁺ = c. P is singular then until x has moved: its rank is less by the dof of c.
///
/// The first step keeps its t₀. After that, an instant to be kept is the time of a sample on `at`, or the first at least
/// `every` after the last one. The copy is made by the first step that begins at it or later, so that all that was measured
/// at that instant is in it. Since a step may be taken only when the next sample has come, the times of samples wait in
/// memory, and a step that begins where the newest sample's interval begins makes a copy too.
class Clone final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit Clone(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 private:
  struct Pair {
    Port of, copy;
    PhiBlock by_of, by_copy;
  };
  struct Memory {
    Time copied = no_time;  // when the copy was made
    Time newest = no_time;  // of the samples of `at` that were seen
    std::int64_t count = 0;
    std::array<Time, 64> waiting{};  // instants to be kept, of samples ahead of the filter
  };

  bool is_due(const ProcessInput& in, Memory& memory) const;

  std::vector<Pair> pairs_;
  Port age_;  // open: nobody wants to know
  PhiBlock age_by_age_;
  Input at_;
  Time every_ = 0;  // 0: by samples only
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::clone
