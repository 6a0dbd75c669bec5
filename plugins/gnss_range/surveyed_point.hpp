// SPDX-License-Identifier: Apache-2.0
// A place that is known: the reference of a receiver that stands still.
#pragma once

#include <Eigen/Core>

#include "binnacle/source.hpp"
#include "solution_fields.hpp"

namespace binnacle::gnss_range {

/// Says the same place whenever its input emits.
class SurveyedPoint final : public Transform {
 public:
  static ComponentSpec spec();
  explicit SurveyedPoint(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  Eigen::Vector3d ecef_, lla_;
  OutputChannel channel_;
  PlaceFields ecef_fields_, geodetic_fields_;
};

}  // namespace binnacle::gnss_range
