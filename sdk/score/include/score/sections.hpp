// SPDX-License-Identifier: Apache-2.0
// The sections of a config that are not the kernel's: what judges a run, and what studies and analyses are made of.
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "binnacle/composition.hpp"
#include "binnacle/config.hpp"
#include "binnacle/time.hpp"

namespace binnacle::score {

/// Where a config gives no limit. The start of a filter may be added to its ends.
inline constexpr TimeSpan all_time{std::numeric_limits<Time>::min() / 4, std::numeric_limits<Time>::max() / 4};

/// The options with readers of `reference`, `evaluate`, `record` and the filters' `implied_states`, and with `study`,
/// `covariance` and `metrics` left to those who read them from Composition::config().
LoadOptions with_sections(LoadOptions options = {});

/// Composition::load() with those sections.
std::shared_ptr<const Composition> load(const std::filesystem::path& config, const LoadOptions& options = {});
/// Composition::parse() with them.
std::shared_ptr<const Composition> parse(std::string_view text, const std::filesystem::path& name,
                                         const LoadOptions& options = {});
/// Composition::of() with them.
std::shared_ptr<const Composition> compose(const Config& config, const LoadOptions& options);
/// Config::load() with them.
Config load_config(const std::filesystem::path& config, const LoadOptions& options = {});

/// LoadOptions::sets by which a filter of a config takes Jacobians, whatever its `propagation` and its measurements' `update`: where
/// P is not what it believes, sigma points would be of what it never did.
std::vector<std::string> by_jacobians(const nlohmann::ordered_json& config, const std::string& filter);

}  // namespace binnacle::score
