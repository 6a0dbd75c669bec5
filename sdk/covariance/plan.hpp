// SPDX-License-Identifier: Apache-2.0
// What "covariance" of a config asks for, bound to a composition.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/config.hpp"
#include "binnacle/metric.hpp"

namespace binnacle::covariance {

/// A channel that is fed the same values at a fixed rate: an instant from time 0 on, or intervals that begin there.
struct Feed {
  std::string channel;
  Time interval = 0;
  bool is_of_intervals = false;
  std::vector<double> values;  // one per field of the channel [SI]
};

/// A reading less what the filter says of everything in it but one block: z − h(x̂ without that block).
struct ReadingOutput {
  std::string name;
  std::string measurement;
  std::string block;  // what is wanted
};

struct Plan {
  Time duration = 0;
  int filter = 0;
  std::vector<Feed> feeds;
  std::vector<ReadingOutput> outputs;
  std::shared_ptr<const Composition> model;
  std::shared_ptr<const Composition> truth;  // the same as `model` where the config states no other
};

/// Tells what is wrong in `diagnostics`.
Plan read_plan(const Config& config, const std::filesystem::path& path,
               const std::shared_ptr<const Composition>& composition, Diagnostics& diagnostics);

enum class Statistic { sigma, own_sigma, settled };

/// FILTER/NAME/STATISTIC: `sigma`, `own sigma` (each with `at 100 s` or at the end), `settled`.
struct Request {
  std::string name;  // of an output, or BLOCK, or BLOCK.COMPONENT
  Statistic statistic = Statistic::sigma;
  Time at = no_time;  // no_time: at the end
};

Parsed<Metric> read_metric(const Composition& composition, std::string_view text);
Request request_of(const std::string& metric);

}  // namespace binnacle::covariance
