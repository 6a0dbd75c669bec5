// SPDX-License-Identifier: Apache-2.0
// AtomicFile: a file that is there whole or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace binnacle::command {

/// Written beside its final place and moved there by commit(). Where the file system can (O_TMPFILE of Linux) it has no
/// name until then, so that not even SIGKILL leaves anything behind; elsewhere a hidden ".NAME.tmp-PID" that the
/// destructor removes. What is no regular file (/dev/stdout, a pipe) is written straight into, a link through to its
/// file.
class AtomicFile {
 public:
  /// Throws UsageError when the file cannot be made there.
  explicit AtomicFile(std::filesystem::path target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Throws OutputError, as commit() does.
  void write(std::string_view text);
  /// Replaces what is at the target. Nothing may be written after it.
  void commit();

  const std::filesystem::path& target() const { return target_; }

 private:
  void open_temporary();
  void flush();
  [[noreturn]] void fail() const;

  std::filesystem::path target_;
  std::filesystem::path temporary_;
  int file_ = -1;
  bool has_name_ = false;
  bool is_direct_ = false;
  std::string buffer_;
};

}  // namespace binnacle::command
