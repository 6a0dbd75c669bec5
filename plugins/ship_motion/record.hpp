// SPDX-License-Identifier: Apache-2.0
// A recorded motion: one column of a text file, without its mean.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"

namespace binnacle::ship_motion {

/// Samples a constant time apart, but for jitter.
struct Record {
  std::vector<Time> times;
  Eigen::VectorXd values;  // SI, less the mean
  double mean = 0;         // SI
  double interval = 0;     // s
};

/// Which column of which file.
struct RecordPlace {
  std::string path;
  std::string column;
  std::string time_column;  // "": the first
  double unit = 1;          // of the column, in SI
  Time from = std::numeric_limits<Time>::min(), to = std::numeric_limits<Time>::max();

  static std::vector<ParameterSpec> parameters();
  /// The parameter `record` of `owner`, which stands at `pointer`. `si_unit`: that of the motion. Throws ComponentError where the
  /// unit is another thing or the header lacks a column.
  RecordPlace(const Parameters& owner, const std::string& si_unit, const std::string& pointer);
  /// Throws ComponentError::in_data at a bad number, or where a sample is missing.
  Record read() const;
};

}  // namespace binnacle::ship_motion
