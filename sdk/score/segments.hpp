// SPDX-License-Identifier: Apache-2.0
// Errors over segments of a track, by KITTI's measure.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/composition.hpp"
#include "binnacle/state_bytes.hpp"
#include "binnacle/time.hpp"

namespace binnacle::score {

/// Where a block's metrics have the name of an error: "position.segments".
inline constexpr const char* segments_name = "segments";

/// KITTI's own, unless "evaluate" has "segments".
struct SegmentSettings {
  std::vector<double> lengths{100, 200, 300, 400, 500, 600, 700, 800};  // m, of the true path
  Time every = 100'000'000;                                             // ns, from pose to pose of the path
  int start_every = 10;  // a segment of each length starts at each tenth pose
  std::string attitude;  // block; empty: the only one that is scored
};

/// Means over all segments of all lengths. Of a segment from pose i to pose j, with the error
/// E = (T̂_i⁻¹ T̂_j)⁻¹ (T_i⁻¹ T_j): translation is |E's translation| / length, rotation E's angle / length.
struct SegmentErrors {
  double translation = 0;  // 1
  double rotation = 0;     // rad/m
  int count = 0;           // of segments; 0: none is long enough
  int poses = 0;           // that the path has
};

/// A position and an attitude that references give in full, with their errors, wherever both are given at one time.
class SegmentTrack {
 public:
  explicit SegmentTrack(const BlockInfo& position) : position_block_(&position) {}

  /// truth: the block's stored value; delta: truth ⊟ estimate [m].
  void take_position(Time t, const double* truth, const double* delta);
  /// phi: truth ⊟ estimate [rad], C_true = exp([φ×]) Ĉ.
  void take_attitude(Time t, const double* phi);
  /// Means over the segments inside the span. A pose is taken at each multiple of `every` after the first, of the time
  /// nearest to it.
  SegmentErrors errors(const SegmentSettings& settings, const TimeSpan& span, Time start) const;
  void exchange(StateBytes& bytes);

 private:
  /// An error at a time, and for a position the truth's stored value.
  struct Errors {
    std::vector<Time> t;
    std::vector<std::array<double, 3>> values;
  };
  struct Pose {
    std::size_t position = 0, attitude = 0;  // indices of the two
  };
  std::vector<Pose> path(Time every, const TimeSpan& span, Time start) const;
  Eigen::Vector3d displacement(const Pose& from, const Pose& to) const;

  const BlockInfo* position_block_;
  Errors position_, attitude_;
  std::vector<double> truths_;  // of position_, one after the other
};

}  // namespace binnacle::score
