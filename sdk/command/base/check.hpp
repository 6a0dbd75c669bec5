// SPDX-License-Identifier: Apache-2.0
// check: what the command and binnacle-study have in common of it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "binnacle/config.hpp"
#include "binnacle/diagnostic.hpp"
#include "verbs.hpp"

namespace binnacle::command {

/// How one config is checked: the warnings, or what is thrown as by Composition::load.
using WarningsOf = std::function<Diagnostics(const std::filesystem::path& config, const LoadOptions& options)>;
/// Sees the configs before the first of them is checked.
using BeforeCheck = std::function<void(const std::vector<std::string>& configs, const LoadOptions& options)>;

Verb add_check(CLI::App& command, const WarningsOf& warnings_of, const BeforeCheck& before = nullptr);

}  // namespace binnacle::command
