// SPDX-License-Identifier: Apache-2.0
// The fields of one channel of a config as Allan variances.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "allan/allan.hpp"
#include "binnacle/config.hpp"
#include "binnacle/diagnostic.hpp"

namespace binnacle::command {

/// One field of the channel. A level is taken as it is, an increment over its interval.
struct AllanField {
  std::string name;
  std::string unit;  // of the signal: "rad/s"
  std::int64_t invalid = 0;
  std::vector<allan::Point> points;
  allan::Fit fit;
};

struct AllanChannel {
  std::string name;
  double interval = 0;  // the median between labels, s
  double seconds = 0;   // from the first label to the last
  std::int64_t samples = 0;
  std::int64_t gaps = 0;      // longer than 1.5 intervals: averages do not reach over them
  double missing = 0;         // s, in gaps
  std::int64_t repeated = 0;  // labels less than half an interval after the one before, or not after it: left out
  std::vector<AllanField> fields;
  Diagnostics warnings;  // of the run
};

/// Runs the sources and transforms of a config, without its filters where these give nothing to it, and takes the channel.
/// full: up to this averaging time [s] differences overlap fully. goes_on: asked now and then;
/// false: it stops. Throws UsageError where there is no such channel.
AllanChannel allan_channel(const std::string& config, const LoadOptions& options, const std::string& channel,
                           double full, std::uint64_t seed, const std::function<bool()>& goes_on);

nlohmann::ordered_json allan_json(const AllanChannel& channel);
std::string allan_text(const AllanChannel& channel);
/// Deviations over averaging times, both logarithmic, a panel for each unit.
std::string allan_svg(const AllanChannel& channel);

}  // namespace binnacle::command
