// SPDX-License-Identifier: Apache-2.0
// What pseudorange and range_rate have in common: the satellites of an epoch, as seen from the antenna.
#pragma once

#include <array>

#include "antenna.hpp"
#include "binnacle/legacy.hpp"
#include "gnss/corrections.hpp"
#include "satellite_limit.hpp"

namespace binnacle::gnss_range {

class RangeModel : public legacy::MeasurementModel {
 public:
  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }

 protected:
  using Sightings = std::array<gnss::Sighting, gnss::most_rows>;

  explicit RangeModel(const Binding& binding)
      : corrections_(binding),
        limit_(binding.parameters()),
        antenna_(binding),
        clock_port_(binding.port_index("clock")) {
    declaration_.max_rows = limit_.most();
  }

  static constexpr int ephemeris_input = 0;
  static constexpr int klobuchar_input = 1;

  /// Satellites to be used; both models choose the same ones of an epoch.
  Result sight(const SampleView& sample, const SampleView* auxiliary, const double* const* x, gnss::AntennaPlace& place,
               Sightings& sightings, int& count) const {
    if (!auxiliary[ephemeris_input].available) return Result::unsupported("no broadcast ephemeris has come yet");
    if (corrections_.wants_klobuchar() && !auxiliary[klobuchar_input].available)
      return Result::unsupported("no ionosphere coefficients have come yet, or no channel is on input 'iono'");
    if (const Result result = antenna_.read(x, place); !result) return result;
    const gnss::Corrections::Tally tally =
        corrections_.sight({sample.t, &sample, &auxiliary[ephemeris_input], &auxiliary[klobuchar_input]}, place, true,
                           sightings);
    count = gnss::Corrections::keep_highest(sightings, tally.used, limit_.at(sample.t));
    if (count >= limit_.fewest()) return Result::ok();
    if (count > 0) return Result::unsupported("fewer satellites than 'min_satellites'");
    if (tally.used > 0) return Result::unsupported("a cut leaves no satellite");
    if (tally.without_ephemeris > 0) return Result::unsupported("no satellite in view has an ephemeris");
    return Result::unsupported("no satellite is above the masks");
  }

  MeasurementDeclaration declaration_;
  gnss::Corrections corrections_;
  SatelliteLimit limit_;
  AntennaPosition antenna_;
  int clock_port_;
};

/// The parameters, inputs and ports that both have.
inline void describe_range_model(ComponentSpec& spec) {
  for (auto& parameter : gnss::Corrections::parameters()) spec.parameters.push_back(std::move(parameter));
  for (auto& parameter : SatelliteLimit::parameters()) spec.parameters.push_back(std::move(parameter));
  spec.inputs = {gnss::ephemeris_port(), gnss::klobuchar_port()};
}

}  // namespace binnacle::gnss_range
