// SPDX-License-Identifier: Apache-2.0
// numbers.measurement: H against differences, and R.
#include "measurement_consistency.hpp"

namespace binnacle::conform {

namespace {

/// check(subject, ports, sample, elsewhere) of states and samples drawn anew, until it complains; `elsewhere` are other
/// states near by, at which the residual is not zero. A model that refuses a sample, or takes no row of it, is not tried.
template <class Check>
void on_samples(Trial& trial, int repeats, std::uint64_t stream, Check&& check) {
  const MeasurementSubject subject(trial);
  for (int repeat = 0; repeat < trial.repeats(repeats); ++repeat) {
    auto random = trial.random(stream + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.measurement.ports(random, 0.1);
    const SampleNumbers sample = subject.measurement.sample(ports, random);
    const auto nominal = subject.measurement.call(ports, sample, subject.memory);
    if (!nominal.result)
      Trial::skip(std::string("it refuses a sample that it should accept: ") + nominal.result.reason);
    if (nominal.residual.size() == 0) Trial::skip("it accepts no row of a sample that it should accept");
    if (!trial.expect_none(check(subject, ports, sample, subject.measurement.ports(random, 0.1)))) return;
  }
}

void measurement_jacobian(Trial& trial) {
  on_samples(trial, 3, 600, [](const MeasurementSubject& subject, const auto& ports, const auto& sample, const auto&) {
    return testing::check_measurement(subject.measurement.caller, subject.measurement.given(sample), ports,
                                      subject.memory, {1e-3, 1e-6, testing::step_sweep});
  });
}

void measured_value(Trial& trial) {
  on_samples(trial, 5, 500,
             [](const MeasurementSubject& subject, const auto& ports, const auto& sample, const auto& elsewhere) {
               const auto given = subject.measurement.given(sample);
               testing::Complaints out =
                   testing::check_values(subject.measurement.caller, given, ports, subject.memory);
               out.add_all(testing::check_values(subject.measurement.caller, given, elsewhere, subject.memory));
               return out;
             });
}

void measurement_noise(Trial& trial) {
  const MeasurementSubject subject(trial);
  int seen = 0;
  std::string refusal = "it takes no row";
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(700 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.measurement.ports(random, 0.1);
    const auto m = subject.measurement.call(ports, subject.measurement.sample(ports, random), subject.memory);
    if (!m.result) refusal = m.result.reason;
    if (!m.result || m.residual.size() == 0) continue;
    ++seen;
    if (!trial.expect_none(testing::check_covariance(m.R))) return;
  }
  if (seen == 0) Trial::skip("it refuses a sample that it should accept: " + refusal);
}

}  // namespace

std::vector<Check> measurement_checks() {
  const std::vector<Role> roles = {Role::measurement_model};
  return {
      check("numbers.measurement.value", 2, roles, {"life.repeatable"},
            "residual and R are the same to the bit with and without H", measured_value),
      check("numbers.measurement.jacobian", 2, roles, {"life.repeatable"},
            "H is the derivative of h(x) on the manifold, and what is not read has none", measurement_jacobian),
      check("numbers.measurement.noise", 2, roles, {"life.repeatable"}, "R is symmetric and positive semidefinite",
            measurement_noise),
      check("numbers.measurement.consistency", 5, roles, {"numbers.measurement.jacobian", "numbers.measurement.noise"},
            "NIS of a filter on a world that is the model stays in its band", measurement_consistency),
  };
}

}  // namespace binnacle::conform
