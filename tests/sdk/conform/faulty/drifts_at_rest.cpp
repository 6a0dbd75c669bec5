// SPDX-License-Identifier: Apache-2.0
// Says that it is at rest, and moves.
// fails: numbers.process.time_invariant
#include "faulty.hpp"

namespace faulty::drifts_at_rest {

class Subject final : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "process";
    spec.summary = "a known drift";
    spec.ports = {advances("x", "vector:2:m", "what drifts")};
    spec.example = R"({"blocks": {"x": "position"}})";
    return spec;
  }
  explicit Subject(const Binding& binding) : x_(binding.port("x")) { declaration_.at_rest(); }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    out.x[x_].as() = in.x[x_].as().array() + 0.1 * in.step.dt;
    return Result::ok();
  }

 private:
  Port x_;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("drifts_at_rest")); }

}  // namespace faulty::drifts_at_rest
