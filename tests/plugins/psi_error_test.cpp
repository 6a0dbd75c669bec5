// SPDX-License-Identifier: Apache-2.0
// Plugin psi_error: Φ against the mechanization, step by step and over 100 s, its kinship with phi_error, and what the
// mechanization makes of a perfect sensor on a ship.
#include "../../plugins/phi_error/phi_error_process.hpp"
#include "../../plugins/psi_error/psi_error_process.hpp"
#include "../../plugins/psi_error/psi_model.hpp"

#include <cmath>
#include <functional>

#include "inertial_bench.hpp"
#include "ship_voyage.hpp"
#include "strapdown/earth.hpp"

namespace psi_error_test {

using namespace binnacle;
using namespace binnacle::psi_error;
using namespace binnacle::test;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

using Bench = InertialBench<PsiErrorProcess>;

const nlohmann::json in_computed_axes{{"axes", "computed"}};

/// T of psi_model.hpp: (p, v, φ) to (p, u, ψ).
MatrixXd in_psi(const PortStates& at) {
  const Translation t({vector_at<3>(at[0].x.data()), vector_at<3>(at[1].x.data()), vector_at<4>(at[2].x.data())});
  MatrixXd T = MatrixXd::Identity(9, 9);
  T.block<3, 3>(3, 0) = t.minus_vW;
  T.block<3, 3>(6, 0) = t.W;
  return T;
}

/// A model with one block of Φ multiplied: what a wrong sign in its equations makes of it.
class Mutated final : public ProcessModel {
 public:
  Mutated(const ProcessModel& model, int to, int from, double factor)
      : model_(model), to_(to), from_(from), factor_(factor) {}
  const ProcessDeclaration& declaration() const noexcept override { return model_.declaration(); }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const Result result = model_.propagate(in, out);
    const auto& couplings = declaration().transition;
    for (std::size_t i = 0; out.phi && i < couplings.size(); ++i) {
      if (couplings[i].to != to_ || couplings[i].from != from_) continue;
      auto block = out.phi[PhiBlock(static_cast<int>(i), 3, 3, Structure::dense)].as<3, 3>();
      if (to_ == from_) block -= Matrix3d::Identity();
      block *= factor_;
      if (to_ == from_) block += Matrix3d::Identity();
    }
    return result;
  }

 private:
  const ProcessModel& model_;
  int to_, from_;
  double factor_;
};

/// Φ of a long time by blocks, advanced ports by all that are bound.
struct Long {
  PortStates end;
  MatrixXd transition;
};

std::vector<double*> pointers_to(std::vector<std::vector<double>>& blocks) {
  std::vector<double*> all;
  for (auto& block : blocks) all.push_back(block.data());
  return all;
}

/// One after another, the memory going along; `transition` only when it is wanted.
Long travel(const Bench& bench, PortStates ports, const std::vector<Step>& steps, bool with_transition) {
  const ProcessDeclaration& declared = bench.model->declaration();
  std::vector<std::vector<double>> Phi(declared.transition.size(), std::vector<double>(9));
  std::vector<std::vector<double>> Q(declared.noise.size(), std::vector<double>(9));
  std::vector<std::vector<double>> x_plus{std::vector<double>(3), std::vector<double>(3), std::vector<double>(4)};
  const auto Phi_at = pointers_to(Phi), Q_at = pointers_to(Q);
  auto x_at = pointers_to(x_plus);
  x_at.resize(ports.size(), nullptr);
  auto memory = bench.check().fresh_memory();
  const int columns = bench.has_sensor_errors ? 21 : 9;
  MatrixXd all = MatrixXd::Identity(columns, columns), one(columns, columns);
  for (const Step& step : steps) {
    const auto x = test::detail::pointers(ports);
    ProcessOutput out{x_at.data(), Phi_at.data(), Q_at.data()};
    const SampleView no_statement;
    const Result result = bench.model->propagate({step, x.data(), &no_statement, memory.data(), {}}, out);
    if (!result) throw std::runtime_error(result.reason);
    for (std::size_t i = 0; i < 3; ++i) ports[i].x = x_plus[i];
    if (!with_transition) continue;
    one.setIdentity();
    for (std::size_t i = 0; i < declared.transition.size(); ++i)
      one.block<3, 3>(3 * declared.transition[i].to, 3 * declared.transition[i].from) = matrix_at<3, 3>(Phi[i].data());
    all = one * all;
  }
  return {ports, all};
}

