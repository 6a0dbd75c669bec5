// SPDX-License-Identifier: Apache-2.0
// Lines from one thread to another without a lock.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace binnacle::text_output {

/// One thread pushes, one takes. A line is in it whole or not at all.
class LineRing {
 public:
  explicit LineRing(std::size_t power_of_two) : bytes_(power_of_two) {}

  /// False: there is no room.
  bool push(std::string_view line) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (bytes_.size() - (end - begin_.load(std::memory_order_acquire)) < line.size()) return false;
    const std::size_t at = end & (bytes_.size() - 1);
    const std::size_t first = std::min(line.size(), bytes_.size() - at);
    std::memcpy(bytes_.data() + at, line.data(), first);
    std::memcpy(bytes_.data(), line.data() + first, line.size() - first);
    end_.store(end + line.size(), std::memory_order_seq_cst);
    return true;
  }
  /// All that is there, in place of what `lines` has.
  void take(std::string& lines) {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    const std::size_t size = end_.load(std::memory_order_seq_cst) - begin;
    const std::size_t at = begin & (bytes_.size() - 1);
    const std::size_t first = std::min(size, bytes_.size() - at);
    lines.assign(bytes_.data() + at, first);
    lines.append(bytes_.data(), size - first);
    begin_.store(begin + size, std::memory_order_release);
  }
  bool empty() const noexcept { return end_.load(std::memory_order_seq_cst) == begin_.load(std::memory_order_relaxed); }

 private:
  std::vector<char> bytes_;
  std::atomic<std::size_t> begin_ = 0;
  std::atomic<std::size_t> end_ = 0;
};

}  // namespace binnacle::text_output
