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

/// Where turning shows the antenna, in the axes of the channel `imu` as the file has them.
struct SeenLeverArm {
  std::string imu, gnss;
  Eigen::Vector3d value;       // m
  Eigen::Matrix3d covariance;  // m^2
};

/// Of a record that begins at rest, and of a vehicle that then moves off along its x axis.
struct Start {
  double seconds = 0;                          // of rest at the begin
  double gyro_scatter = 0, force_scatter = 0;  // of a sample at rest, of the worst axis [rad/s, m/s^2]
  double gyro_noise = 0, force_noise = 0;      // densities, if they are white [rad/s/sqrt(Hz), m/s^2/sqrt(Hz)]
};

struct Inspection {
  std::vector<Channel> channels;
  Findings findings;  // warnings first, in the order of channels
  std::vector<Plot> plots;
  std::optional<Eigen::Matrix3d> mounting;  // C_vb: sensor to vehicle axes (forward, right, down), columns of the file
  double delay = 0;                         // s: a fix at label t was taken at t - delay of the IMU's labels
  std::optional<Start> start;
  std::optional<SeenLeverArm> lever_arm;  // none, too, where the file's axes are wrong
};

/// All of it is kept in memory: eight bytes a number.
Inspection inspect(std::vector<Channel> channels);

/// What a config says of it.
struct StatedLeverArm {
  std::string pointer;    // "/filters/ins/derived/antenna"
  std::string imu, gnss;  // channels of sources
  Eigen::Vector3d value;  // in the filter's axes [m]
  Eigen::Matrix3d C_bs;   // from the axes of `imu` to the filter's
};
/// A finding for each that turning has something to say of: its difference in sigma, a warning beyond three.
void compare_lever_arms(const std::vector<StatedLeverArm>& stated, Inspection& inspection);

/// A config of these channels with every remedy of the findings in it, or null with the reason.
struct Proposal {
  Json config = nullptr;
  std::string reason;
  std::vector<std::string> notes;  // where its values are from, a line each
};
/// folder: paths in the config are relative to it where they can be. base: the config that was inspected, which the proposal
/// extends; empty: the files were bare.
Proposal propose(const Inspection& inspection, const std::string& folder, const std::string& base);

Json to_json(const Inspection& inspection);
/// One HTML page with pictures, without scripts.
std::string page(const Inspection& inspection, const std::string& title);

}  // namespace binnacle::inspect
