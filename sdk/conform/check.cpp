// SPDX-License-Identifier: Apache-2.0
#include "check.hpp"

namespace binnacle::conform {

const char* status_name(Status status) {
  switch (status) {
    case Status::pass: return "pass";
    case Status::warn: return "warn";
    case Status::fail: return "fail";
    case Status::crash: return "crash";
    case Status::timeout: return "timeout";
    case Status::skip: return "skip";
  }
  return "";
}

const std::vector<Check>& all_checks() {
  static const std::vector<Check> checks = [] {
    std::vector<Check> all;
    for (const auto& part :
         {load_checks(), metadata_checks(), life_checks(), block_checks(), process_checks(), measurement_checks(),
          derived_checks(), noise_checks(), stream_checks(), robustness_checks(), speed_checks()})
      all.insert(all.end(), part.begin(), part.end());
    return all;
  }();
  return checks;
}

}  // namespace binnacle::conform
