// SPDX-License-Identifier: Apache-2.0
// The latest samples of a model's auxiliary channels, as it declared their fields.
#pragma once

#include <vector>

#include "binnacle/sample.hpp"
#include "filter/plan.hpp"

namespace binnacle::filter {

class AuxiliaryReader {
 public:
  AuxiliaryReader(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, const std::byte* arena);

  /// One per declared input, good until the next call; null for a model without any.
  const SampleView* read(const AuxiliaryPlan& model) { return model.channels.empty() ? nullptr : read_all(model); }

 private:
  const SampleView* read_all(const AuxiliaryPlan& model);

  const FilterPlan& plan_;
  const std::vector<ChannelPlan>& channels_;
  const std::byte* arena_;
  std::vector<SampleView> samples_;
  std::vector<double> fields_;
};

}  // namespace binnacle::filter
