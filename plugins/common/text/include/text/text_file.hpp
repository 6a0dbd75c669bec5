// SPDX-License-Identifier: Apache-2.0
// Lines of a text file, plain or gzipped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
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

 private:
  struct Gzip;

  std::size_t read_raw(void* to, std::size_t size);
  bool refill();
  bool enter_next_member();
  std::size_t unpack(char* to, std::size_t size);

  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::unique_ptr<Gzip> gzip_;  // null: a plain file
  std::vector<char> head_;      // first bytes of a plain file, read to find its format
};

/// Lines without their end (LF or CRLF), counted from 1; a byte order mark before the first is dropped.
class LineReader {
 public:
  explicit LineReader(const std::string& path);

  /// The next line, valid until the next call; false at the end. Throws FileFault.
  bool next(std::string_view& line);
  int line() const { return line_; }

 private:
  bool refill();

  ByteStream stream_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool at_end_ = false;
  int line_ = 0;
};

}  // namespace binnacle::text_file
