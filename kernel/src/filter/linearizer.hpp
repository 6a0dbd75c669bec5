// SPDX-License-Identifier: Apache-2.0
// From a sample to r, H and nominal R: the parts of a measurement, one after the other.
#pragma once

#include <vector>

#include "binnacle/model_input.hpp"
#include "filter/covariance_form.hpp"
#include "filter/fields.hpp"
#include "filter/model_calls.hpp"
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
  /// C P Cᵀ of all ports that a part reads, until the next call; with a row of C for each error component of each port: of
  /// a state block a unit vector, or nothing where the component is frozen; of a derived value its Jacobian, which must be
  /// in the workspace.
  PortCovariance covariance_of(const PartPlan& part, const CovarianceForm& P);
  void add_covariance(const PartPlan::Read& a, const PartPlan::Target& by_a, const PartPlan::Read& b,
                      const PartPlan::Target& by_b, MatrixView P, MatrixView into);

  const FilterPlan& plan_;
  const std::vector<ChannelPlan>& channels_;
  AuxiliaryReader& auxiliary_;
  Workspace& workspace_;
  ModelCalls& calls_;
  std::vector<double> fields_, row_fields_;  // of the sample, as a part reads it
  std::vector<double> read_covariance_;
  std::vector<int> first_row_;    // by port, of read_covariance_
  bool has_finite_noise_ = true;  // of the sample at work, so far
};

}  // namespace binnacle::filter
