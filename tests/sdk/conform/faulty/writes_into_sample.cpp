// SPDX-License-Identifier: Apache-2.0
// Takes the offset out of the sample where it lies.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Transform {
 public:
  using Transform::Transform;
  void on(int input, const binnacle::SampleView& sample, std::byte* memory, binnacle::Emitter& emitter) const override {
    const_cast<double*>(sample.fields)[0] -= 0.25;
    Transform::on(input, sample, memory, emitter);
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_into_sample", "1.0.0", registry) { registry.add<Subject>(); }
