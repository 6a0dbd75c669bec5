// SPDX-License-Identifier: Apache-2.0
// Covariance analysis of every variant of a config: the true error of a filter without drawing a single number.
#pragma once

#include <filesystem>
#include <functional>

#include <nlohmann/json.hpp>

#include "study/study.hpp"

namespace binnacle::covariance {

/// Whether the config has a "covariance" at all.
bool is_in(const Config& config);

/// The variants, metrics and tables of the config, everything in "covariance" checked. Throws as study::Study::load does.
study::Study load(const std::filesystem::path& config, const LoadOptions& options = {});

/// Thrown where `goes_on` says no.
struct Interrupted {};

/// Runs every variant once on covariances and summarizes it as a study of one run, study::summarize(); each variant also
/// has its "budget": { FILTER/NAME: { SOURCE: share of the final variance } }. What breaks is listed under "failures".
/// goes_on: asked every now and then.
nlohmann::ordered_json analyse(
    const study::Study& study, const std::filesystem::path& config, const LoadOptions& options = {},
    const std::function<bool()>& goes_on = [] { return true; });

}  // namespace binnacle::covariance
