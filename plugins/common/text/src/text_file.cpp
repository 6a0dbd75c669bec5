// SPDX-License-Identifier: Apache-2.0
// Lines of a text file, plain or gzipped.
#include "text/text_file.hpp"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace binnacle::text_file {

namespace {

constexpr std::size_t chunk = 256 * 1024;
constexpr std::size_t padding = 8;  // of the reader's buffer
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

namespace {

/// A file is read from more than one place, and nobody may be waited for: a pipe is no file, and none is opened by waiting for
/// its writer.
std::FILE* open_file(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status = {};
  if (file < 0 || ::fstat(file, &status) != 0) throw unreadable("cannot be opened");
  if (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)) return ::fdopen(file, "rb");
  ::close(file);
  throw FileFault(
      "is not a regular file: copy its contents to a file first, or read it live, by a source with \"from\"", "B060");
}

}  // namespace

ByteStream::ByteStream(const std::string& path) : file_(open_file(path), &std::fclose) {
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

class ByteStream::Mark {
 public:
  Mark(Gzip& gzip, std::uint64_t at) : offset(at), position(gzip.position()), inside_member(gzip.inside_member) {
    if (inflateCopy(z.get(), &gzip.z) != Z_OK) throw FileFault("zlib cannot mark a place", "B060");
  }
  ~Mark() { inflateEnd(z.get()); }
  Mark(const Mark&) = delete;
  Mark& operator=(const Mark&) = delete;

  std::unique_ptr<z_stream> z = std::make_unique<z_stream>();
  std::uint64_t offset, position;  // in the text, in the file
  bool inside_member;
};

std::shared_ptr<const ByteStream::Mark> ByteStream::mark() {
  return gzip_ ? std::make_shared<const Mark>(*gzip_, offset_) : nullptr;
}

void ByteStream::seek(std::uint64_t offset, const std::shared_ptr<const Mark>& from) {
  if (!gzip_) {
    head_.clear();
    seek_raw(offset);
    offset_ = offset;
    return;
  }
  auto& g = *gzip_;
  if (from) {
    inflateEnd(&g.z);
    if (inflateCopy(&g.z, from->z.get()) != Z_OK) throw FileFault("zlib cannot go to a mark", "B060");
  } else {
    inflateReset(&g.z);
  }
  g.z.avail_in = 0;
  g.taken = from ? from->position : 0;
  g.inside_member = from ? from->inside_member : true;
  offset_ = from ? from->offset : 0;
  seek_raw(g.taken);
  std::vector<char> passed(chunk);
  while (offset_ < offset)
    if (read(passed.data(), static_cast<std::size_t>(std::min<std::uint64_t>(passed.size(), offset - offset_))) == 0)
      throw FileFault("is shorter than it was", "B061");
}

void ByteStream::seek_raw(std::uint64_t offset) {
  if (fseeko(file_.get(), static_cast<off_t>(offset), SEEK_SET) != 0) throw unreadable("cannot be read again");
}

std::size_t ByteStream::read(char* to, std::size_t size) {
  std::size_t count = 0;
  if (gzip_) {
    count = unpack(to, size);
  } else if (head_.empty()) {
    count = read_raw(to, size);
  } else {
    count = std::min(size, head_.size());
    std::memcpy(to, head_.data(), count);
    head_.erase(head_.begin(), head_.begin() + static_cast<std::ptrdiff_t>(count));
  }
  offset_ += count;
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

bool GzipPlaces::wants(std::uint64_t offset) {
  const std::lock_guard lock(mutex_);
  return offset >= (marks_.empty() ? 0 : marks_.back().first) + step_;
}

void GzipPlaces::add(ByteStream& stream) {
  constexpr std::size_t most = 64;
  auto mark = stream.mark();
  const std::lock_guard lock(mutex_);
  marks_.emplace_back(stream.offset(), std::move(mark));
  if (marks_.size() <= most) return;
  for (std::size_t i = 1; i <= marks_.size() / 2; ++i) marks_[i - 1] = std::move(marks_[2 * i - 1]);
  marks_.resize(marks_.size() / 2);
  step_ *= 2;
}

std::shared_ptr<const ByteStream::Mark> GzipPlaces::before(std::uint64_t offset) {
  const std::lock_guard lock(mutex_);
  const auto behind = std::ranges::upper_bound(marks_, offset, {}, [](const auto& each) { return each.first; });
  return behind == marks_.begin() ? nullptr : std::prev(behind)->second;
}

void GzipPlaces::clear() {
  const std::lock_guard lock(mutex_);
  marks_.clear();
}

AheadStream::AheadStream(const std::string& path, std::uint64_t from, GzipPlaces* places)
    : stream_(path), places_(places) {
  if (from > 0) stream_.seek(from, places ? places->before(from) : nullptr);
}

AheadStream::~AheadStream() {
  {
    const std::lock_guard lock(mutex_);
    is_left_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::size_t AheadStream::read(char* to, std::size_t size) {
  if (!stream_is_ahead()) return stream_.read(to, size);
  if (taken_ == block_.size()) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !blocks_.empty(); });
    if (blocks_.front().empty()) {  // stays: the end is reported as often as it is asked for
      if (fault_) std::rethrow_exception(fault_);
      return 0;
    }
    block_ = std::move(blocks_.front());
    blocks_.pop_front();
    taken_ = 0;
    lock.unlock();
    changed_.notify_all();
  }
  const std::size_t count = std::min(size, block_.size() - taken_);
  std::memcpy(to, block_.data() + taken_, count);
  taken_ += count;
  return count;
}

/// The first bytes are unpacked where they are asked for: many a file is no longer, or only its header is wanted.
bool AheadStream::stream_is_ahead() {
  if (!stream_.is_packed() || !std::exchange(was_read_, true)) return false;
  if (!thread_.joinable()) thread_ = std::thread([this] { unpack(); });
  return true;
}

void AheadStream::unpack() {
  try {
    for (bool goes_on = true; goes_on;) {
      if (places_ && places_->wants(stream_.offset())) places_->add(stream_);
      std::vector<char> block(chunk);
      block.resize(stream_.read(block.data(), block.size()));
      goes_on = !block.empty();
      goes_on &= put(std::move(block));
    }
  } catch (...) {
    fault_ = std::current_exception();
    put({});
  }
}

/// False: nobody reads any more.
bool AheadStream::put(std::vector<char> block) {
  constexpr std::size_t most = 4;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return blocks_.size() < most || is_left_; });
  blocks_.push_back(std::move(block));
  const bool goes_on = !is_left_;
  lock.unlock();
  changed_.notify_all();
  return goes_on;
}

