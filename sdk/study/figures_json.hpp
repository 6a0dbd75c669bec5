// SPDX-License-Identifier: Apache-2.0
// What came of one run as JSON: a line of the journal, a message of a group of workers. Numbers come back bit for bit.
#pragma once

#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "study/workers.hpp"

namespace binnacle::study {

/// [variant, run, figures]
nlohmann::ordered_json entry_of(RunKey key, const Figures& figures);

/// Nothing where it is no such entry, or one with another number of metrics.
std::optional<std::pair<RunKey, Figures>> read_entry(const nlohmann::ordered_json& entry, std::size_t metrics);

/// On one line; what is no UTF-8 is replaced.
std::string line_of(const nlohmann::ordered_json& json);

}  // namespace binnacle::study
