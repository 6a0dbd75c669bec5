// SPDX-License-Identifier: Apache-2.0
// Single-point solutions: position, velocity and clock of each epoch by itself, by iterated least squares.
#pragma once

#include <vector>

#include "binnacle/source.hpp"
#include "gnss/corrections.hpp"
#include "satellite_limit.hpp"

namespace binnacle::gnss_range {

struct SinglePointState;
struct SinglePointFix;

class SinglePoint final : public Transform {
 public:
  static ComponentSpec spec();
  explicit SinglePoint(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override;
  void start(std::uint64_t seed, std::byte* memory) const override;
  void on(int input, const SampleView& sample, std::byte* memory, Emitter& emitter) const override;

 private:
  using Sightings = std::array<gnss::Sighting, gnss::most_rows>;

  bool solve(const gnss::Corrections::Epoch& epoch, SinglePointFix& fix) const;
  int sight(const gnss::Corrections::Epoch& epoch, bool knows_place, const SinglePointFix& fix,
            Sightings& sightings) const;
  bool step(const Sightings& sightings, int count, bool knows_place, SinglePointFix& fix, double& moved) const;
  enum class Verdict { agree, excluded, disagree };
  Verdict exclude_worst(const Sightings& sightings, int count, SinglePointFix& fix) const;
  void solve_velocity(const Sightings& sightings, int count, SinglePointFix& fix) const;
  void emit(Time t, const SinglePointFix& fix, Emitter& emitter) const;

  gnss::Corrections corrections_;
  SatelliteLimit limit_;
  gnss::ElevationNoise range_noise_, rate_noise_;
  double exclude_beyond_, max_gdop_, unknown_speed_, unknown_drift_;
  std::vector<ChannelDeclaration> channels_;
};

}  // namespace binnacle::gnss_range
