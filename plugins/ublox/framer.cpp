// SPDX-License-Identifier: Apache-2.0
#include "framer.hpp"

namespace binnacle::ublox {

namespace {

constexpr std::size_t head = 6, tail = 2;
constexpr std::size_t longest_text = 1024;

std::uint8_t byte(std::string_view bytes, std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); }

bool has_right_checksum(std::string_view frame) {
  std::uint8_t a = 0, b = 0;
  for (std::size_t i = 2; i < frame.size() - tail; ++i) {
    a = static_cast<std::uint8_t>(a + byte(frame, i));
    b = static_cast<std::uint8_t>(b + a);
  }
  return a == byte(frame, frame.size() - 2) && b == byte(frame, frame.size() - 1);
}

}  // namespace

void Framer::skip(std::size_t count, Kind& kind) {
  if (run_of_ != &kind) {
    if (kind.runs++ == 0) kind.first_at = at_;
    run_of_ = &kind;
  }
  kind.count += count;
  begin_ += count;
  at_ += count;
}

bool Framer::next(Frame& frame) {
  for (;;) {
    switch (look(frame)) {
      case Look::frame: return true;
      case Look::skip: break;
      case Look::more:
        buffer_.erase(0, begin_);
        begin_ = 0;
        return false;
    }
  }
}

Framer::Look Framer::look(Frame& frame) {
  const auto rest = std::string_view(buffer_).substr(begin_);
  if (rest.empty()) return Look::more;
  const auto incomplete = [&] {
    if (!is_over_) return Look::more;
    // Nothing whole can begin here, but a message may behind it.
    const auto again = rest.substr(1).find("\xB5\x62");
    skip(again == rest.npos ? rest.size() : again + 1, counts_.cut);
    return Look::skip;
  };
  if (rest[0] == '$' || rest[0] == '!') return look_at_text();
  if (byte(rest, 0) != 0xB5) {
    const auto end = rest.find_first_of("\xB5$!");
    skip(end == rest.npos ? rest.size() : end, counts_.garbage);
    return Look::skip;
  }
  if (rest.size() < 2) return incomplete();
  if (byte(rest, 1) != 0x62) {
    skip(1, counts_.garbage);
    return Look::skip;
  }
  if (rest.size() < head) return incomplete();
  const std::size_t length = byte(rest, 4) | static_cast<std::size_t>(byte(rest, 5)) << 8;
  if (length > longest_payload) {
    skip(1, counts_.garbage);
    return Look::skip;
  }
  const std::size_t whole = head + length + tail;
  if (rest.size() < whole) return incomplete();
  if (!has_right_checksum(rest.substr(0, whole))) {
    if (counts_.bad_checksums.runs++ == 0) counts_.bad_checksums.first_at = at_;
    skip(1, counts_.garbage);
    return Look::skip;
  }
  frame = {byte(rest, 2), byte(rest, 3), rest.substr(head, length), at_};
  begin_ += whole;
  at_ += whole;
  counts_.frame_bytes += whole;
  run_of_ = nullptr;
  return Look::frame;
}

/// A line of printable characters, else garbage.
Framer::Look Framer::look_at_text() {
  const auto rest = std::string_view(buffer_).substr(begin_);
  std::size_t end = 1;
  while (end < rest.size() && end < longest_text && (rest[end] >= ' ' && rest[end] <= '~')) ++end;
  if (end == rest.size() && !is_over_) return Look::more;
  const bool has_end = end < rest.size() && (rest[end] == '\r' || rest[end] == '\n');
  if (!has_end) {
    skip(1, counts_.garbage);
    return Look::skip;
  }
  while (end < rest.size() && (rest[end] == '\r' || rest[end] == '\n')) ++end;
  run_of_ = nullptr;  // each line is a run of its own
  skip(end, counts_.text);
  return Look::skip;
}

void Framer::begin_anew() {
  if (begin_ < buffer_.size()) skip(buffer_.size() - begin_, counts_.cut);
  buffer_.clear();
  begin_ = 0;
  run_of_ = nullptr;
}

}  // namespace binnacle::ublox
