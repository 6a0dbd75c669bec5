// SPDX-License-Identifier: Apache-2.0
// Reads "table" of a study: rows and columns to the variant, metric and statistic of every cell.
#pragma once

#include <string>
#include <vector>

#include "study/section.hpp"
#include "study/study.hpp"

namespace binnacle::study {

/// Pointers of the tables in `place`, "/study": of its "table" and "tables", each an object or a list of them.
std::vector<std::string> table_pointers(const Section& section, const std::string& place);

/// Pointers of the metrics that a table, its rows and its columns name.
std::vector<std::string> table_metric_pointers(const Section& section, const std::string& table);

TablePlan read_table(const Section& section, const std::string& pointer, const std::vector<std::string>& variants,
                     const std::vector<StudyMetric>& metrics);

}  // namespace binnacle::study
