// SPDX-License-Identifier: Apache-2.0
// Messages of the UBX protocol in a stream of bytes that also carries others, and damage.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace binnacle::ublox {

/// A message whose checksum is right. The payload is valid until the framer's next call.
struct Frame {
  std::uint8_t message_class = 0, id = 0;
  std::string_view payload;
  std::uint64_t at = 0;  // of its first byte in the stream

  constexpr int type() const noexcept { return message_class << 8 | id; }
};

/// Interface description, "UBX frame structure": B5 62, class, id, length (2 bytes), payload, checksum (2 bytes, Fletcher's
/// over all from the class on). After a wrong checksum the search goes on behind the first byte, so that a message inside
/// a damaged one is found. Every byte belongs to a message or is counted as one of the others.
class Framer {
 public:
  static constexpr std::size_t longest_payload = 16384;  // RXM-RAWX has at most 8176

  struct Kind {
    std::uint64_t count = 0;  // of bytes
    std::uint64_t runs = 0;
    std::uint64_t first_at = 0;
  };
  struct Counts {
    std::uint64_t frame_bytes = 0;
    Kind garbage;        // of no known form
    Kind text;           // whole lines that begin with '$' or '!': NMEA
    Kind bad_checksums;  // messages, in `runs`; their bytes count as what they turn out to be
    Kind cut;            // the end of the data inside a message
  };

  void append(std::string_view bytes) { buffer_.append(bytes); }
  /// For reading into.
  std::string& buffer() { return buffer_; }
  /// False: more bytes are needed.
  bool next(Frame& frame);
  /// No more bytes come: call, then next() until it is false.
  void finish() { is_over_ = true; }
  /// What comes next is of another connection.
  void begin_anew();

  const Counts& counts() const { return counts_; }

 private:
  enum class Look { frame, skip, more };
  Look look(Frame& frame);
  Look look_at_text();
  void skip(std::size_t count, Kind& kind);

  std::string buffer_;
  std::size_t begin_ = 0;  // of what was not taken yet
  std::uint64_t at_ = 0;   // its place in the stream
  bool is_over_ = false;
  Kind* run_of_ = nullptr;
  Counts counts_;
};

}  // namespace binnacle::ublox
