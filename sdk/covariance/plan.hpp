// SPDX-License-Identifier: Apache-2.0
// What "covariance" of a config asks for, bound to a composition.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/composition.hpp"
#include "binnacle/config.hpp"
#include "binnacle/state_block.hpp"
#include "score/metric.hpp"

namespace binnacle::covariance {

/// A channel that is fed the same values at a fixed rate: an instant from time 0 on, or intervals that begin there.
struct Feed {
  std::string channel;
  Time interval = 0;
  bool is_of_intervals = false;
  std::vector<double> values;  // one per field of the channel [SI]
};

/// An implied state of the filter, or another name that the section gives it.
struct NamedImpliedState {
  std::string name;
  std::string measurement;
  std::string block;
};

/// The error of a block at the start is, besides its own, that of another one through a matrix (both in error components).
struct InitialTie {
  std::string block, of;
  Eigen::MatrixXd by;
};

/// What is run on covariances: one composition, in which the truth is a filter beside the filter.
struct Plan {
  Time duration = 0;        // 0: until the sources end
  int runs = 1;             // of the sources, with the random numbers of a study's first runs
  std::vector<Feed> feeds;  // empty: the composition's sources are run
  std::vector<NamedImpliedState> implied_states;
  std::vector<InitialTie> initial;  // of the truth
  std::shared_ptr<const Composition> composition;
  int filter = 0;
  int truth = 0;  // the same as `filter` where the config states no other
};

/// Reports what is wrong in `diagnostics`.
Plan read_plan(const Config& config, const std::filesystem::path& path, const LoadOptions& options,
               const std::shared_ptr<const Composition>& composition, Diagnostics& diagnostics);

/// "runs" of the section, 1 where it says nothing of use.
int runs_of(const Config& config);

/// What the middle of a metric names.
struct SubjectName {
  std::string block;
  std::string component;  // "": the only one
  std::optional<NamedImpliedState> implied_state;
};
SubjectName subject_named(const std::string& name, const std::vector<NamedImpliedState>& implied_states);

/// What the name after BLOCK. means: error components (several: a norm), or a readable output.
struct Component {
  std::vector<int> errors;
  int output = -1;
};
/// "": the first error component.
std::optional<Component> component_named(const StateBlockDeclaration& block, const std::string& name);

enum class Statistic { sigma, own_sigma, settled };

/// FILTER/NAME/STATISTIC: `sigma`, `own sigma` (each with `at 100 s` or at the end), `settled`.
struct Request {
  std::string name;  // of an output, or BLOCK, or BLOCK.COMPONENT
  Statistic statistic = Statistic::sigma;
  Time at = no_time;  // no_time: at the end
};

Parsed<score::Metric> read_metric(const Composition& composition, std::string_view text);
Request request_of(const std::string& metric);

}  // namespace binnacle::covariance
