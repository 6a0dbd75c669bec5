// SPDX-License-Identifier: Apache-2.0
// Steps between the times of samples: the usual one, and those that are too long.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

#include "binnacle/time.hpp"

namespace binnacle::csv {

struct Step {
  Time from = 0;
  Time length = 0;
  int line = 0;  // of the sample at its end
};

/// What a pass over all samples calls for each step between two of them, in their order.
using StepVisitor = std::function<void(const Step&)>;
using StepPass = std::function<void(const StepVisitor&)>;

class Gaps {
 public:
  explicit Gaps(Time longer_than) : max_(longer_than) {}

  /// So many steps of this length, of which `first` is the first.
  void add(const Step& first, std::size_t count = 1);
  bool any() const { return count_ > 0; }
  /// Where they begin to be one: a line of the file.
  int line() const { return first_.line; }
  std::string message() const;

 private:
  Time max_;
  std::size_t count_ = 0;
  Time total_ = 0;
  Step first_, longest_;
};

/// The median of steps in bounded memory, exact whatever they are: each length is counted by itself as long as there are few of
/// them, else in classes of a thousandth of their length, within which further passes look.
class StepCounts {
 public:
  /// `most`: lengths that are counted each by itself.
  explicit StepCounts(std::size_t most) : most_(most) {}

  void add(const Step& step);
  std::uint64_t count() const { return count_; }
  /// Of count / 2 steps and no more that are shorter; there must be one. `pass`: over the same steps once more.
  Time median(const StepPass& pass) const;
  /// False: lengths were not kept, and a pass is needed.
  bool collect(Gaps& gaps) const;

 private:
  struct Length {
    Step first;
    std::uint64_t count = 0;
  };
  /// Lengths from `low` on, `width` of them, of which the `rank`th (from 0) is wanted.
  struct Range {
    std::uint64_t low = 0, width = 1, rank = 0;
  };

  void classify();
  Range find_class() const;

  std::size_t most_;
  std::uint64_t count_ = 0;
  std::unordered_map<Time, Length> lengths_;
  Length* last_ = nullptr;
  std::vector<std::uint64_t> classes_;  // empty: lengths are counted each by itself
};

}  // namespace binnacle::csv
