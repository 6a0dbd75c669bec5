// SPDX-License-Identifier: Apache-2.0
// Finding: one thing that the data show, with its figure, its evidence, and what it means for the config.
#pragma once

#include <limits>
#include <string>

#include <nlohmann/json.hpp>

namespace binnacle::inspect {

using Json = nlohmann::ordered_json;

enum class Severity {
  finding,  // what the data are
  warning,  // what a filter would go wrong by
  unknown,  // what these data cannot show
};

struct Finding {
  std::string kind;     // "gap", "rate_unit", "mounting": the list in sdk/docs/verbs/inspect.md
  std::string channel;  // "imu", or "imu, gnss" between two
  std::string field;    // "wx"; several: "wx, wy, wz"; empty: the channel
  double value = std::numeric_limits<double>::quiet_NaN();
  double sigma = std::numeric_limits<double>::quiet_NaN();  // of the value, where it is estimated with one
  std::string unit;
  std::string text;                                        // a sentence, with the figure
  std::string evidence;                                    // what it was seen by
  double from = std::numeric_limits<double>::quiet_NaN();  // s since the channel's first label
  double to = std::numeric_limits<double>::quiet_NaN();
  double confidence = 1;   // that the kind is right, from the statistic's false-alarm rate
  Json meaning = nullptr;  // a merge patch of the config, or null
  Severity severity = Severity::finding;
};

}  // namespace binnacle::inspect
