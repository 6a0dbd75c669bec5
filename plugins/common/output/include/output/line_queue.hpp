// SPDX-License-Identifier: Apache-2.0
// Lines that wait to be sent, within a bound: where there is no room for a new one the oldest go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace binnacle::text_output {

/// A line ends with its newline. One that was sent in part stays until its rest is sent, so a receiver sees whole lines only.
class LineQueue {
 public:
  explicit LineQueue(std::size_t bytes) : most_(bytes) {}

  bool has_room(std::size_t size) const { return end_ - begin_ + size <= most_; }
  void push(std::string_view line);
  /// All that waits, from the rest of a line that was begun.
  std::string_view waiting() const { return {bytes_.data() + begin_, end_ - begin_}; }
  /// Of it the first line.
  std::string_view first_line() const;
  /// So many bytes of waiting() were sent.
  void sent(std::size_t count);
  /// So many bytes of waiting(), whole lines, could not be sent.
  void lose(std::size_t count);
  /// A line that was sent did not arrive.
  void count_as_lost() { ++lost_; }
  /// The receiver is another one: a line that was begun is lost.
  void restart();

  bool empty() const { return begin_ == end_; }
  std::int64_t lines() const { return lines_; }  // that wait
  std::int64_t lost() const { return lost_; }

 private:
  void drop_oldest();

  std::size_t most_;
  std::vector<char> bytes_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool is_begun_ = false;  // the line at begin_
  std::int64_t lines_ = 0;
  std::int64_t lost_ = 0;
};

}  // namespace binnacle::text_output
