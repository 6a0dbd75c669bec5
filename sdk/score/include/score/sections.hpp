// SPDX-License-Identifier: Apache-2.0
// The sections of a config that are not the kernel's: what judges a run, and what studies and analyses are made of.
#pragma once

#include <filesystem>
#include <memory>

#include "binnacle/composition.hpp"
#include "binnacle/config.hpp"

namespace binnacle::score {

/// The options with readers of `reference`, `evaluate`, `record` and the filters' `implied_states`, and with `study`,
/// `covariance` and `metrics` left to those who read them from Composition::config().
LoadOptions with_sections(LoadOptions options = {});

/// Composition::load() with those sections.
std::shared_ptr<const Composition> load(const std::filesystem::path& config, const LoadOptions& options = {});
/// Composition::parse() with them.
std::shared_ptr<const Composition> parse(std::string_view text, const std::filesystem::path& name,
                                         const LoadOptions& options = {});
/// Config::load() with them.
Config load_config(const std::filesystem::path& config, const LoadOptions& options = {});

}  // namespace binnacle::score
