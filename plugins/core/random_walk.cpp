// SPDX-License-Identifier: Apache-2.0
// A vector driven by white noise.
#include "random_walk.hpp"

#include <algorithm>

namespace binnacle::core {

ComponentSpec RandomWalk::spec() {
  ComponentSpec spec;
  spec.type = "random_walk";
  spec.summary = "A vector whose rate is white noise.";
  spec.source = "Gelb (ed.), Applied Optimal Estimation, 1974, section 3.8";
  spec.parameters = {parameter::vector("q", "@x/sqrt(s)")
                         .sized_by("x")
                         .at_least(0)
                         .required()
                         .about("root of the power spectral density of the rate; sigma after the time t is q sqrt(t)")};
  spec.ports = {advances("x", "vector:*:*").about("the random walk")};
  spec.example = R"json({"blocks": {"x": "gyro_bias"}, "q": "2 deg/h/sqrt(h)"})json";
  spec.surroundings =
      R"json({"blocks": {"gyro_bias": {"type": "vector", "size": 3, "unit": "rad/s", "sigma": 1e-5}}})json";
  return spec;
}

RandomWalk::RandomWalk(const Binding& binding)
    : x_(binding.port("x")), q_(declaration_.adds_noise(x_, x_, Structure::diagonal)) {
  const auto q = binding.parameters().vector("q");
  for (const double root : q) density_.push_back(root * root);
  declaration_.has_both_forms().time_invariant();
}

Result RandomWalk::propagate(const ProcessInput& in, ProcessOutput& out) const {
  out.x[x_].as() = in.x[x_].as();
  if (const BlockView Q = out.Qd[q_])
    for (std::size_t i = 0; i < density_.size(); ++i) Q.data()[i] = density_[i] * in.step.dt;
  return Result::ok();
}

void RandomWalk::linearized(const ContinuousInput& /*in*/, ContinuousOutput& out) const {
  std::copy(density_.begin(), density_.end(), out.GQGt[q_].data());
}

}  // namespace binnacle::core
