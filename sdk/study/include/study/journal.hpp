// SPDX-License-Identifier: Apache-2.0
// Journal: what came of each run, kept as it comes, so that a study goes on where it was stopped.
#pragma once

#include <chrono>
#include <filesystem>

#include "study/study.hpp"

namespace binnacle::study {

/// A text file: a head that names the study, then a line per run, each with a checksum of its own. Lines come in the
/// order in which runs end. A line that was torn (a kill, a full disk) counts for nothing.
class Journal {
 public:
  /// Opens or begins it, and enters what it holds into the results. One process at a time. Throws Error with exit status
  /// 2 (B092) where it belongs to another study or is at work, std::filesystem::filesystem_error where it cannot be read or written.
  Journal(const std::filesystem::path& path, const Study& study, Results& results);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// How many runs it held already.
  std::size_t restored() const { return restored_; }
  void add(std::size_t variant, std::size_t run, const Figures& figures);
  /// To the disk itself; add() does it every few seconds.
  void sync();

 private:
  void restore(const Study& study, Results& results);
  void write(const std::string& line);

  std::filesystem::path path_;
  int file_ = -1;
  std::size_t restored_ = 0;
  std::chrono::steady_clock::time_point synced_ = std::chrono::steady_clock::now();
};

}  // namespace binnacle::study
