// SPDX-License-Identifier: Apache-2.0
// The suite's results as text, JSON and JUnit XML.
#pragma once

#include <string>

#include "driver.hpp"

namespace binnacle::conform {

std::string one_line(const Outcome& outcome);
/// What did not pass, with its message, then the counts and the verdict.
std::string summary(const Verdict& verdict, const Options& options, bool strict, bool verbose);
std::string to_json(const Verdict& verdict, const Options& options, bool strict);
std::string to_junit(const Verdict& verdict, const Options& options, bool strict);

}  // namespace binnacle::conform
