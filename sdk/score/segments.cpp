// SPDX-License-Identifier: Apache-2.0
#include "segments.hpp"

#include <algorithm>

#include <Eigen/Geometry>

#include "binnacle/state_block.hpp"
#include "record_epochs.hpp"
#include "wording/block_call.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Quaterniond rotation(const std::array<double, 3>& vector) {
  const Vector3d phi(vector[0], vector[1], vector[2]);
  const double angle = phi.norm();
  return angle > 0 ? Quaterniond(Eigen::AngleAxisd(angle, phi / angle)) : Quaterniond::Identity();
}

Vector3d vector(const std::array<double, 3>& values) { return {values[0], values[1], values[2]}; }

}  // namespace

void SegmentTrack::take_position(Time t, const double* truth, const double* delta) {
  position_.t.push_back(t);
  position_.values.push_back({delta[0], delta[1], delta[2]});
  truths_.insert(truths_.end(), truth, truth + position_block_->declaration->stored_size);
}

void SegmentTrack::take_attitude(Time t, const double* phi) {
  attitude_.t.push_back(t);
  attitude_.values.push_back({phi[0], phi[1], phi[2]});
}

void SegmentTrack::exchange(StateBytes& bytes) {
  for (Errors* errors : {&position_, &attitude_}) {
    bytes.list(errors->t);
    bytes.list(errors->values);
  }
  bytes.list(truths_);
}

std::vector<SegmentTrack::Pose> SegmentTrack::path(Time every, const TimeSpan& span, Time start) const {
  std::vector<Pose> all, taken;
  for (std::size_t p = 0, a = 0; p < position_.t.size(); ++p) {
    while (a < attitude_.t.size() && attitude_.t[a] < position_.t[p]) ++a;
    if (a == attitude_.t.size()) break;
    if (attitude_.t[a] == position_.t[p] && span.contains(position_.t[p], start)) all.push_back({p, a});
  }
  RecordEpochs epochs(every);
  Pose kept;
  using Choice = RecordEpochs::Choice;
  for (const Pose& pose : all) {
    const Choice choice = epochs.on(position_.t[pose.position]);
    if (choice == Choice::release || choice == Choice::release_and_take || choice == Choice::release_and_keep)
      taken.push_back(kept);
    if (choice == Choice::take || choice == Choice::release_and_take) taken.push_back(pose);
    if (choice == Choice::keep || choice == Choice::release_and_keep) kept = pose;
  }
  if (epochs.finish()) taken.push_back(kept);
  return taken;
}

/// Of the true path [m], in the axes of the block's error.
Vector3d SegmentTrack::displacement(const Pose& from, const Pose& to) const {
  const BlockInfo& block = *position_block_;
  const int size = block.declaration->stored_size;
  const auto truth = [&](const Pose& pose) {
    return ConstVectorView(truths_.data() + pose.position * as_size(size), size);
  };
  Vector3d difference;
  call_block(block, "minus", position_.t[to.position], [&] {
    block.block->minus(truth(to), truth(from), {difference.data(), 3});
  });
  return difference;
}

// With C = exp([φ×]) Ĉ at both ends and δ = p − p̂, the error of a segment is, in the axes at its begin,
//   translation: (p_j − p_i) − exp([φ_i×]) (p̂_j − p̂_i)     rotation: exp([φ_i×])ᵀ exp([φ_j×])
// of which KITTI's E has the same length and the same angle, whatever axes of the body C is of. North at j is taken for
// north at i, which over a kilometre changes an error by 1e-4 of itself.
SegmentErrors SegmentTrack::errors(const SegmentSettings& settings, const TimeSpan& span, Time start) const {
  const std::vector<Pose> poses = path(settings.every, span, start);
  std::vector<double> travelled(poses.size(), 0.0);
  for (std::size_t i = 1; i < poses.size(); ++i)
    travelled[i] = travelled[i - 1] + displacement(poses[i - 1], poses[i]).norm();
  SegmentErrors sum;
  sum.poses = static_cast<int>(poses.size());
  for (std::size_t i = 0; i < poses.size(); i += as_size(settings.start_every)) {
    const Quaterniond at_begin = rotation(attitude_.values[poses[i].attitude]);
    for (const double length : settings.lengths) {
      const auto end = std::upper_bound(travelled.begin(), travelled.end(), travelled[i] + length);
      if (end == travelled.end()) continue;
      const Pose& last = poses[as_size(static_cast<int>(end - travelled.begin()))];
      const Vector3d truth = displacement(poses[i], last);
      const Vector3d estimate =
          truth - vector(position_.values[last.position]) + vector(position_.values[poses[i].position]);
      sum.translation += (truth - at_begin * estimate).norm() / length;
      sum.rotation += at_begin.angularDistance(rotation(attitude_.values[last.attitude])) / length;
      ++sum.count;
    }
  }
  if (sum.count > 0) {
    sum.translation /= sum.count;
    sum.rotation /= sum.count;
  }
  return sum;
}

}  // namespace binnacle::score
