// SPDX-License-Identifier: Apache-2.0
// What values are worth on data: likelihood, NIS, withheld samples; for the part that was not tuned on.
#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include "log_recorder.hpp"
#include "runs.hpp"
#include "tune/plan.hpp"

namespace binnacle::tune {

/// Of one sample that was accepted or withheld.
struct JudgedSample {
  int measurement = 0;
  Time t = no_time;
  bool is_withheld = false;
  double nis = 0, likelihood = 0;
  std::vector<std::int64_t> keys;
  std::vector<int> groups;
  std::vector<double> residual;
};

/// Every filter of one config: its samples in order, before or after `until`.
struct Judgement {
  std::shared_ptr<const Composition> composition;
  std::vector<std::vector<JudgedSample>> filters;
};

/// is_after: what comes after `until` alone; else what comes before. Throws FilterError where a filter breaks.
Judgement judge(const Member& member, const std::vector<std::string>& sets, const std::optional<When>& until,
                bool is_after, const RunSettings& settings);

/// The withheld samples: −ln p, or rows × ln RMS summed over row groups. NaN where there is none.
double withheld_nll(const std::vector<Judgement>& all);
double withheld_rms(const std::vector<Judgement>& all);

/// { "likelihood": {"start", "end", "rows", "rows_start", "rows_end"}, "measurements": { FILTER/M: {…} } }: the likelihood is
/// that of samples which both accept with the same rows.
Json compared(const std::vector<Judgement>& start, const std::vector<Judgement>& end);

}  // namespace binnacle::tune
