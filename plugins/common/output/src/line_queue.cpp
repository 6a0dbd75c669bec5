// SPDX-License-Identifier: Apache-2.0
#include "output/line_queue.hpp"

#include <algorithm>
#include <cstring>

namespace binnacle::text_output {

std::string_view LineQueue::first_line() const {
  const auto all = waiting();
  return all.substr(0, all.find('\n') + 1);
}

void LineQueue::push(std::string_view line) {
  while (!has_room(line.size()) && lines_ > (is_begun_ ? 1 : 0)) drop_oldest();
  if (!has_room(line.size())) {
    ++lost_;
    return;
  }
  if (end_ + line.size() > bytes_.size()) {
    if (end_ > begin_) std::memmove(bytes_.data(), bytes_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    if (2 * (end_ + line.size()) > bytes_.size()) bytes_.resize(4 * (end_ + line.size()));
  }
  std::memcpy(bytes_.data() + end_, line.data(), line.size());
  end_ += line.size();
  ++lines_;
}

/// The rest of a line that was begun is moved up to the line after the one that goes.
void LineQueue::drop_oldest() {
  const std::size_t rest = is_begun_ ? first_line().size() : 0;
  const auto after = waiting().substr(rest);
  const std::size_t gone = after.find('\n') + 1;
  std::memmove(bytes_.data() + begin_ + gone, bytes_.data() + begin_, rest);
  begin_ += gone;
  --lines_;
  ++lost_;
}

void LineQueue::sent(std::size_t count) {
  if (count == 0) return;
  const auto part = waiting().substr(0, count);
  lines_ -= std::count(part.begin(), part.end(), '\n');
  is_begun_ = part.back() != '\n';
  begin_ += count;
}

void LineQueue::lose(std::size_t count) {
  const auto before = lines_;
  sent(count);
  lost_ += before - lines_;
}

void LineQueue::restart() {
  if (is_begun_) lose(first_line().size());
}

}  // namespace binnacle::text_output
