// SPDX-License-Identifier: Apache-2.0
// The laws of a manifold.
#include <cmath>

#include <Eigen/Core>

#include "guarded.hpp"

namespace binnacle::testing {

namespace {

class Laws {
 public:
  Laws(const PortState& at, const Exactness& exactness, Complaints& out) : at_(at), exactness_(exactness), out_(out) {}

  std::vector<double> plus(const std::vector<double>& x, const Eigen::VectorXd& delta) const {
    Inputs inputs;
    Guarded y(x.size(), unwritten());
    const ConstVectorView from = inputs.keep("x", ConstVectorView(x));
    const ConstVectorView by = inputs.keep("delta", ConstVectorView(delta));
    called("plus", [&] { return at_.block->plus(from, by, y), 0; });
    complain("plus", y, inputs);
    return y.values();
  }
  Eigen::VectorXd minus(const std::vector<double>& y, const std::vector<double>& x) const {
    Inputs inputs;
    Guarded delta(as_size(at_.dof()), unwritten());
    const ConstVectorView to = inputs.keep("y", ConstVectorView(y));
    const ConstVectorView from = inputs.keep("x", ConstVectorView(x));
    called("minus", [&] { return at_.block->minus(to, from, delta), 0; });
    complain("minus", delta, inputs);
    return vector_at(delta.data(), at_.dof());
  }
  void near(const char* law, const Eigen::VectorXd& found, const Eigen::VectorXd& wanted) const {
    const Eigen::VectorXd allowed = exactness_.absolute * at_.scale + exactness_.relative * wanted.cwiseAbs();
    if (!((found - wanted).cwiseAbs().array() <= allowed.array()).all())
      out_.add(law, " does not hold: found [", found.transpose(), "], wanted [", wanted.transpose(), "]");
  }

 private:
  void complain(const char* call, const Guarded& output, const Inputs& inputs) const {
    std::string damage = inputs.damage(call);
    examine(output, call, unwritten(), damage);
    if (!damage.empty()) out_.add(damage);
  }

  const PortState& at_;
  const Exactness& exactness_;
  Complaints& out_;
};

}  // namespace

Complaints check_laws(const PortState& at, const Eigen::VectorXd& delta, const Exactness& exactness) {
  Complaints out;
  const Laws block(at, exactness, out);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(at.dof());
  block.near("(x [+] 0) [-] x = 0", block.minus(block.plus(at.x, zero), at.x), zero);
  const auto y = block.plus(at.x, delta);
  block.near("(x [+] d) [-] x = d", block.minus(y, at.x), delta);
  block.near("x [+] (y [-] x) = y", block.minus(block.plus(at.x, block.minus(y, at.x)), y), zero);
  std::vector<double> in_place = at.x;
  at.block->plus(in_place, delta, in_place);
  if (in_place != y) out.add("plus() gives another result when x and result are the same memory");
  return out;
}

Complaints check_readable(const PortState& at, const Exactness& exactness) {
  Complaints out;
  const Laws block(at, exactness, out);
  std::vector<double> outputs(at.block->declaration().outputs.size()), written(at.x.size());
  called("read", [&] { return at.block->read(at.x, outputs), 0; });
  const Result result = called("write", [&] { return at.block->write(outputs, written); });
  if (!result)
    out.add("write() refuses what read() gave: ", result.reason);
  else
    block.near("write(read(x)) = x", block.minus(written, at.x), Eigen::VectorXd::Zero(at.dof()));
  return out;
}

Complaints check_reset(const PortState& at, const Eigen::VectorXd& delta, double share, double absolute) {
  Complaints out;
  const Exactness any{};
  const Laws block(at, any, out);
  Eigen::MatrixXd G = Eigen::MatrixXd::Identity(at.dof(), at.dof());
  std::vector<double> written(static_cast<std::size_t>(G.size()));
  const int dof = at.dof();
  if (called("reset_jacobian", [&] { return at.block->reset_jacobian(at.x, delta, {written.data(), dof, dof, dof}); }))
    G = matrix_at(written.data(), at.dof(), at.dof());
  const auto injected = block.plus(at.x, delta);
  Eigen::MatrixXd numeric(at.dof(), at.dof());
  for (int j = 0; j < at.dof(); ++j) {
    const double h = 1e-3 * at.scale[j];
    const Eigen::VectorXd e = h * Eigen::VectorXd::Unit(at.dof(), j);
    numeric.col(j) =
        (block.minus(block.plus(at.x, delta + e), injected) - block.minus(block.plus(at.x, delta - e), injected)) /
        (2 * h);
  }
  const double turned = (numeric - Eigen::MatrixXd::Identity(at.dof(), at.dof())).cwiseAbs().maxCoeff();
  const double worst = (numeric - G).cwiseAbs().maxCoeff();
  if (!(worst <= share * turned + absolute))
    out.add("reset_jacobian() differs from differences of what remains after injecting d = [", delta.transpose(),
            "] by ", worst, "; G is\n", G, "\nand should be, to first order,\n", numeric);
  return out;
}

Complaints check_output_jacobian(const PortState& at, double step, double share) {
  Complaints out;
  const auto& declared = at.block->declaration();
  const int outputs = static_cast<int>(declared.outputs.size()), dof = at.dof();
  Eigen::MatrixXd J(outputs, dof), numeric(outputs, dof);
  if (!called("output_jacobian", [&] { return at.block->output_jacobian(at.x, {J.data(), outputs, dof, outputs}); }))
    return out;
  const Exactness any{};
  const Laws block(at, any, out);
  Eigen::VectorXd above(outputs), below(outputs);
  for (int j = 0; j < dof; ++j) {
    const double h = step * at.scale[j];
    const Eigen::VectorXd e = h * Eigen::VectorXd::Unit(dof, j);
    called("read", [&] { return at.block->read(block.plus(at.x, e), above), 0; });
    called("read", [&] { return at.block->read(block.plus(at.x, -e), below), 0; });
    for (int i = 0; i < outputs; ++i) {
      double difference = above[i] - below[i];
      if (declared.outputs[static_cast<std::size_t>(i)].is_angle)
        difference = std::remainder(difference, 2 * std::numbers::pi);
      numeric(i, j) = difference / (2 * h);
    }
  }
  // An output that is read to the last digit only: its differences know no more than that.
  const Eigen::VectorXd resolution = 1e-15 / step * (1 + above.cwiseAbs().array());
  for (int i = 0; i < outputs; ++i) {
    const double worst = (numeric.row(i) - J.row(i)).cwiseProduct(at.scale.transpose()).cwiseAbs().maxCoeff();
    const double greatest = numeric.row(i).cwiseProduct(at.scale.transpose()).cwiseAbs().maxCoeff();
    if (!(worst <= share * greatest + resolution[i]))
      out.add("output_jacobian() of '", declared.outputs[static_cast<std::size_t>(i)].name,
              "' differs from differences of what is read: it is [", J.row(i), "], and should be [", numeric.row(i),
              "]");
  }
  return out;
}

}  // namespace binnacle::testing
