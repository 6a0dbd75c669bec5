// SPDX-License-Identifier: Apache-2.0
// Lines of a text file, plain or gzipped.
#include "text/text_file.hpp"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace binnacle::text_file {

namespace {

constexpr std::size_t chunk = 256 * 1024;
constexpr std::size_t longest_line = 16 * 1024 * 1024;
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

FileFault unreadable(const char* what) { return {std::string(what) + ": " + std::strerror(errno), "B060"}; }

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

}  // namespace

struct ByteStream::Gzip {
  Gzip() : packed(chunk) {
    if (inflateInit2(&z, 15 + 16) != Z_OK) throw FileFault("zlib cannot be started", "B060");  // 15 + 16: gzip only
  }
  ~Gzip() { inflateEnd(&z); }

  std::uint64_t position() const { return taken - z.avail_in; }

  z_stream z{};
  std::vector<unsigned char> packed;
  std::uint64_t taken = 0;  // bytes of the file handed to zlib
  bool inside_member = true;
};

ByteStream::ByteStream(const std::string& path) : file_(std::fopen(path.c_str(), "rb"), &std::fclose) {
  if (!file_) throw unreadable("cannot be opened");
  unsigned char magic[2];
  const std::size_t size = read_raw(magic, sizeof magic);
  if (size == 2 && magic[0] == 0x1f && magic[1] == 0x8b) {
    gzip_ = std::make_unique<Gzip>();
    gzip_->packed[0] = magic[0];
    gzip_->packed[1] = magic[1];
    gzip_->z.next_in = gzip_->packed.data();
    gzip_->z.avail_in = 2;
    gzip_->taken = 2;
  } else if (size > 0 && ends_with(path, ".gz")) {
    throw FileFault("is named .gz but is not a gzip file", "B061");
  } else {
    head_.assign(magic, magic + size);
  }
}

ByteStream::~ByteStream() = default;

std::size_t ByteStream::read(char* to, std::size_t size) {
  if (gzip_) return unpack(to, size);
  if (head_.empty()) return read_raw(to, size);
  const std::size_t count = std::min(size, head_.size());
  std::memcpy(to, head_.data(), count);
  head_.erase(head_.begin(), head_.begin() + static_cast<std::ptrdiff_t>(count));
  return count;
}

std::size_t ByteStream::read_raw(void* to, std::size_t size) {
  const std::size_t count = std::fread(to, 1, size, file_.get());
  if (count == 0 && std::ferror(file_.get())) throw unreadable("cannot be read");
  return count;
}

bool ByteStream::refill() {
  auto& g = *gzip_;
  if (g.z.avail_in > 0) return true;
  const std::size_t count = read_raw(g.packed.data(), g.packed.size());
  g.z.next_in = g.packed.data();
  g.z.avail_in = static_cast<uInt>(count);
  g.taken += count;
  return count > 0;
}

/// After one gzip member: the next one's start, or the end. Padding with zeros is skipped, as gzip does.
bool ByteStream::enter_next_member() {
  auto& g = *gzip_;
  while (refill()) {
    if (*g.z.next_in == 0x1f) {
      inflateReset(&g.z);
      g.inside_member = true;
      return true;
    }
    if (*g.z.next_in != 0)
      throw FileFault("gzip data are followed by other bytes at byte " + std::to_string(g.position()), "B061");
    ++g.z.next_in;
    --g.z.avail_in;
  }
  return false;
}

std::size_t ByteStream::unpack(char* to, std::size_t size) {
  auto& g = *gzip_;
  g.z.next_out = reinterpret_cast<unsigned char*>(to);
  g.z.avail_out = static_cast<uInt>(size);
  while (g.z.avail_out == size) {
    if (!g.inside_member && !enter_next_member()) break;
    if (!refill()) throw FileFault("gzip data are cut off at byte " + std::to_string(g.position()), "B061");
    const int status = inflate(&g.z, Z_NO_FLUSH);
    if (status == Z_STREAM_END) {
      g.inside_member = false;
    } else if (status != Z_OK && status != Z_BUF_ERROR && g.z.avail_out == size) {  // what came out before is good
      throw FileFault("gzip data are corrupt at byte " + std::to_string(g.position()) + " (" +
                          (g.z.msg ? g.z.msg : "zlib status " + std::to_string(status)) + ")",
                      "B061");
    }
  }
  return size - g.z.avail_out;
}

LineReader::LineReader(const std::string& path) : stream_(path), buffer_(chunk) {}

bool LineReader::next(std::string_view& line) {
  std::size_t searched = 0;
  for (;;) {
    const char* start = buffer_.data() + begin_;
    const std::size_t size = end_ - begin_;
    const void* newline = std::memchr(start + searched, '\n', size - searched);
    if (newline) {
      const auto length = static_cast<std::size_t>(static_cast<const char*>(newline) - start);
      line = {start, length};
      begin_ += length + 1;
      break;
    }
    searched = size;
    if (at_end_ || !refill()) {
      if (size == 0) return false;
      line = {buffer_.data() + begin_, size};
      begin_ = end_;
      break;
    }
  }
  ++line_;
  if (line_ == 1 && line.substr(0, byte_order_mark.size()) == byte_order_mark)
    line.remove_prefix(byte_order_mark.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

bool LineReader::refill() {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ == buffer_.size()) {
    if (buffer_.size() >= longest_line) throw FileFault("is not text: no line ends within 16 MiB", "B061");
    buffer_.resize(2 * buffer_.size());
  }
  const std::size_t count = stream_.read(buffer_.data() + end_, buffer_.size() - end_);
  end_ += count;
  at_end_ = count == 0;
  return count > 0;
}

}  // namespace binnacle::text_file
