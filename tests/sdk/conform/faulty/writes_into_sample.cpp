// SPDX-License-Identifier: Apache-2.0
// Takes the offset out of the sample where it lies.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Transform {
 public:
  using Transform::Transform;
  void on(const binnacle::TransformInput& in, binnacle::Emitter& emitter) const override {
    const_cast<double*>(in.sample.fields)[0] -= 0.25;
    Transform::on(in, emitter);
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_into_sample", "1.0.0", registry) { registry.add<Subject>(); }
