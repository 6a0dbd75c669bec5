// SPDX-License-Identifier: Apache-2.0
#include "folder_lock.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "output.hpp"
#include "this_process.hpp"

namespace binnacle::command {

namespace {

/// The file that was opened still has that name: whoever had it before removed its own at its end.
bool is_at(int file, const std::filesystem::path& path) {
  struct stat opened {
  }, named{};
  return ::fstat(file, &opened) == 0 && ::stat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

/// What its holder wrote, printable and not long.
std::string holder_in(int file) {
  std::array<char, 256> text{};
  const auto count = ::pread(file, text.data(), text.size(), 0);
  std::string holder;
  for (const char c : std::string_view(text.data(), count > 0 ? static_cast<std::size_t>(count) : 0))
    if (c >= ' ' && c <= '~') holder += c;
  return holder.empty() ? "another process" : holder;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder) : path_(folder / ".binnacle.lock") {
  const auto refuse = [&](const std::string& why) {
    if (file_ >= 0) ::close(file_);
    throw UsageError(fmt::format("cannot write into '{}': {}", folder.string(), why));
  };
  for (;;) {
    file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (file_ < 0) refuse(std::strerror(errno));
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
      if (errno == EINTR || (errno == EWOULDBLOCK && !is_at(file_, path_))) {
        ::close(file_);
        continue;
      }
      if (errno != EWOULDBLOCK) refuse(fmt::format("it cannot be locked: {}", std::strerror(errno)));
      refuse(fmt::format("{} is writing there; wait until it ends, or give another --out", holder_in(file_)));
    }
    if (is_at(file_, path_)) break;
    ::close(file_);
  }
  const std::string own = name_of_this_process();
  // Without its text, on a disk that is full, it holds as well.
  [[maybe_unused]] const bool is_named =
      ::ftruncate(file_, 0) == 0 && ::pwrite(file_, own.data(), own.size(), 0) == static_cast<ssize_t>(own.size());
  unfinished_.emplace(path_);
}

/// Removed while it is held, so that nobody locks a file without a name for long.
FolderLock::~FolderLock() {
  unfinished_.reset();
  if (is_at(file_, path_)) ::unlink(path_.c_str());
  ::close(file_);
}

}  // namespace binnacle::command
