// SPDX-License-Identifier: Apache-2.0
// numbers.block: the laws of a manifold.
#include <cmath>

#include "fixture.hpp"

namespace binnacle::conform {

namespace {

struct Subject {
  explicit Subject(Trial& trial)
      : composition(compose_example(trial)), value(parts::block(*composition, filter_name, component_name)) {}
  PortState at(Trial& trial, std::uint64_t stream, double spread) const {
    auto random = trial.random(stream);
    return port_states({value}, random, spread).front();
  }
  std::vector<double> plus(const std::vector<double>& x, const Eigen::VectorXd& delta) const {
    std::vector<double> y(x.size());
    value.block->plus(x.data(), delta.data(), y.data());
    return y;
  }
  Eigen::VectorXd minus(const std::vector<double>& y, const std::vector<double>& x) const {
    Eigen::VectorXd delta(value.block->declaration().dof());
    value.block->minus(y.data(), x.data(), delta.data());
    return delta;
  }
  std::shared_ptr<const Composition> composition;
  parts::Value value;
};

/// Whether `found` is `wanted`, in units of what is plausible for each component.
bool near(Trial& trial, const char* law, const Eigen::VectorXd& found, const Eigen::VectorXd& wanted,
          const Eigen::VectorXd& scale) {
  const Eigen::VectorXd allowed = 1e-9 * scale + 1e-8 * wanted.cwiseAbs();
  return trial.expect(((found - wanted).cwiseAbs().array() <= allowed.array()).all(), law, " does not hold: found [",
                      found.transpose(), "], wanted [", wanted.transpose(), "]");
}

void laws(Trial& trial) {
  const Subject subject(trial);
  for (int repeat = 0; repeat < trial.repeats(5); ++repeat) {
    const PortState at = subject.at(trial, 100 + static_cast<std::uint64_t>(repeat), repeat == 0 ? 0.0 : 1.0);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(at.dof());
    auto random = trial.random(200 + static_cast<std::uint64_t>(repeat));
    if (!near(trial, "(x [+] 0) [-] x = 0", subject.minus(subject.plus(at.x, zero), at.x), zero, at.scale)) return;
    for (const double size : {1e-8, 1e-4, 0.1, 1.0}) {
      const Eigen::VectorXd delta = size * at.scale.cwiseProduct(normals(random, at.dof()));
      const auto y = subject.plus(at.x, delta);
      if (!near(trial, "(x [+] d) [-] x = d", subject.minus(y, at.x), delta, at.scale)) return;
      if (!near(trial, "x [+] (y [-] x) = y", subject.minus(subject.plus(at.x, subject.minus(y, at.x)), y), zero,
                at.scale))
        return;
      std::vector<double> in_place = at.x;
      subject.value.block->plus(in_place.data(), delta.data(), in_place.data());
      if (!trial.expect(in_place == y, "plus() gives another result when x and result are the same memory")) return;
    }
    // Near the end of a rotation's chart: half a turn.
    const auto& errors = subject.value.block->declaration().error;
    const bool turns = at.dof() == 3 && static_cast<int>(at.x.size()) > at.dof() && errors.front().unit == "rad";
    if (!turns) continue;
    Eigen::VectorXd delta = normals(random, 3);
    delta *= (EIGEN_PI - 1e-3) / delta.norm();
    if (!near(trial, "(x [+] d) [-] x = d near half a turn", subject.minus(subject.plus(at.x, delta), at.x), delta,
              10 * at.scale))
      return;
  }
}

void readable(Trial& trial) {
  const Subject subject(trial);
  for (int repeat = 0; repeat < trial.repeats(10); ++repeat) {
    const PortState at = subject.at(trial, 300 + static_cast<std::uint64_t>(repeat), 1.0);
    std::vector<double> outputs(subject.value.block->declaration().outputs.size()), written(at.x.size());
    if (outputs.empty()) Trial::skip("it has no readable output");
    subject.value.block->read(at.x.data(), outputs.data());
    const Result result = subject.value.block->write(outputs.data(), written.data());
    if (!trial.expect(static_cast<bool>(result), "write() refuses what read() gave: ", result.reason)) return;
    if (!near(trial, "write(read(x)) = x", subject.minus(written, at.x), Eigen::VectorXd::Zero(at.dof()), at.scale))
      return;
  }
}

void reset(Trial& trial) {
  const Subject subject(trial);
  for (int repeat = 0; repeat < trial.repeats(5); ++repeat) {
    const PortState at = subject.at(trial, 400 + static_cast<std::uint64_t>(repeat), 0.5);
    auto random = trial.random(500 + static_cast<std::uint64_t>(repeat));
    const Eigen::VectorXd delta = 0.1 * at.scale.cwiseProduct(normals(random, at.dof()));
    Eigen::MatrixXd G = Eigen::MatrixXd::Identity(at.dof(), at.dof());
    std::vector<double> written(static_cast<std::size_t>(G.size()));
    if (subject.value.block->reset_jacobian(delta.data(), written.data()))
      G = Eigen::Map<const Eigen::MatrixXd>(written.data(), at.dof(), at.dof());
    const auto injected = subject.plus(at.x, delta);
    Eigen::MatrixXd numeric(at.dof(), at.dof());
    for (int j = 0; j < at.dof(); ++j) {
      const double h = 1e-3 * at.scale[j];
      const Eigen::VectorXd e = h * Eigen::VectorXd::Unit(at.dof(), j);
      numeric.col(j) = (subject.minus(subject.plus(at.x, delta + e), injected) -
                        subject.minus(subject.plus(at.x, delta - e), injected)) /
                       (2 * h);
    }
    const double turned = (numeric - Eigen::MatrixXd::Identity(at.dof(), at.dof())).cwiseAbs().maxCoeff();
    const double worst = (numeric - G).cwiseAbs().maxCoeff();
    if (!trial.expect(worst <= 0.2 * turned + 1e-5,
                      "reset_jacobian() differs from differences of what remains after injecting d = [",
                      delta.transpose(), "] by ", worst, "; G is\n", G, "\nand should be, to first order,\n", numeric))
      return;
  }
}

}  // namespace

std::vector<Check> block_checks() {
  const std::vector<Role> roles = {Role::state_block};
  return {
      {"numbers.block.laws",
       2,
       roles,
       {"life.repeatable"},
       "[+] and [-] are each other's inverse at the identity, for small and large errors, near half a turn",
       laws},
      {"numbers.block.readable", 2, roles, {"numbers.block.laws"}, "write(read(x)) = x", readable},
      {"numbers.block.reset", 3, roles, {"numbers.block.laws"}, "the reset Jacobian is that of [+] and [-]", reset},
  };
}

}  // namespace binnacle::conform
