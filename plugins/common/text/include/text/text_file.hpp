// SPDX-License-Identifier: Apache-2.0
// Lines of a text file, plain or gzipped.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace binnacle::text_file {

/// A file that cannot be read on: `code` is B060 (cannot be opened or read) or B061 (damaged).
struct FileFault : std::runtime_error {
  FileFault(const std::string& message, std::string fault_code)
      : std::runtime_error(message), code(std::move(fault_code)) {}
  std::string code;
};

/// The bytes of a file; those of a gzip file (known by its first two bytes) unpacked and checked.
class ByteStream {
 public:
  explicit ByteStream(const std::string& path);
  ~ByteStream();
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;

  /// Up to `size` bytes, 0 only at the end. Throws FileFault.
  std::size_t read(char* to, std::size_t size);

  bool is_packed() const { return gzip_ != nullptr; }
  /// Bytes that read() has given.
  std::uint64_t offset() const { return offset_; }

  /// Where a gzip file stands with all that its decoder remembers, some 40 KiB; `mark` of a plain file is null.
  class Mark;
  std::shared_ptr<const Mark> mark();
  /// Goes to a byte of the text: from the mark, or where that is null from the start of the file. Throws FileFault.
  void seek(std::uint64_t offset, const std::shared_ptr<const Mark>& from);

 private:
  struct Gzip;

  std::size_t read_raw(void* to, std::size_t size);
  void seek_raw(std::uint64_t offset);
  bool refill();
  bool enter_next_member();
  std::size_t unpack(char* to, std::size_t size);

  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::unique_ptr<Gzip> gzip_;  // null: a plain file
  std::vector<char> head_;      // first bytes of a plain file, read to find its format
  std::uint64_t offset_ = 0;
};

/// Marks in a gzip file, at most 64 of them: every other one goes when there are more. For several threads.
class GzipPlaces {
 public:
  /// Where the stream should be marked next.
  bool wants(std::uint64_t offset);
  void add(ByteStream& stream);
  /// The last one that is not behind; null: the start of the file.
  std::shared_ptr<const ByteStream::Mark> before(std::uint64_t offset);
  void clear();

 private:
  std::mutex mutex_;
  std::vector<std::pair<std::uint64_t, std::shared_ptr<const ByteStream::Mark>>> marks_;
  std::uint64_t step_ = 1024 * 1024;
};

/// The bytes of a file, those of a gzip file unpacked by a thread ahead of the reader once it has asked twice.
class AheadStream {
 public:
  AheadStream(const std::string& path, std::uint64_t from, GzipPlaces* places);
  ~AheadStream();
  AheadStream(const AheadStream&) = delete;
  AheadStream& operator=(const AheadStream&) = delete;

  /// As ByteStream::read. What the thread threw is thrown here, after all that it had read before.
  std::size_t read(char* to, std::size_t size);
  bool is_packed() const { return stream_.is_packed(); }

 private:
  bool stream_is_ahead();
  void unpack();
  bool put(std::vector<char> block);

  ByteStream stream_;  // the thread's, once that has begun
  GzipPlaces* places_;
  bool was_read_ = false;
  std::vector<char> block_;  // that is being handed out
  std::size_t taken_ = 0;    // of it

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::vector<char>> blocks_;  // an empty one: the end
  std::exception_ptr fault_;
  bool is_left_ = false;  // nobody reads any more
  std::thread thread_;
};

/// A place in a text where a line begins; `line`: how many stand before it.
struct Place {
  std::uint64_t offset = 0;
  int line = 0;
};

/// Lines without their end (LF or CRLF), counted from 1; a byte order mark before the first is dropped. Of a gzip file a
/// thread unpacks what comes next. Memory: the window, or the longest line where that is longer, and four blocks of a gzip
/// file.
class LineReader {
 public:
  explicit LineReader(const std::string& path);
  /// From a place on, by windows of so many bytes. `places`: where a gzip file can be entered; the reader adds to them.
  LineReader(const std::string& path, const Place& from, GzipPlaces* places, std::size_t window = usual_window);

  /// The next line, valid until the next call; false at the end. Throws FileFault.
  bool next(std::string_view& line);
  /// The next line with more than blanks; those without are counted, at the speed of memory.
  bool next_filled(std::string_view& line);
  int line() const { return line_; }
  /// The last line of a plain file came without its end: the file may be cut.
  bool is_cut() const { return is_cut_ && !stream_.is_packed(); }
  /// Where the next line begins.
  Place place() const { return {offset_ + begin_, line_}; }

  /// The lines that follow and are at hand with their ends, as they stand in the file; the bytes behind them may be read up to
  /// eight more. Empty: next() must be called first.
  std::string_view ahead() const;
  /// Passes over so many bytes of them, in so many lines.
  void pass(std::size_t bytes, int lines) {
    begin_ += bytes;
    count_lines(lines);
  }
  /// What follows, so many bytes or more as far as the file has them. What next() gave is void.
  std::string_view look_ahead(std::size_t bytes);

  static constexpr std::size_t usual_window = 256 * 1024;

 private:
  bool refill();
  void pass_blank_lines();
  /// Behind the two thousand millionth line they are not told apart any more.
  void count_lines(int more) {
    line_ = more > std::numeric_limits<int>::max() - line_ ? std::numeric_limits<int>::max() : line_ + more;
  }

  AheadStream stream_;
  std::vector<char> buffer_;  // of which the last eight bytes are never filled
  std::uint64_t offset_ = 0;  // of the buffer in the text
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t lines_end_ = 0;  // behind the last line end in the buffer
  bool at_end_ = false;
  bool is_cut_ = false;
  int line_ = 0;
};

}  // namespace binnacle::text_file
