// SPDX-License-Identifier: Apache-2.0
#include "atomic_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "interrupt.hpp"
#include "output.hpp"
#include "this_process.hpp"

namespace binnacle::command {

namespace {

constexpr mode_t read_write = 0666;
constexpr std::size_t buffer_size = 1 << 18;
constexpr std::size_t write_out_size = 8 << 20;

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

std::string link_of(int file) { return fmt::format("/proc/self/fd/{}", file); }

int open_unnamed([[maybe_unused]] const std::filesystem::path& folder) {
#ifdef O_TMPFILE
  const int file = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, read_write);
  if (file < 0 || ::access(link_of(file).c_str(), F_OK) == 0) return file;
  ::close(file);  // without /proc it could never be given its name
#endif
  return -1;
}

/// What killed processes left behind.
void remove_abandoned(const std::filesystem::path& folder, const std::string& prefix) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (!entry.path().filename().string().starts_with(prefix)) continue;
    const int file = ::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (file < 0) continue;
    if (::flock(file, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
    ::close(file);
  }
}

}  // namespace

std::string contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw UsageError(fmt::format("'{}' cannot be read", path.string()));
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string could_not_write(const std::filesystem::path& file, const std::string& why) {
  std::string remedy;
  for (const int full : {ENOSPC, EDQUOT})
    if (why == std::strerror(full)) remedy = "; make room there, or write elsewhere";
  if (why == std::strerror(EFBIG)) remedy = "; raise the limit (ulimit -f), or write elsewhere";
  if (why == std::strerror(EMFILE)) remedy = "; raise the limit (ulimit -n)";
  return fmt::format("'{}' could not be written: {}{}", file.string(), why, remedy);
}

AtomicFile::AtomicFile(std::filesystem::path target, Temporary temporary) : target_(std::move(target)) {
  buffer_.reserve(buffer_size);  // before there is a file: a constructor that throws leaves it behind
  std::error_code ignored;
  const auto status = std::filesystem::status(target_, ignored);
  if (std::filesystem::is_directory(status))
    throw UsageError(fmt::format("cannot write '{}': it is a folder", target_.string()));
  is_direct_ = std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
  if (is_direct_ && temporary == Temporary::named)
    throw UsageError(fmt::format("cannot write '{}': it is not a regular file", target_.string()));
  if (is_direct_) {
    // Nobody waits for a reader who may never come.
    file_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (file_ < 0 && errno == ENXIO && std::filesystem::is_fifo(status))
      throw UsageError(fmt::format(
          "cannot write '{}': it is a FIFO without a reader; name a regular file, or start the reader first",
          target_.string()));
  } else {
    open_temporary(temporary);
  }
  if (file_ < 0) throw UsageError(fmt::format("cannot write '{}': {}", target_.string(), std::strerror(errno)));
}

void AtomicFile::open_temporary(Temporary temporary) {
  std::error_code ignored;
  if (std::filesystem::is_symlink(target_, ignored)) target_ = std::filesystem::weakly_canonical(target_, ignored);
  const auto folder = folder_of(target_);
  temporary_ = folder / fmt::format(".{}.tmp-{}", target_.filename().string(), unique_suffix());
  file_ = temporary == Temporary::unnamed ? open_unnamed(folder) : -1;
  if (file_ >= 0) return;
  if (temporary == Temporary::named) remove_abandoned(folder, fmt::format(".{}.tmp-", target_.filename().string()));
  named_.emplace(temporary_);
  file_ = ::open(temporary_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, read_write);
  if (file_ >= 0) return;
  const int reason = errno;
  named_.reset();
  errno = reason;
}

AtomicFile::~AtomicFile() {
  if (file_ >= 0) ::close(file_);
  if (named_) ::unlink(temporary_.c_str());
}

void AtomicFile::fail(const std::string& why) const { throw OutputError(could_not_write(target_, why)); }

/// Of a pipe that is full, until a signal asks to stop.
void AtomicFile::wait_for_reader() const {
  constexpr int look_again = 100;  // ms
  pollfd pipe{file_, POLLOUT, 0};
  if (interrupted_by() != 0) fail("interrupted while its reader does not read");
  ::poll(&pipe, 1, look_again);
}

void AtomicFile::write_through(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto written = ::write(file_, text.data() + at, text.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0 && errno == EAGAIN) {
      wait_for_reader();
      continue;
    }
    if (written <= 0) fail(std::strerror(errno));
    at += static_cast<std::size_t>(written);
  }
  since_write_out_ += text.size();
  if (since_write_out_ < write_out_size) return;
  start_write_out();
  since_write_out_ = 0;
}

void AtomicFile::start_write_out() {
#ifdef SYNC_FILE_RANGE_WRITE
  if (!is_direct_) ::sync_file_range(file_, 0, 0, SYNC_FILE_RANGE_WRITE);
#endif
}

void AtomicFile::flush() {
  write_through(buffer_);
  buffer_.clear();
}

void AtomicFile::write(std::string_view text) {
  is_complete_ = false;
  if (text.size() >= buffer_size / 2) {  // large enough without the others
    flush();
    write_through(text);
    return;
  }
  buffer_ += text;
  if (buffer_.size() >= buffer_size - (buffer_size >> 3)) flush();
}

void AtomicFile::complete() {
  if (is_complete_) return;
  flush();
  if (!is_direct_ && ::fsync(file_) != 0 && errno != EINVAL) fail(std::strerror(errno));
  is_complete_ = true;
}

void AtomicFile::commit() {
  complete();
  if (is_direct_) return;
  if (!named_) {
    ::unlink(temporary_.c_str());
    if (::linkat(AT_FDCWD, link_of(file_).c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) != 0)
      fail(std::strerror(errno));
    named_.emplace(temporary_);
  }
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(std::strerror(errno));
  named_.reset();
  ::close(std::exchange(file_, -1));
}

}  // namespace binnacle::command
