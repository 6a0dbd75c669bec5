// SPDX-License-Identifier: Apache-2.0
// --checkpoint FILE[@60s] and --resume FILE.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "binnacle/run.hpp"

namespace binnacle::command {

class CheckpointFiles final : public Checkpoints::Keeper {
 public:
  void add_to(CLI::App& app);
  /// Reads what is to be resumed. Throws UsageError where a file or a time is none.
  void open();

  bool are_wanted() const { return !keep_.empty() || !resume_.empty(); }
  /// Each replaces the file as a whole.
  Checkpoints checkpoints();
  void keep(std::span<const std::byte> checkpoint) override;
  /// Where the records of a run are that goes on, and where they are kept; empty: nowhere.
  std::filesystem::path kept_records() const { return records_of(keep_); }
  std::filesystem::path resumed_records() const { return records_of(resume_); }

  /// What one does after an interruption; empty where there is no checkpoint.
  std::string advice() const;
  /// The run is over, and its results are in place.
  void remove() const;

 private:
  static std::filesystem::path records_of(const std::filesystem::path& file);

  std::string text_, resume_text_;
  std::filesystem::path keep_, resume_;
  Time every_ = 60 * nanoseconds_per_second;
  std::vector<std::byte> from_;
};

}  // namespace binnacle::command
