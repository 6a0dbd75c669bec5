// SPDX-License-Identifier: Apache-2.0
// Whether the velocity and the position of one channel show the same motion.
#pragma once

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

#include "binnacle/state_bytes.hpp"
#include "binnacle/time.hpp"
#include "motion_fields.hpp"

namespace binnacle::score {

/// Displacements over some seconds, in metres north, east, down, regressed on the mean of the velocity fields: the matrix
/// is the identity where axes, signs and scales are right. It needs neither the filter nor its attitude, and keeps
/// nothing but sums.
class FieldFit {
 public:
  /// `position`: lat, lon [rad], height [m]; `velocity`: north, east, down [m/s].
  void add(Time t, const Eigen::Vector3d& position, const Eigen::Vector3d& velocity);

  void exchange(StateBytes& bytes);

  /// What is wrong, if that is significant; empty where nothing is, or too little motion says anything.
  std::vector<std::string> words(const FixFields& fix) const;
  /// Whether there was motion enough, and the fields agree.
  bool is_right() const;

 private:
  /// Rows: the way went; columns: the field that says so. `is_exchanged`: latitude taken for longitude and reverse.
  struct Fitted {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity(), sigma = Eigen::Matrix3d::Zero();
    std::array<bool, 3> is_moving{}, is_explained{};  // by column, by row
    bool is_identity() const;
    bool is_wrong(int row, int column, double by) const;
  };
  struct Sums {
    Eigen::Matrix3d vd = Eigen::Matrix3d::Zero();  // column i: Σ v dᵢ
    Eigen::Vector3d dd = Eigen::Vector3d::Zero();
  };
  Fitted fitted(bool is_exchanged) const;

  Time begin_ = no_time, last_ = no_time;
  Eigen::Vector3d begin_position_ = Eigen::Vector3d::Zero(), last_velocity_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d way_ = Eigen::Vector3d::Zero();  // ∫ v dt since begin_
  Eigen::Matrix3d vv_ = Eigen::Matrix3d::Zero();
  Sums as_labelled_, exchanged_;
  double count_ = 0;
};

}  // namespace binnacle::score
