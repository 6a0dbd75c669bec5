// SPDX-License-Identifier: Apache-2.0
// AtomicFile: a file that is there whole or not at all.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "unfinished.hpp"

namespace binnacle::command {

/// All bytes of a file. UsageError where it cannot be read.
std::string contents(const std::filesystem::path& file);

/// "'FILE' could not be written: WHY; what to do".
std::string could_not_write(const std::filesystem::path& file, const std::string& why);

/// Written beside its final place and moved there by commit(). Where the file system can (O_TMPFILE of Linux) it has no
/// name until then, so that not even SIGKILL leaves anything behind; elsewhere a hidden ".NAME.tmp-HOST-PID-RANDOM", which no
/// other process makes on any machine, that the destructor removes, or Unfinished::remove_all() where there is no destructor.
/// What is no regular file (/dev/stdout, a pipe) is written straight into, a link through to its file; a FIFO needs a reader,
/// and one that does not read is waited for until a signal asks to stop.
class AtomicFile {
 public:
  /// `named`: for a library that opens the file itself, by path(). A killed process leaves the hidden name behind; the
  /// next to write the same target removes it, once nobody holds a lock on it any more, as HDF5 does while it writes.
  enum class Temporary { unnamed, named };

  /// Throws UsageError when the file cannot be made there.
  explicit AtomicFile(std::filesystem::path target, Temporary temporary = Temporary::unnamed);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Throws OutputError, as commit() does.
  void write(std::string_view text);
  /// Of a named one, until commit().
  const std::filesystem::path& path() const { return temporary_; }
  /// Has the system begin to put on the disk what was written, so that commit() waits for little. Of a named one, after its
  /// library wrote; the others call it themselves. Does not wait, and does not fail: commit() reports what went wrong.
  void start_write_out();
  /// OutputError: that it could not be written, why, and what to do.
  [[noreturn]] void fail(const std::string& why) const;
  /// All that was written is on the disk: commit() will find room. For files that are to change together.
  void complete();
  /// Replaces what is at the target. Nothing may be written after it.
  void commit();

  const std::filesystem::path& target() const { return target_; }

 private:
  void open_temporary(Temporary temporary);
  void flush();
  void write_through(std::string_view text);
  void wait_for_reader() const;

  std::filesystem::path target_;
  std::filesystem::path temporary_;
  int file_ = -1;
  std::optional<Unfinished> named_;  // while the temporary has a name
  bool is_direct_ = false;
  bool is_complete_ = false;  // nothing was written since complete()
  std::string buffer_;
  std::size_t since_write_out_ = 0;  // bytes
};

}  // namespace binnacle::command
