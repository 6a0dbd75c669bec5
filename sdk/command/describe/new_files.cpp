// SPDX-License-Identifier: Apache-2.0
#include "new_files.hpp"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "folders.hpp"
#include "output.hpp"
#include "unfinished.hpp"

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
  for (auto file = files_.rbegin(); file != files_.rend(); ++file) {
    fs::remove(file->is_there ? file->target : file->temporary, ignored);
    if (!file->topmost.empty()) remove_empty_folders(file->target.parent_path(), file->topmost);
  }
}

void NewFiles::write(const fs::path& target, const std::string& text) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(target, error))) throw in_the_way(target);
  const fs::path folder = target.parent_path();
  const fs::path temporary = folder / fmt::format(".{}.tmp-{}", target.filename().string(), getpid());
  files_.push_back({target, temporary, folder.empty() ? fs::path() : make_folders(folder)});

  std::FILE* const file = std::fopen(temporary.c_str(), "wbx");
  if (file == nullptr) throw UsageError(fmt::format("cannot write '{}': {}", target.string(), why(errno)));
  const bool is_written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const int failure = errno;
  if (std::fclose(file) != 0) throw OutputError(could_not_write(target, why(errno)));
  if (!is_written) throw OutputError(could_not_write(target, why(failure)));
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