/// The ports with one error component of one of them moved.
PortStates moved(PortStates ports, std::size_t port, int component, double by) {
  VectorXd delta = VectorXd::Zero(ports[port].dof());
  delta[component] = by;
  ports[port].block->plus(ports[port].x, delta, ports[port].x);
  return ports;
}

/// The same by central differences of where the mechanization ends.
MatrixXd travel_differences(const Bench& bench, const PortStates& ports, const std::vector<Step>& steps) {
  const Long nominal = travel(bench, ports, steps, false);
  MatrixXd J(9, bench.has_sensor_errors ? 21 : 9);
  for (std::size_t from = 0; 3 * static_cast<Eigen::Index>(from) < J.cols(); ++from) {
    const auto end = [&](const PortStates& start) -> VectorXd {
      const Long moved = travel(bench, start, steps, false);
      VectorXd delta(9);
      for (std::size_t to = 0; to < 3; ++to)
        nominal.end[to].block->minus(moved.end[to].x, nominal.end[to].x, {delta.data() + 3 * to, 3});
      return delta;
    };
    for (int component = 0; component < 3; ++component) {
      const double step = ports[from].scale[component];
      J.col(3 * static_cast<Eigen::Index>(from) + component) =
          (end(moved(ports, from, component, step)) - end(moved(ports, from, component, -step))) / (2 * step);
    }
  }
  return J;
}

/// The greatest relative difference of the 3×3 blocks of two matrices, each against its largest element.
double difference(const MatrixXd& a, const MatrixXd& b) {
  double worst = 0;
  for (int row = 0; row < 9; row += 3)
    for (int col = 0; col < b.cols(); col += 3) {
      const Matrix3d expected = b.block<3, 3>(row, col), given = a.block<3, 3>(row, col);
      const double relative = (given - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
      INFO("block " << row / 3 << ", " << col / 3 << ": " << relative);
      worst = std::max(worst, relative);
    }
  return worst;
}

PortStates ports_of(const Bench& bench, const Voyage& voyage) {
  const strapdown::Navigation start = voyage.at(0);
  PortStates ports{{&bench.position, numbers(start.lla), 30.0, 4e-9},
                   {&bench.velocity, numbers(start.v_n), 0.3, 1e-13},
                   {&bench.attitude, numbers(start.q_nb), 1e-3, 4e-16},
                   {},
                   {},
                   {},
                   {}};
  if (bench.has_sensor_errors) {
    const std::vector<double> none(3, 0.0);
    ports[3] = {&bench.gyro_bias, none, 1e-5, 1e-16};
    ports[4] = {&bench.accel_bias, none, 1e-3, 1e-16};
    ports[5] = {&bench.scale, none, 1e-3, 1e-16};
    ports[6] = {&bench.scale, none, 1e-3, 1e-16};
  }
  return ports;
}

}  // namespace

TEST_CASE("psi_error: every block of the transition against differences of the mechanization", "[psi_error]") {
  for (const auto& [dt, metres] : {std::pair(0.01, 100.0), std::pair(0.002, 100.0), std::pair(1e-4, 2e3)})
    for (const Flight& flight : flights)
      for (const bool with_sensor_errors : {true, false})
        for (const auto& [order, power] : {std::pair("first", 2), std::pair("second", 3)}) {
          INFO(flight.name << ", sensor errors " << with_sensor_errors << ", order " << order << ", dt " << dt);
          Samples samples(flight);
          const Bench bench(order, with_sensor_errors);
          PortStates ports = bench.ports(flight);
          ports[0].scale.setConstant(metres);
          const Tolerance tolerance{6 * dt, 20 * std::pow(dt, power)};
          REQUIRE_NO_COMPLAINTS(bench.check().transition(ports, samples.whole(0, dt).step(),
                                                         memory_before(bench, flight, dt), tolerance));
        }
}

TEST_CASE("psi_error: the stated order in dt, for one sample and for several", "[psi_error]") {
  for (const auto& [order, least] : {std::pair("first", 1.8), std::pair("second", 2.8)}) {
    const Bench bench(order);
    for (const Flight& flight : flights) {
      const auto error = [&](double dt, int count) {
        Samples samples(flight);
        for (int i = 0; i < count; ++i) samples.whole(i * dt / count, (i + 1) * dt / count);
        return bench.check().transition_error(bench.ports(flight), samples.step(), memory_before(bench, flight, dt));
      };
      for (const int count : {1, 3}) {
        INFO(flight.name << ", order " << order << ", samples " << count);
        REQUIRE(std::log2(error(0.08, count) / error(0.02, count)) / 2 > least);
      }
    }
  }
}

