// SPDX-License-Identifier: Apache-2.0
// "every": several samples become one.
#pragma once

#include <cstddef>
#include <vector>

#include "block.hpp"
#include "layout.hpp"

namespace binnacle::csv {

/// Of levels every so many samples one stays, the first too, as it is. Samples with intervals are put together: the mean of
/// rates over the joint time, the sum of increments, the last of levels; a gap, and the end, closes a sample early, so that no
/// motion is lost.
class Thinner {
 public:
  /// `index`: of the first sample that it gets, among all of the file.
  Thinner(const Layout& layout, std::uint64_t index) : layout_(layout), index_(index), sums_(layout.columns.size()) {}

  /// Sample i of a block, whose interval starts at `start`; what comes of it is added to `to`.
  void take(const Block& from, std::size_t i, Time start, Block& to);
  /// After the last one.
  void finish(Block& to);
  /// No sample is under way: another thinner can go on from here.
  bool is_between() const { return count_ == 0; }

 private:
  void keep(const Block& from, std::size_t i, Block& to) const;
  void join(const Block& from, std::size_t i, Time start);

  const Layout& layout_;
  std::uint64_t index_;
  // Of the sample under way:
  int count_ = 0;
  Time start_ = no_time, t_ = no_time;
  double seconds_in_all_ = 0;
  std::vector<double> sums_;
  std::vector<double> last_;
};

}  // namespace binnacle::csv
