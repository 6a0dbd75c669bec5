// SPDX-License-Identifier: Apache-2.0
// How far a sample is trusted, and whether it is used at all: noise estimator, NIS, gate by sample, row or key.
#pragma once

#include <vector>

#include "binnacle/noise_estimator.hpp"
#include "filter/covariance_form.hpp"
#include "filter/exclusion.hpp"
#include "filter/model_calls.hpp"
#include "filter/workspace.hpp"

namespace binnacle::filter {

/// `accepted`, `withheld`, `gated`, or `rejected` where S is not positive definite.
struct Judgement {
  Outcome outcome = Outcome::accepted;
  const char* reason = "";
};

class Judge {
 public:
  Judge(const FilterPlan& plan, std::byte* arena, ModelCalls& calls);

  /// Takes linearized rows to R, S, its factor and the NIS. dt: since the last accepted sample [s]. A withheld sample meets
  /// no noise estimator. Throws Stop where the estimator gives what cannot be noise.
  Judgement run(const MeasurementPlan& measurement, Time t, double dt, bool is_withheld, const CovarianceForm& P,
                SampleRows& rows);

 private:
  void weigh(const MeasurementPlan& measurement, Time t, double dt, SampleRows& rows);
  bool leave_out_worst(const MeasurementPlan& measurement, int offered, SampleRows& rows, bool& is_majority);

  const FilterPlan& plan_;
  std::byte* arena_;
  ModelCalls& calls_;
  OutlierTest outlier_test_;
  std::vector<std::byte> noise_backup_;
};

}  // namespace binnacle::filter