TEST_CASE("psi_error: a wrong sign of any block of the transition is seen", "[psi_error]") {
  const Bench bench;
  for (const Coupling& coupling : bench.model->declaration().transition)
    for (const Flight& flight : {flights[1], flights[3]}) {
      INFO(flight.name << ": " << coupling.to << " by " << coupling.from);
      const double dt = 1e-3;
      Samples samples(flight);
      PortStates ports = bench.ports(flight);
      ports[0].scale.setConstant(2e3);
      const Mutated mutated(*bench.model, coupling.to, coupling.from, -1);
      const ProcessCheck check(mutated, PsiErrorProcess::spec());
      const Step step = samples.whole(0, dt).step();
      const auto memory = memory_before(bench, flight, dt);
      REQUIRE_NO_COMPLAINTS(bench.check().transition(ports, step, memory, {6 * dt, 20 * dt * dt * dt}));
      REQUIRE_FALSE(check.transition(ports, step, memory, {6 * dt, 20 * dt * dt * dt}).empty());
    }
}

TEST_CASE("psi_error and phi_error are two derivations of one transition", "[psi_error]") {
  const Bench psi;
  const InertialBench<phi_error::PhiErrorProcess> phi;
  const double dt = 0.005;
  for (const Flight& flight : flights) {
    INFO(flight.name);
    Samples samples(flight);
    const Step step = samples.whole(0, dt).step();
    Complaints out;
    const Propagation a = psi.check().propagate(psi.ports(flight), step, psi.check().fresh_memory(), out);
    const Propagation b = phi.check().propagate(phi.ports(flight), step, phi.check().fresh_memory(), out);
    REQUIRE_NO_COMPLAINTS(out);
    REQUIRE(a.x_plus == b.x_plus);
    for (const auto& [key, block] : b.transition) {
      INFO(key.first << " by " << key.second);
      MatrixXd expected = block, given = a.transition.at(key);
      if (key.first == key.second) expected -= Matrix3d::Identity(), given -= Matrix3d::Identity();
      REQUIRE((given - expected).cwiseAbs().maxCoeff() <= 4 * dt * expected.cwiseAbs().maxCoeff());
    }
    for (const auto& [key, block] : b.noise) REQUIRE(a.noise.at(key) == block);
  }
}

TEST_CASE("psi_error: the transition over 100 s of a ship's motion, in both axes", "[psi_error]") {
  const Voyage voyage;
  const VoyageSamples samples(voyage, 100.0, 0.01, VoyageSamples::Increments::integrals);
  const Bench blocks("second", true);
  const PortStates start = ports_of(blocks, voyage);
  const Long linear = travel(blocks, start, samples.steps(), true);
  const MatrixXd expected = travel_differences(blocks, start, samples.steps());
  REQUIRE(difference(linear.transition, expected) < 1e-4);

  // In computed axes p, u, ψ: nothing is left out of the model, if the differences are taken in them.
  const Bench computed("second", false, {0, 0, 0}, {0, 0, 0}, in_computed_axes);
  const PortStates bare = ports_of(computed, voyage);
  const Long psi = travel(computed, bare, samples.steps(), true);
  const MatrixXd in_computed = in_psi(psi.end) * expected.leftCols<9>() * in_psi(bare).inverse();
  REQUIRE(psi.transition.block(6, 0, 3, 6).isZero(0));
  REQUIRE(in_computed.block(6, 0, 3, 3).cwiseAbs().maxCoeff() < 1e-12);  // rad/m, of 1.6e-7
  REQUIRE(in_computed.block(6, 3, 3, 3).cwiseAbs().maxCoeff() < 1e-10);  // rad/(m/s), of 1.6e-5
  MatrixXd rest = in_computed;
  rest.block(6, 0, 3, 6).setConstant(1.0);
  MatrixXd given = psi.transition;
  given.block(6, 0, 3, 6).setConstant(1.0);
  REQUIRE(difference(given, rest) < 1e-4);
}

