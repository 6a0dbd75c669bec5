// SPDX-License-Identifier: Apache-2.0
// Smoothed epochs one after another, in memory that is kept.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/eigen.hpp"
#include "smooth/stretch.hpp"

namespace binnacle::smooth {

class EpochBuffer {
 public:
  explicit EpochBuffer(const FilterInfo& filter)
      : n_(filter.dof),
        stored_(static_cast<std::size_t>(filter.stored_size)),
        size_(1 + stored_ + static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_)) {}

  std::size_t count() const { return count_; }
  void clear() { count_ = 0; }
  void pop_back() { --count_; }

  void push_back(const Epoch& epoch) {
    if (numbers_.size() < ++count_ * size_) numbers_.resize(count_ * size_);
    double* to = numbers_.data() + (count_ - 1) * size_;
    *to++ = std::bit_cast<double>(epoch.t);
    to = std::copy_n(epoch.x, stored_, to);
    MatrixView{to, n_, n_, n_}.as() = epoch.P.as();
  }
  /// Valid until the next push_back.
  Epoch operator[](std::size_t index) const {
    const double* const from = numbers_.data() + index * size_;
    return {std::bit_cast<Time>(*from), from + 1, ConstMatrixView{from + 1 + stored_, n_, n_, n_}};
  }

 private:
  int n_;
  std::size_t stored_, size_, count_ = 0;
  std::vector<double> numbers_;  // t, x, P of each
};

}  // namespace binnacle::smooth
