// SPDX-License-Identifier: Apache-2.0
// The verdict of a summary, and what limits of the user make of it.
#pragma once

#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "binnacle/trust.hpp"

namespace binnacle::score {

/// The largest errors that do not matter, in SI units, by block: "position": 2. The limit of an estimate is the larger of
/// that of its block and 3 σ.
using Limits = std::map<std::string, double>;

/// Puts each reason of innovations (B103 to B105) of the "verdict" of a filter where the limits have it: among its "notes"
/// if the errors that it shows are small, else among its "reasons". Renews "state" and "limits".
///
/// A bias or correlation is small if the upper bound of what it did to each estimate stays below half of the limit, NIS if
/// not more than 1 % of errors are beyond it. A recovery (B106) that moved a position by more than ten limits is "lost".
void apply_limits(nlohmann::ordered_json& verdict, const Limits& limits);

/// "ok", "doubtful" or "lost", as "state" of a verdict has it.
Verdict verdict_of(const nlohmann::ordered_json& verdict);

}  // namespace binnacle::score
