// SPDX-License-Identifier: Apache-2.0
#include "unfinished.hpp"

#include <mutex>
#include <system_error>
#include <utility>

#include <unistd.h>

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

struct Register {
  std::mutex mutex;
  std::list<Unfinished::Entry> entries;
};

/// Never destroyed: handlers at exit read it.
Register& all() {
  static Register& kept = *new Register;
  return kept;
}

}  // namespace

void remove_empty_folders(fs::path from, const fs::path& topmost) {
  std::error_code error;
  while (fs::remove(from, error) && from != topmost) from = from.parent_path();
}

Unfinished::Unfinished(fs::path path, fs::path topmost) {
  const std::lock_guard lock(all().mutex);
  entry_ = all().entries.insert(all().entries.end(), {std::move(path), std::move(topmost)});
}

Unfinished::~Unfinished() {
  const std::lock_guard lock(all().mutex);
  all().entries.erase(entry_);
}

void Unfinished::remove_all() noexcept {
  all().mutex.lock();  // and never unlocked: the process ends
  auto& entries = all().entries;
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    if (entry->topmost.empty())
      ::unlink(entry->path.c_str());
    else
      remove_empty_folders(entry->path, entry->topmost);
  }
}

}  // namespace binnacle::command
