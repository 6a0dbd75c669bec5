// SPDX-License-Identifier: Apache-2.0
// Segments of a filter's track: which positions and attitudes they are of.
#include <algorithm>
#include <cstdio>

#include "binnacle/state_block.hpp"
#include "filter_score.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

std::vector<FilterScore::Track> FilterScore::tracks() const {
  Track common;
  common.attitude = -1;
  const auto is_of_block = [](const Reference& reference) {
    return reference.is_whole && reference.plan->implied_state < 0;
  };
  for (std::size_t r = 0; r < references_.size(); ++r) {
    const Reference& reference = references_[r];
    if (!is_of_block(reference) || reference.block->declaration->kind != "attitude") continue;
    const bool is_wanted = plan_.segments.attitude.empty() || plan_.segments.attitude == reference.name;
    if (!is_wanted || index_of(common.attitudes, reference.name) >= 0) continue;
    if (common.attitudes.empty()) common.attitude = static_cast<int>(r);
    common.attitudes.push_back(reference.name);
  }
  std::vector<Track> all;
  if (common.attitude < 0) return all;
  for (std::size_t r = 0; r < references_.size(); ++r) {
    const auto& errors = references_[r].block->declaration->error;
    if (!is_of_block(references_[r]) || errors.size() != 3) continue;
    if (!std::ranges::all_of(errors, [](const auto& component) { return component.unit == "m"; })) continue;
    Track track = common;
    track.name = references_[r].name + "." + segments_name;
    track.position = static_cast<int>(r);
    if (std::ranges::find(all, track.name, &Track::name) == all.end()) all.push_back(std::move(track));
  }
  return all;
}

void FilterScore::watch_track(int subject) {
  if (std::ranges::find(tracks_, subject, &WatchedTrack::subject) != tracks_.end()) return;
  const Track track = tracks()[as_size(subject)];
  for (const int index : {track.position, track.attitude}) references_[as_size(index)].is_watched = true;
  tracks_.push_back(
      {subject, track.position, track.attitude, SegmentTrack(*references_[as_size(track.position)].block)});
}

/// delta_ is the error of the reference that was just scored.
void FilterScore::take_poses(const Pending& pending, const double* truth) {
  for (auto& watched : tracks_) {
    if (watched.position == pending.reference) watched.track.take_position(pending.t, truth, delta_.data());
    if (watched.attitude == pending.reference) watched.track.take_attitude(pending.t, delta_.data());
  }
}

const SegmentTrack& FilterScore::track_of(const Metric& metric) const {
  return std::ranges::find(tracks_, metric.subject, &WatchedTrack::subject)->track;
}

void FilterScore::warn_of_no_segments(const Metric& metric, Diagnostics& warnings) const {
  const SegmentErrors errors = track_of(metric).errors(plan_.segments, plan_.span, start());
  if (errors.count > 0) return;
  char shortest[40];
  std::snprintf(shortest, sizeof shortest, "%g m", *std::ranges::min_element(plan_.segments.lengths));
  const std::string why = errors.poses == 0
                              ? "no reference gives position and attitude at the same time between 'after' and 'until'"
                              : "the " + std::to_string(errors.poses) + " poses of the path are not " + shortest +
                                    " long, the shortest of 'lengths'";
  warnings.warning("B125", {}, "/evaluate/metrics", "metric " + in_quotes(metric.name) + " has no segment: " + why);
}

}  // namespace binnacle::score
