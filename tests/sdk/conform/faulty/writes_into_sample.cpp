// SPDX-License-Identifier: Apache-2.0
// Takes the offset out of the sample where it lies.
// fails: life.calls
#include "faulty.hpp"

namespace faulty::writes_into_sample {

class Subject final : public Transform {
 public:
  using Transform::Transform;
  void on(const TransformInput& in, Emitter& emitter) const override {
    const_cast<double*>(in.sample.fields)[0] -= 0.25;
    Transform::on(in, emitter);
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("writes_into_sample")); }

}  // namespace faulty::writes_into_sample
