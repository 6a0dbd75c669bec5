// SPDX-License-Identifier: Apache-2.0
// The sink numpy/keep: samples of a channel in memory, for run(keep=…).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "convert.hpp"

namespace binnacle::python {

/// Samples of one channel, as a run left them.
struct KeptSamples {
  std::vector<FieldSpec> fields, row_fields;
  std::vector<std::string> covariance_of;
  std::vector<Time> t, t0;                              // no_time: an instant
  std::vector<std::int64_t> rows;                       // by sample
  std::vector<double> values, row_values, covariances;  // one after another; a covariance of NaN: it had none
};

/// Writes into the KeptSamples whose number the config says.
class KeepSink final : public Sink {
 public:
  static ComponentSpec spec();
  explicit KeepSink(const Binding& binding);

  void open() override;
  void on(Input from, const SampleView& sample) override;

 private:
  KeptSamples shape_;
  std::shared_ptr<KeptSamples> into_;
};

void bind_kept(py::module_& module);

}  // namespace binnacle::python
