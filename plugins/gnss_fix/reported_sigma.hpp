// SPDX-License-Identifier: Apache-2.0
// Standard deviations of a fix: the receiver's own, scaled and floored, or fixed ones.
#pragma once

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/result.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/view.hpp"

namespace binnacle::gnss_fix {

/// Per axis, north east down: max(scale · reported, floor) where the channel reports a deviation, else `sigma`.
class ReportedSigma {
 public:
  static std::vector<ParameterSpec> parameters(const std::string& unit);
  /// The optional fields PREFIX_n, PREFIX_e, PREFIX_d.
  static std::vector<FieldSpec> fields(const std::string& prefix, const std::string& unit);

  /// `flaws`: why a sample is invalid whose deviation of that axis is none.
  ReportedSigma(const Binding& binding, const std::string& prefix, const std::array<const char*, 3>& flaws);

  /// Writes R's diagonal; `invalid` if the receiver reports what is no standard deviation.
  Result write_variances(const SampleView& sample, const MatrixView& R) const;

 private:
  struct Axis {
    Field reported;
    double sigma;  // used when the channel reports none
    double floor;
    const char* flaw;
  };
  std::vector<Axis> axes_;
  double scale_;
};

}  // namespace binnacle::gnss_fix