TEST_CASE("psi_error: what is lost when the position is frozen", "[psi_error]") {
  // A velocity error of the paper's 0.257 m/s over 100 s.
  const Voyage voyage;
  const VoyageSamples samples(voyage, 100.0, 0.01, VoyageSamples::Increments::integrals);
  const auto frozen = [&](const nlohmann::json& axes) {
    const Bench bench("second", false, {0, 0, 0}, {0, 0, 0}, axes);
    const ProcessDeclaration& declared = bench.model->declaration();
    MatrixXd all = MatrixXd::Identity(6, 6);
    PortStates at = ports_of(bench, voyage);
    auto memory = bench.check().fresh_memory();
    for (std::size_t k = 0; k < samples.steps().size(); ++k) {
      Complaints out;
      const Propagation p = bench.check().propagate(at, samples.steps()[k], memory, out);
      MatrixXd one = MatrixXd::Identity(6, 6);
      for (const Coupling& c : declared.transition)
        if (c.to > 0 && c.from > 0) one.block<3, 3>(3 * c.to - 3, 3 * c.from - 3) = p.transition.at({c.to, c.from});
      all = one * all;
      for (std::size_t i = 0; i < 3; ++i) at[i].x = p.x_plus[i];
      memory = p.memory;
    }
    return all;
  };
  const MatrixXd true_axes = frozen(nlohmann::json::object()), computed_axes = frozen(in_computed_axes);
  const Vector3d error{0.257, 0.257, 0};
  const Vector3d apart = (true_axes - computed_axes).block<3, 3>(3, 0) * error;
  const double mil = M_PI / 3200;
  REQUIRE(apart.norm() < 0.008 * mil);  // W v t
  REQUIRE(apart.norm() > 0.004 * mil);
  const Matrix3d velocity = (true_axes - computed_axes).block<3, 3>(3, 3);
  REQUIRE(velocity.cwiseAbs().maxCoeff() < 0.01);  // Schuler: ½ g t²/R
}

TEST_CASE("psi_error: a perfect sensor on a ship keeps its azimuth", "[psi_error]") {
  const Voyage voyage;
  const double mil = M_PI / 3200;
  struct Case {
    VoyageSamples::Increments increments;
    bool with_neighbour;
    double most;  // mil
  };
  using Increments = VoyageSamples::Increments;
  for (const Case& c : {Case{Increments::rotation_vectors, false, 1e-9}, Case{Increments::integrals, false, 1e-5},
                        Case{Increments::integrals, true, 1e-8}}) {
    const VoyageSamples samples(voyage, 100.0, 0.01, c.increments);
    const Bench bench("second", false);
    PortStates at = ports_of(bench, voyage);
    auto memory = bench.check().fresh_memory();
    double worst = 0;
    for (const Step& step : samples.steps()) {
      if (!c.with_neighbour) memory = bench.check().fresh_memory();
      Complaints out;
      const Propagation p = bench.check().propagate(at, step, memory, out);
      for (std::size_t i = 0; i < 3; ++i) at[i].x = p.x_plus[i];
      memory = p.memory;
      Vector3d phi;
      const auto truth = numbers(voyage.at(seconds(step.t1)).q_nb);
      bench.attitude.minus(truth, at[2].x, phi);
      worst = std::max(worst, std::abs(phi[2]) / mil);
    }
    INFO("with " << (c.increments == Increments::integrals ? "integrals" : "rotation vectors") << ", neighbour "
                 << c.with_neighbour << ": " << worst << " mil");
    CHECK(worst < c.most);
  }
}

TEST_CASE("psi_error: dt = 0 changes nothing", "[psi_error]") {
  for (const auto& axes : {nlohmann::json::object(), in_computed_axes}) {
    const Bench bench("second", true, {0.03, 0.02, 0.01}, {0.1, 0.2, 0.3}, axes);
    Samples nothing(flights[0]);
    REQUIRE_NO_COMPLAINTS(bench.check().zero_step(bench.ports(flights[0]), nothing.whole(0, 0).step(),
                                                  memory_before(bench, flights[0], 0.01)));
  }
}

TEST_CASE("psi_error: without errors of the position the other blocks keep their bits", "[psi_error]") {
  check_frozen_position<PsiErrorProcess>();
  check_frozen_position<PsiErrorProcess>(in_computed_axes);
}

}  // namespace psi_error_test
