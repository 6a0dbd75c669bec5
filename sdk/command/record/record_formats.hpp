// SPDX-License-Identifier: Apache-2.0
// In which formats a run is recorded.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace binnacle::command {

struct RecordFormats {
  bool nc = true, csv = true, page = true;
  int compression = 0;  // of run.nc: 1 (least) to 9; 0: none

  /// "nc,csv,page": these alone. Throws UsageError where it names another, or none.
  void keep_only(const std::string& list);
};

/// --only and --compress, both of --out.
class RecordOptions {
 public:
  void add_to(CLI::App& command, CLI::Option* out);
  RecordFormats formats() const;

 private:
  std::string only_;
  int compression_ = 0;
};

}  // namespace binnacle::command
