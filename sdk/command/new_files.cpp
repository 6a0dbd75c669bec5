// SPDX-License-Identifier: Apache-2.0
#include "new_files.hpp"

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "output.hpp"

namespace binnacle::command {

namespace fs = std::filesystem;

namespace {

std::string why(int number) { return std::generic_category().message(number); }

UsageError in_the_way(const fs::path& target) {
  return UsageError(fmt::format("'{}' exists already; nothing was written", target.string()));
}

/// 0, or errno. Without RENAME_NOREPLACE of the file system a hard link, which replaces nothing either.
int moved(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  if (link(from.c_str(), to.c_str()) != 0) return errno;
  unlink(from.c_str());
  return 0;
}

}  // namespace

NewFiles::~NewFiles() {
  std::error_code ignored;
  if (is_kept_) return;
  for (const File& file : files_) fs::remove(file.is_there ? file.target : file.temporary, ignored);
}

void NewFiles::write(const fs::path& target, const std::string& text) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(target, error))) throw in_the_way(target);
  const fs::path temporary = target.parent_path() / fmt::format(".{}.tmp-{}", target.filename().string(), getpid());
  errno = 0;
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  if (!file) throw UsageError(fmt::format("cannot write '{}': {}", target.string(), why(errno)));
  files_.push_back({target, temporary});
  file << text;
  file.close();
  if (!file) throw OutputError(could_not_write(target, why(errno)));
}

void NewFiles::commit() {
  for (File& file : files_) {
    const int failure = moved(file.temporary, file.target);
    if (failure == EEXIST) throw in_the_way(file.target);
    if (failure != 0) throw OutputError(could_not_write(file.target, why(failure)));
    file.is_there = true;
  }
  is_kept_ = true;
}

}  // namespace binnacle::command
