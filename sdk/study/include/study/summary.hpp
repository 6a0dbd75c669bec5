// SPDX-License-Identifier: Apache-2.0
// What a study reports: its figures as JSON and as CSV.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "study/study.hpp"

namespace binnacle::study {

/// { "runs", "seed", "variants": { NAME: { "runs", "failed", "metrics": { METRIC: { "rms", "mean", "std", "se", "se_rms",
///   "p50", "p95", "max", "n", "unit" } }, "failures": [ { "run", "reason" } ] } }, "table": { "title", "rows", "columns",
///   "cells", "se", "units", "paper" }, "tables": [ … ] }. A nees or nis also has its "band": [low, high], where 99 % of
/// such means lie if the filter is consistent. "tables" where there are several; "table" is the first.
nlohmann::ordered_json summarize(const Study& study, const Results& results);

/// variant,run,seed,metric,value,unit: a line per figure of every run; the value is empty where the run failed.
std::string runs_csv(const Study& study, const Results& results);

/// table,row,column,value,se,unit,paper: a line per cell, from what summarize() returned.
std::string tables_csv(const nlohmann::ordered_json& summary);

}  // namespace binnacle::study
