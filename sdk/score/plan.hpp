// SPDX-License-Identifier: Apache-2.0
// What a composition's runs are judged by, as the config has it: immutable, kept by the composition.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/local_axes.hpp"
#include "binnacle/section.hpp"
#include "motion_fields.hpp"
#include "score/metric.hpp"
#include "score/sections.hpp"
#include "score/verdict.hpp"
#include "segments.hpp"
#include "smooth/fixed_lag.hpp"

namespace binnacle::score {

/// An implied state: a block as one measurement gives it, all else that is in the measurement taken from the filter.
struct ImpliedStatePlan {
  BlockInfo value;  // the block's, under the implied state's name and with rows counted from 0
  int measurement = 0;
  int block = 0;
};

/// What a filter is scored against: a block's outputs on a channel, or what was withheld from a measurement.
struct ReferencePlan {
  int filter = 0;
  int block = -1;          // −1: withheld samples of `measurement`
  int implied_state = -1;  // ≥ 0: this implied state of the block, not the block
  int channel = -1;
  std::vector<int> fields;        // per output of the block: per-epoch field of the channel, −1: not given
  std::optional<double> invalid;  // a sample whose fields all have this value gives nothing
  int measurement = -1;
};

/// Where a span stands in the config.
struct Place {
  std::string pointer;
  Origin origin;
};

struct NamedWindow {
  std::string name;
  int filter = -1;  // −1: all
  TimeSpan span;
  Place place;
};

/// A filter that is smoothed, `of`, and what comes of it, `as`; both of ScorePlan::filters.
struct SmoothingPlan {
  int of = 0;
  int as = 0;
  int iterations = 0;
  std::optional<smooth::Lag> lag;  // nothing: fixed interval
};

struct ScorePlan : SectionData {
  std::vector<FilterInfo> filters;  // of the composition, then "ins.smoothed" and the like
  std::vector<SmoothingPlan> smoothings;
  std::vector<std::vector<ImpliedStatePlan>> implied_states;  // by filter
  std::vector<Limits> limits;                                 // by filter of the composition
  std::vector<ReferencePlan> references;
  TimeSpan span = all_time;
  Place place;                       // of the span, where the config gives one
  std::vector<MotionFields> motion;  // of the filters that have any
  std::vector<NamedWindow> windows;
  SegmentSettings segments;
  std::vector<Metric> metrics;
  std::vector<UnknownMetric> unknown_metrics;
  std::optional<geodesy::LocalAxes> local;   // of the config's origin, where it has one
  Time record_every = 0;                     // 0: at every step
  Estimates estimates = Estimates::settled;  // of filters with history: what is scored and recorded

  std::string explain(int filter) const override;
  /// Emits on the channels of fixed lags (lag_channels.cpp).
  std::shared_ptr<binnacle::RunObserver> part() const override;
};

/// The composition's own; one that scores nothing where it was loaded without the sections.
std::shared_ptr<const ScorePlan> plan_of(const Composition& composition);

/// As score::read_metric().
Parsed<Metric> read_metric(const ScorePlan& plan, std::string_view text);

}  // namespace binnacle::score
