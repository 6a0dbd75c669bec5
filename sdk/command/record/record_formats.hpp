// SPDX-License-Identifier: Apache-2.0
// In which formats a run is recorded.
#pragma once

#include <string>

namespace binnacle::command {

struct RecordFormats {
  bool nc = true, csv = true, page = true;
  int compression = 0;  // of run.nc: 1 (least) to 9; 0: none

  /// "nc,csv,page": these alone. Throws UsageError where it names another, or none.
  void keep_only(const std::string& list);
};

}  // namespace binnacle::command
