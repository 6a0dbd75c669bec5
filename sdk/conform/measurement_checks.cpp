// SPDX-License-Identifier: Apache-2.0
// numbers.measurement: H against differences, R, and the normalized innovations of a filter that believes them.
#include <cmath>

#include <Eigen/Eigenvalues>
#include <boost/math/distributions/chi_squared.hpp>

#include "binnacle/session.hpp"
#include "compare.hpp"

namespace binnacle::conform {

namespace {

struct Subject {
  explicit Subject(Trial& trial) : composition(compose_example(trial)), measurement(trial, *composition) {
    memory.resize(measurement.part.model->declaration().memory_bytes);
    measurement.part.model->start(memory.data());
  }
  Measured call(const PortStates& ports, const std::vector<double>& fields) const {
    auto own = memory;
    return measurement.call(ports, fields, own.data(), unwritten());
  }
  std::shared_ptr<const Composition> composition;
  MeasurementFixture measurement;
  std::vector<std::byte> memory;
};

void jacobian(Trial& trial) {
  const Subject subject(trial);
  const auto& reads = subject.measurement.part.model->declaration().read_ports;
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(600 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.measurement.ports(random, 0.1);
    const auto fields = subject.measurement.fields(ports, random);
    const Measured nominal = subject.call(ports, fields);
    if (!nominal.answer.result)
      Trial::skip(std::string("it refuses what it should see: ") + nominal.answer.result.reason);
    for (std::size_t port = 0; port < ports.size(); ++port) {
      if (ports[port].is_open()) continue;
      const auto found = std::find(reads.begin(), reads.end(), static_cast<int>(port));
      Eigen::MatrixXd H = Eigen::MatrixXd::Zero(nominal.residual.size(), ports[port].dof());
      if (found != reads.end()) H = nominal.H[static_cast<std::size_t>(found - reads.begin())];
      const auto predicted = [&](const PortStates& at) -> Eigen::VectorXd {
        const Measured m = subject.call(at, fields);
        return m.answer.result && m.residual.size() == nominal.residual.size()
                   ? Eigen::VectorXd(-m.residual)
                   : Eigen::VectorXd::Constant(nominal.residual.size(), NAN);
      };
      // A row is as large as what plausible errors make of it; each element counts by its own error's size.
      const Mismatch m = compare_over_steps(ports, port, H, predicted, [&](Eigen::Index i, Eigen::Index j) {
        const double row = H.row(i).cwiseAbs().dot(ports[port].scale.transpose());
        return (1e-3 * row + 1e-6 * std::sqrt(nominal.R(i, i))) / ports[port].scale[j];
      });
      if (!trial.expect(!m.is_there, "H of '", subject.measurement.part.type->spec.ports[port].name, "' (", m.row, ",",
                        m.column, "): ",
                        found == reads.end() ? "the port is not declared as read"
                                             : "declared " + std::to_string(m.declared),
                        ", differences of h(x) give ", m.numeric))
        return;
    }
  }
}

void covariance(Trial& trial) {
  const Subject subject(trial);
  int seen = 0;
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(700 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.measurement.ports(random, 0.1);
    const Measured m = subject.call(ports, subject.measurement.fields(ports, random));
    if (!m.answer.result) continue;
    ++seen;
    if (!trial.expect((m.R - m.R.transpose()).cwiseAbs().maxCoeff() <= 1e-14 * m.R.cwiseAbs().maxCoeff(),
                      "R is not symmetric:\n", m.R))
      return;
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m.R).eigenvalues().minCoeff();
    if (!trial.expect(least >= -1e-12 * m.R.cwiseAbs().maxCoeff(),
                      "R is not positive semidefinite: it has the eigenvalue ", least))
      return;
  }
  if (seen == 0) Trial::skip("it refuses what it should see");
}

double quantile(double dof, double p) { return boost::math::quantile(boost::math::chi_squared(dof), p); }

void consistency(Trial& trial) {
  const Subject subject(trial);
  const auto& spec = subject.measurement.part.type->spec;
  if (!spec.driving_rates.empty()) Trial::skip("it needs a driving input");
  if (!spec.inputs.empty()) Trial::skip("it needs auxiliary channels");
  for (const auto& field : spec.fields)
    if (field.is_per_row) Trial::skip("its samples have rows");
  const auto& info = subject.composition->filters().front();
  const std::string channel_name =
      subject.composition->config().at("filters").at(filter_name).at("measurements").at(component_name).at("channel");
  const int runs = trial.repeats(40);
  double sum = 0;
  std::int64_t dof = 0;
  for (int run = 0; run < runs; ++run) {
    auto random = trial.random(20'000 + static_cast<std::uint64_t>(run));
    Session filter(subject.composition);
    const auto channel = filter.channel(channel_name);
    PortStates believed = subject.measurement.ports(random, 0.0);
    std::vector<double> sample;
    // What the filter starts from is what the config says; the truth is drawn around it.
    PortStates truth = believed;
    std::vector<double> zeros;
    const auto push = [&](const std::vector<double>& fields, Time t) {
      // The channel carries what has_field tells, in the order of the spec.
      std::vector<double> carried;
      for (std::size_t i = 0; i < fields.size(); ++i)
        if (subject.measurement.has_field[i]) carried.push_back(fields[i]);
      filter.push(channel, no_time, t, carried);
    };
    // A first sample, exactly as predicted, starts the filter; P is then what it believes.
    push(subject.measurement.fields(believed, random), 1'000'000'000);
    if (!filter.started(FilterId{0})) Trial::skip("the miniature filter does not start");
    const auto before = filter.counts({{0}, 0});
    const MatrixView P = filter.covariance(FilterId{0});
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(Eigen::MatrixXd(P.as()));
    const Eigen::VectorXd error =
        solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).cwiseSqrt().cwiseProduct(normals(random, P.rows));
    for (auto& port : truth) {
      if (port.is_open()) continue;
      for (const auto& block : info.blocks)
        if (block.name == port.name) {
          const auto state = filter.state(FilterId{0});
          port.x.assign(state.begin() + block.stored_offset,
                        state.begin() + block.stored_offset + block.declaration->stored_size);
          const Eigen::VectorXd delta = error.segment(block.first_row, port.dof());
          port.block->plus(port.x.data(), delta.data(), port.x.data());
        }
    }
    for (int k = 0; k < 5; ++k) {
      const Measured at_truth = subject.call(truth, subject.measurement.fields(truth, random));
      if (!at_truth.answer.result) Trial::skip("it refuses what it should see");
      const Eigen::LLT<Eigen::MatrixXd> R(at_truth.R);
      const Eigen::VectorXd noise = R.matrixL() * normals(random, at_truth.residual.size());
      const auto fields = subject.measurement.fields(truth, random, noise);
      const Measured made = subject.call(truth, fields);
      if (made.residual.size() != noise.size() || (made.residual - noise).norm() > 1e-3 * noise.norm())
        Trial::skip("no sample is found that shows a wanted residual");
      push(fields, 1'100'000'000 + k * 100'000'000);
    }
    if (!trial.expect(filter.healthy(FilterId{0}), "the miniature filter breaks: ", filter.diagnosis(FilterId{0})))
      return;
    const auto counts = filter.counts({{0}, 0});
    const auto accepted = counts.by_outcome[0] - before.by_outcome[0];
    if (accepted < 5) {
      if (counts.by_outcome[static_cast<int>(Outcome::gated)] == 0)
        Trial::skip("the miniature filter does not accept its samples: " + counts.last_reason);
      continue;  // a sample in a thousand is gated by design, and its run left out
    }
    sum += counts.nis_mean * static_cast<double>(counts.by_outcome[0]) -
           (before.by_outcome[0] ? before.nis_mean * static_cast<double>(before.by_outcome[0]) : 0.0);
    dof += static_cast<std::int64_t>(std::llround(counts.dof_mean * static_cast<double>(accepted)));
  }
  if (dof == 0) Trial::skip("no run was without a gated sample");
  const double d = static_cast<double>(dof), low = quantile(d, 0.0001) / d, high = quantile(d, 0.9999) / d;
  trial.expect(sum / d > low && sum / d < high, "NIS is ", sum / d, " a degree of freedom over ", runs,
               " runs of a world that is the model itself; 99.98 % band ", low, " to ", high);
}

}  // namespace

std::vector<Check> measurement_checks() {
  const std::vector<Role> roles = {Role::measurement_model};
  return {
      {"numbers.measurement.jacobian",
       2,
       roles,
       {"life.repeatable"},
       "H is the derivative of h(x) on the manifold, and what is not read has none",
       jacobian},
      {"numbers.measurement.noise",
       2,
       roles,
       {"life.repeatable"},
       "R is symmetric and positive semidefinite",
       covariance},
      {"numbers.measurement.consistency",
       5,
       roles,
       {"numbers.measurement.jacobian", "numbers.measurement.noise"},
       "NIS of a filter on a world that is the model stays in its band",
       consistency},
  };
}

}  // namespace binnacle::conform
