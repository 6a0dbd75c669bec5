// SPDX-License-Identifier: Apache-2.0
// A window once more along one path, to which no measurement makes a correction.
#pragma once

#include <filesystem>
#include <string>

#include <Eigen/Core>

#include "binnacle/config.hpp"
#include "observe/observe.hpp"
#include "observe/window.hpp"

namespace binnacle::observe {

struct OnePath {
  Eigen::MatrixXd removed;  // D of the window, linearized along the path; empty where it could not be had
  std::string why_not;
};

/// Runs the config again up to the window's end with all samples of the filter inside of it withheld: Φ and H are then those of the one
/// path that the filter takes from the window's start without corrections, for the samples that were accepted, with the R that they had.
/// Throws as a run does.
OnePath on_one_path(const std::filesystem::path& config, const LoadOptions& options, const RunKey& key, int filter,
                    const FilterInfo& info, const Stay& stay);

}  // namespace binnacle::observe
