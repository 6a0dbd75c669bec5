// SPDX-License-Identifier: Apache-2.0
// From a sample to r, H and nominal R: the parts of a measurement, one after the other.
#pragma once

#include <vector>

#include "filter/auxiliary.hpp"
#include "filter/model_calls.hpp"
#include "filter/read_covariance.hpp"
#include "filter/sample_rows.hpp"
#include "filter/workspace.hpp"

namespace binnacle::filter {

class Linearizer {
 public:
  Linearizer(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, AuxiliaryReader& auxiliary,
             Workspace& workspace, ModelCalls& calls);

  /// Fills the rows of `measurement`, or refuses. Throws Stop where a model gives what cannot be noise. P: a priori.
  Result run(const MeasurementPlan& measurement, const SampleView& sample, const Moment& now, const CovarianceForm& P,
             SampleRows& rows);

 private:
  Result run_part(const PartPlan& part, const SampleView& sample, const ChannelPlan& channel, const Moment& now,
                  const CovarianceForm& P, SampleRows& rows, int& part_rows);
  void assemble(const PartPlan& part, int part_rows, SampleRows& rows);

  const FilterPlan& plan_;
  const std::vector<ChannelPlan>& channels_;
  AuxiliaryReader& auxiliary_;
  Workspace& workspace_;
  ModelCalls& calls_;
  ReadCovariance read_covariance_;
  std::vector<double> fields_, row_fields_;  // of the sample, as a part reads it
  bool has_finite_noise_ = true;             // of the sample at work, so far
};

}  // namespace binnacle::filter
