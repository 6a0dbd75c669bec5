// SPDX-License-Identifier: Apache-2.0
// Metric: one figure of a run, FILTER/BLOCK.OUTPUT/STATISTIC.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "binnacle/time.hpp"
#include "binnacle/unit.hpp"

namespace binnacle {
class Composition;
}

namespace binnacle::score {

/// What is looked at: an error (truth minus estimate by the block's ⊟) or norm of errors, the filter's own 1-σ of it, how
/// well the two agree (NEES: of the whole state, of a block, or of one error component), or a measurement's mean NIS.
enum class MetricQuantity { error, sigma, nees, nis };
enum class NeesOf { component, block, state };

/// The whole state, where a block's name would stand. A block of that name keeps it, and there is no figure of the whole
/// state then.
inline constexpr const char* state_name = "state";

/// Over time, of what is scored (`evaluate`'s after and until). `mean`, `final` and `at` are signed, the others of the
/// magnitude. `at`: at one time, interpolated between the two scored samples around it, wherever `evaluate` begins.
/// `drift`: the last less the first, signed; of a block of kind `attitude`, whose ⊟ ends at half a turn, with whole turns
/// counted from sample to sample.
enum class MetricStatistic { mean, rms, max, final, p50, p95, drift, at };

struct Metric {
  std::string name;  // "ins/position.horizontal/rms"
  int filter = 0;
  MetricQuantity quantity = MetricQuantity::error;
  MetricStatistic statistic = MetricStatistic::rms;
  int subject = 0;  // its reader's own: which error, block or measurement
  NeesOf nees_of = NeesOf::component;
  Time at = 0;
  bool at_is_from_start = false;
  std::string unit;  // for display; parse_unit reads it
  std::string si_unit;
};

/// A metric of one run, in SI; NaN where nothing was scored. For nees and nis: the degrees of freedom of one sample of χ²
/// and how many independent samples the value is the mean of (1 for a nees, whose samples are correlated in time).
struct MetricValue {
  double value = 0;
  double dof = 0;
  double n = 0;
};

/// A metric of "evaluate" that means nothing where patches were merged over the config: what it is of may be gone with
/// them, or it is misspelt, which who knows the other variants can find out.
struct UnknownMetric {
  std::string name;
  std::string pointer;
  std::string error;  // one line, with the nearest name
};

/// Of a composition whose config was patched (a study's variant); without patches an unknown metric is an error.
std::vector<UnknownMetric> unknown_metrics(const Composition& composition);

/// Reads `FILTER/BLOCK.OUTPUT/STATISTIC` against what the composition's references score. Statistics: `mean`, `rms`,
/// `max`, `final`, `drift`, `p50`, `p95`, `at 100 s`, `at start+100 s`; `sigma`: 1-σ where `final` is taken; `sigma at 100 s`;
/// FILTER/BLOCK/nees: its mean over time; `nees at 100 s`; FILTER/state/nees: of all blocks that references give in full
/// together; FILTER/MEASUREMENT/nis: the mean of the accepted samples. The failure is one line with what was likely meant.
Parsed<Metric> read_metric(const Composition& composition, std::string_view text);

/// Shows the metric in this unit. Empty, or one line that says why it cannot be.
std::string show_in(Metric& metric, std::string_view unit);

}  // namespace binnacle::score
