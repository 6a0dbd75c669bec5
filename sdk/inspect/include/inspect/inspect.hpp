// SPDX-License-Identifier: Apache-2.0
// Looks at recorded channels before a filter does.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "inspect/channel.hpp"
#include "inspect/finding.hpp"

namespace binnacle::inspect {

using Findings = std::vector<Finding>;

struct Plot {
  struct Line {
    std::string name;
    std::vector<double> x, y;
  };
  std::string title, x_label, y_label;
  std::vector<Line> lines;
};

struct Inspection {
  std::vector<Channel> channels;
  Findings findings;  // warnings first, in the order of channels
  std::vector<Plot> plots;
  std::optional<Eigen::Matrix3d> mounting;  // C_vb: sensor to vehicle axes (forward, right, down), columns of the file
  double delay = 0;                         // s: a fix at label t was taken at t - delay of the IMU's labels
};

/// All of it is kept in memory: eight bytes a number.
Inspection inspect(std::vector<Channel> channels);

/// A config of these channels with every remedy of the findings in it, or null with the reason.
struct Proposal {
  Json config = nullptr;
  std::string reason;
};
/// folder: paths in the config are relative to it where they can be. base: the config that was inspected, which the proposal
/// extends; empty: the files were bare.
Proposal propose(const Inspection& inspection, const std::string& folder, const std::string& base);

Json to_json(const Inspection& inspection);
/// One HTML page with pictures, without scripts.
std::string page(const Inspection& inspection, const std::string& title);

}  // namespace binnacle::inspect
