// SPDX-License-Identifier: Apache-2.0
// A file that is opened once, so that what is looked at is what is read, whatever comes to stand under its name meanwhile.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

namespace binnacle::internal::base {

/// For reading. Unless it `may_wait`, a FIFO is opened without its writer.
struct OpenFile {
  explicit OpenFile(const std::filesystem::path& file, bool may_wait = false)
      : id(::open(file.c_str(), O_RDONLY | O_CLOEXEC | (may_wait ? 0 : O_NONBLOCK))) {
    if (id < 0 || ::fstat(id, &status) != 0) failure = std::strerror(errno);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (id >= 0) ::close(id);
  }

  int id;
  struct stat status {};
  std::string failure;  // why it cannot be opened; "" where it is
};

}  // namespace binnacle::internal::base