LineReader::LineReader(const std::string& path) : LineReader(path, {}, nullptr) {}

LineReader::LineReader(const std::string& path, const Place& from, GzipPlaces* places, std::size_t window)
    : stream_(path, from.offset, places), buffer_(window + padding), offset_(from.offset), line_(from.line) {}

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
      is_cut_ = line.find_first_not_of(" \t\r") != std::string_view::npos;
      break;
    }
  }
  count_lines(1);
  if (line_ == 1 && line.substr(0, byte_order_mark.size()) == byte_order_mark)
    line.remove_prefix(byte_order_mark.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

bool LineReader::next_filled(std::string_view& line) {
  do {
    pass_blank_lines();
    if (!next(line)) return false;
  } while (line.find_first_not_of(" \t") == std::string_view::npos);
  return true;
}

/// Of those at hand.
void LineReader::pass_blank_lines() {
  constexpr std::size_t block = 64;
  const std::string_view text = ahead();
  if (text.empty() || (text[0] != '\n' && text[0] != '\r' && text[0] != ' ' && text[0] != '\t')) return;
  const auto is_blank = [all = text.data()](std::size_t i) -> unsigned {  // there is a byte behind the last one
    const char c = all[i];
    const auto is = [](bool it) { return static_cast<unsigned>(it); };
    return is(c == '\n') | is(c == ' ') | is(c == '\t') | (is(c == '\r') & is(all[i + 1] == '\n'));
  };
  std::size_t at = 0, begin = 0;  // a line begins there
  int lines = 0;
  for (; at + block <= text.size(); at += block) {  // a loop without branches, for vector registers
    unsigned are_blank = 1, newlines = 0;
    for (std::size_t i = at; i < at + block; ++i) {
      are_blank &= is_blank(i);
      newlines += static_cast<unsigned>(text.data()[i] == '\n');
    }
    if (are_blank == 0) break;
    lines += static_cast<int>(newlines);
    if (text[at + block - 1] == '\n') begin = at + block;
  }
  int passed = lines;  // those before `begin`
  if (begin != at) {   // the last of them is not at its end yet
    begin = at;
    while (begin > 0 && text[begin - 1] != '\n') --begin;
  }
  for (; at < text.size() && is_blank(at) != 0; ++at)
    if (text[at] == '\n') {
      begin = at + 1;
      ++passed;
    }
  pass(begin, passed);
}

std::string_view LineReader::look_ahead(std::size_t bytes) {
  while (end_ - begin_ < bytes && !at_end_) refill();
  return {buffer_.data() + begin_, end_ - begin_};
}

std::string_view LineReader::ahead() const {
  // The first line may have a byte order mark.
  return line_ == 0 || begin_ >= lines_end_ ? std::string_view()
                                            : std::string_view(buffer_.data() + begin_, lines_end_ - begin_);
}

bool LineReader::refill() {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    offset_ += begin_;
    lines_end_ = lines_end_ > begin_ ? lines_end_ - begin_ : 0;
    begin_ = 0;
  }
  if (end_ + padding == buffer_.size()) {
    if (end_ >= longest_line) throw FileFault("is not text: no line ends within 16 MiB", "B061");
    buffer_.resize(2 * end_ + padding);
  }
  const std::size_t count = stream_.read(buffer_.data() + end_, buffer_.size() - padding - end_);
  const std::size_t found = std::string_view(buffer_.data() + end_, count).rfind('\n');
  if (found != std::string_view::npos) lines_end_ = end_ + found + 1;
  end_ += count;
  at_end_ = count == 0;
  return count > 0;
}

}  // namespace binnacle::text_file
