// SPDX-License-Identifier: Apache-2.0
// Holds a model against its declaration: Jacobians against differences on the manifold, Qd against fine integration.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <unsupported/Eigen/MatrixFunctions>

#include "binnacle/measurement_model.hpp"
#include "binnacle/testing.hpp"
#include "binnacle/view.hpp"

namespace binnacle::test {

/// What a check found wrong; each line names the block and the element.
class Complaints {
 public:
  template <class... Parts>
  void add(const Parts&... parts) {
    std::ostringstream line;
    line.precision(10);
    (line << ... << parts);
    lines_.push_back(line.str());
  }
  bool empty() const { return lines_.empty(); }
  std::size_t size() const { return lines_.size(); }
  std::string text() const {
    std::string all;
    for (const auto& line : lines_) all += line + "\n";
    return all;
  }

 private:
  std::vector<std::string> lines_;
};

/// A block as it stands on a port while its Jacobians are taken.
struct PortState {
  const StateBlock* block = nullptr;  // null: the port is open
  std::vector<double> x;              // stored value
  double step = 1e-3;                 // size of the differences in every error component
  double resolution = 1e-15;          // of ⊟ there: roundoff that a difference cannot see through

  int dof() const { return block ? block->declaration().dof() : 0; }
};
using PortStates = std::vector<PortState>;  // in the order of the spec

/// How near a difference must come to the declared block B (D = B − I where it is the block of a port on itself):
/// |numeric − B| ≤ relative · max|D| + roundoff. An undeclared block may be no larger than roundoff, or, scaled by the
/// steps of its ports, than `neglected`.
struct Tolerance {
  double relative = 1e-6;
  double neglected = 0;
};

namespace detail {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double canary = 8.251e77;

/// Memory as the kernel hands it out: filled, and followed by a canary that nobody may touch.
class Guarded {
 public:
  explicit Guarded(int size, double fill = nan) : values_(static_cast<std::size_t>(size) + 1, fill) {
    values_.back() = canary;
  }
  double* data() { return values_.data(); }
  bool is_intact() const { return values_.back() == canary; }
  bool is_written() const {
    return std::none_of(values_.begin(), values_.end() - 1, [](double v) { return std::isnan(v); });
  }
  std::vector<double> take() const { return {values_.begin(), values_.end() - 1}; }

 private:
  std::vector<double> values_;
};

inline std::vector<const double*> pointers(const PortStates& ports) {
  std::vector<const double*> x;
  for (const PortState& port : ports) x.push_back(port.block ? port.x.data() : nullptr);
  return x;
}

/// Whether two calls wrote the same, to the bit where it is a number.
inline bool is_same(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] != b[i] && !(std::isnan(a[i]) && std::isnan(b[i]))) return false;
  return true;
}

/// ∂f/∂δ of a port by central differences at `step` and half of it, so that the error is of the fourth power.
/// f(ports) → VectorXd, already as ⊟ against a fixed point.
template <class Function>
MatrixXd differences(const PortStates& ports, std::size_t port, const Function& f) {
  const double h = ports[port].step;
  MatrixXd J;
  for (int j = 0; j < ports[port].dof(); ++j) {
    const auto central = [&](double step) -> VectorXd {
      return (f(moved(ports, port, j, step)) - f(moved(ports, port, j, -step))) / (2 * step);
    };
    const VectorXd column = (4.0 * central(h / 2) - central(h)) / 3.0;
    if (J.size() == 0) J.resize(column.size(), ports[port].dof());
    J.col(j) = column;
  }
  return J;
}

inline void compare(const std::string& name, const MatrixXd& numeric, const MatrixXd& declared, bool is_declared,
                    bool is_own, double roundoff, double neglected, const Tolerance& tolerance, Complaints& out) {
  MatrixXd change = declared;
  if (is_own) change -= MatrixXd::Identity(declared.rows(), declared.cols());
  const double largest = change.size() ? change.cwiseAbs().maxCoeff() : 0;
  const double allowed = is_declared ? tolerance.relative * largest + roundoff : std::max(neglected, roundoff);
  for (Eigen::Index j = 0; j < numeric.cols(); ++j)
    for (Eigen::Index i = 0; i < numeric.rows(); ++i)
      if (!(std::abs(numeric(i, j) - declared(i, j)) <= allowed))
        out.add(name, "(", i, ",", j, "): ", is_declared ? "declared " : "undeclared, so ", declared(i, j),
                ", by differences ", numeric(i, j), ", allowed ", allowed);
}

/// Differences are divided by the step, and those at half of it are weighted by 4/3.
inline double roundoff(double resolution, double step) { return 8 * resolution / step; }

}  // namespace detail

/// What a process model did: dense blocks by (to, from), those it did not declare included.
struct Propagation {
  using Blocks = std::map<std::pair<int, int>, Eigen::MatrixXd>;
  std::vector<std::vector<double>> x_plus;  // by port; empty for ports that are only read
  Blocks transition;                        // rows: advanced ports, columns: all bound ports
  Blocks noise;                             // both triangles, advanced ports
  std::vector<std::byte> memory;
};

class ProcessCheck {
 public:
  ProcessCheck(const ProcessModel& model, ComponentSpec spec) : model_(model), spec_(std::move(spec)) {}

  /// Memory as it is at the start of a run.
  std::vector<std::byte> fresh_memory() const {
    std::vector<std::byte> memory(model_.declaration().memory_bytes);
    model_.start(memory.data());
    return memory;
  }

  Propagation propagate(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory,
                        Complaints& out) const {
    Call first(*this, ports, step, memory);
    Call again(*this, ports, step, memory);
    if (!first.result) out.add("refused: ", first.result.reason);
    if (!first.damage.empty()) out.add(first.damage);
    out.add_all(check_values(caller_, ports, step, memory));
    if (first.memory != again.memory || !detail::is_same(first.numbers, again.numbers))
      out.add("the same call gave another result: the model has a state of its own");
    Propagation p{first.x_plus, {}, {}, first.memory};
    const Eigen::MatrixXd Phi = caller_.Phi(ports, first), Q = caller_.Q(ports, first);
    for (std::size_t to = 0; to < ports.size(); ++to)
      for (std::size_t from = 0; from < ports.size(); ++from) {
        if (!caller_.moves(ports, to) || ports[from].is_open()) continue;
        const std::pair key(static_cast<int>(to), static_cast<int>(from));
        p.transition[key] = block(Phi, ports, to, from);
        if (caller_.moves(ports, from)) p.noise[key] = block(Q, ports, to, from);
      }
    return p;
  }

  /// Every block of Φ, declared or not, against differences of x⁺.
  Complaints transition(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory,
                        const Tolerance& tolerance) const {
    Complaints out;
    const Propagation nominal = propagate(ports, step, memory, out);
    for (std::size_t to = 0; to < ports.size(); ++to) {
      if (!advances(to)) continue;
      for (std::size_t from = 0; from < ports.size(); ++from) {
        if (!ports[from].block) continue;
        const auto key = std::pair(static_cast<int>(to), static_cast<int>(from));
        detail::compare("transition " + spec_.ports[to].name + " by " + spec_.ports[from].name,
                        numeric(ports, step, memory, nominal, to, from), nominal.transition.at(key), is_declared(key),
                        to == from, detail::roundoff(ports[to].resolution, ports[from].step),
                        tolerance.neglected * ports[to].step / ports[from].step, tolerance, out);
      }
    }
    return out;
  }

  /// The greatest difference between Φ and the differences of x⁺, scaled by the steps of the ports; shows its order.
  double transition_error(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory) const {
    Complaints out;
    const Propagation nominal = propagate(ports, step, memory, out);
    double largest = 0;
    for (const auto& [key, block] : nominal.transition) {
      const auto to = static_cast<std::size_t>(key.first), from = static_cast<std::size_t>(key.second);
      const Eigen::MatrixXd difference = numeric(ports, step, memory, nominal, to, from) - block;
      largest = std::max(largest, difference.cwiseAbs().maxCoeff() * ports[from].step / ports[to].step);
    }
    return largest;
  }

  /// Q of one step against Σ Φ Q Φᵀ over the short steps that fill it. Relative to the largest element of each block.
  Complaints noise(const PortStates& ports, const Step& whole, const std::vector<Step>& parts,
                   const std::vector<std::byte>& memory, double relative, double neglected = 0) const {
    Complaints out;
    const Propagation coarse = propagate(ports, whole, memory, out);
    const Eigen::MatrixXd fine = accumulated(ports, parts, memory, out);
    const Eigen::MatrixXd Q = assemble(coarse.noise, ports);
    if (!(Q - Q.transpose()).isZero(1e-14 * Q.cwiseAbs().maxCoeff())) out.add("Q is not symmetric");
    if (const double least = scaled_eigenvalue(Q); least < -1e-10) out.add("Q has the eigenvalue ", least);
    for (std::size_t to = 0; to < ports.size(); ++to)
      for (std::size_t from = to; from < ports.size(); ++from)
        if (advances(to) && advances(from)) compare_noise(ports, to, from, Q, fine, relative, neglected, out);
    return out;
  }

  /// dt = 0: x⁺ = x, Φ = I, Q = 0, to the bit.
  Complaints zero_step(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory) const {
    Complaints out;
    const Propagation still = propagate(ports, step, memory, out);
    for (std::size_t i = 0; i < ports.size(); ++i)
      if (advances(i) && still.x_plus[i] != ports[i].x) out.add("dt = 0 moves ", spec_.ports[i].name);
    for (const auto& [key, block] : still.transition) {
      Eigen::MatrixXd rest = Eigen::MatrixXd::Zero(block.rows(), block.cols());
      if (key.first == key.second) rest.setIdentity();
      if (block != rest) out.add("dt = 0: transition ", key.first, " by ", key.second, " is not that of rest");
    }
    for (const auto& [key, block] : still.noise)
      if (!block.isZero(0)) out.add("dt = 0: noise ", key.first, ", ", key.second, " is not zero");
    return out;
  }

  /// F and GQGᵀ of a model's continuous form, assembled over the bound ports (rows of read ports are zero).
  std::pair<Eigen::MatrixXd, Eigen::MatrixXd> continuous(const PortStates& ports, Complaints& out) const {
    if (!caller_.declared().has_continuous_form) out.add("no continuous form is declared");
    const auto form = caller_.linearized(ports);
    if (!form.damage.empty()) out.add(form.damage);
    return {caller_.F(ports, form), caller_.Q(ports, form)};
  }

 private:
  Eigen::MatrixXd numeric(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory,
                          const Propagation& nominal, std::size_t to, std::size_t from) const {
    const auto change = [&](const PortStates& at) -> Eigen::VectorXd {
      const Call call(*this, at, step, memory);
      Eigen::VectorXd delta(ports[to].dof());
      ports[to].block->minus(call.x_plus[to].take().data(), nominal.x_plus[to].data(), delta.data());
      return delta;
    };
    return detail::differences(ports, from, change);
  }

  std::shared_ptr<const ComponentSpec> spec_;
  testing::ProcessCaller caller_;
};

inline testing::Given given(const ComponentSpec& spec, const SampleView& sample, const Driving& context,
                            const SampleView* auxiliary) {
  return {sample, auxiliary ? std::span(auxiliary, spec.inputs.size()) : std::span<const SampleView>(), context};
}

/// One call at the start of a run. auxiliary: as many as the model reads.
template <class... Auxiliary>
Measured linearize(const MeasurementModel& model, const SampleView& sample, const PortStates& ports,
                   const Driving& context, Complaints& out, const Auxiliary&... auxiliary) {
  const testing::MeasurementCaller caller(model);
  testing::Given all{sample, {}, context};
  ((all.auxiliary = std::span<const SampleView>(auxiliary)), ...);
  Measured m = caller.linearize(all, ports, caller.fresh_memory());
  if (!m.damage.empty()) out.add(m.damage);
  out.add_all(check_values(caller, all, ports, caller.fresh_memory()));
  return m;
}

/// H against differences; R symmetric and positive.
inline Complaints check_measurement(const MeasurementModel& model, const ComponentSpec& spec, const SampleView& sample,
                                    const PortStates& ports, const Driving& context, const Tolerance& tolerance,
                                    double resolution = 1e-12, const SampleView* auxiliary = nullptr) {
  Complaints out;
  const Measured nominal = linearize(model, sample, ports, context, out, auxiliary);
  if (!nominal.result) {
    out.add("refused: ", nominal.result.reason);
    return out;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> R(nominal.R, Eigen::EigenvaluesOnly);
  if (nominal.R != nominal.R.transpose() || !(R.eigenvalues().minCoeff() > 0)) out.add("R is no covariance");
  const auto& reads = model.declaration().read_ports;
  for (std::size_t port = 0; port < ports.size(); ++port) {
    if (!ports[port].block) continue;
    const auto predicted = [&](const PortStates& at) -> Eigen::VectorXd {
      return -linearize(model, sample, at, context, out, auxiliary).residual;
    };
    const auto found = std::find(reads.begin(), reads.end(), static_cast<int>(port));
    const bool is_read = found != reads.end();
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(nominal.residual.size(), ports[port].dof());
    if (is_read) H = nominal.H[static_cast<std::size_t>(found - reads.begin())];
    detail::compare("H of " + spec.ports[port].name, detail::differences(ports, port, predicted), H, is_read, false,
                    detail::roundoff(resolution, ports[port].step), 0, tolerance, out);
  }
  return out;
}

/// A derived block's value and Jacobians against differences; the value without Jacobians is the same to the bit.
/// `yields`: a state block of the kind yielded. resolution: of its ⊟.
inline Complaints check_derived(const DerivedBlock& model, const ComponentSpec& spec, const StateBlock& yields,
                                const PortStates& ports, const Driving& context, const Tolerance& tolerance,
                                double resolution) {
  Complaints out;
  const DerivedDeclaration& declared = model.declaration();
  const StateBlockDeclaration& wanted = yields.declaration();
  const testing::DerivedCaller caller(model, spec);
  const Driving u = context;
  Complaints out =
      testing::check_derived(caller, yields, Eigen::VectorXd::Zero(wanted.dof()), ports, u, tolerance, resolution);
  out.add_all(testing::check_derived_value(caller, ports, u));
  if (declared.kind != wanted.kind) out.add("yields ", declared.kind);
  if (declared.dof() != wanted.dof() || declared.stored_size != wanted.stored_size) out.add("wrong size yielded");
  return out;
}

/// The laws of a state block at x for errors of several sizes; `largest`: a δ near the edge of the chart.
/// resolution: of ⊟ in the error components; relative: what a chart may lose on a large δ.
inline Complaints check_block(const StateBlock& block, const std::vector<double>& x, double largest, double resolution,
                              double relative = 1e-12) {
  Complaints out;
  const StateBlockDeclaration& declared = block.declaration();
  const auto dof = static_cast<std::size_t>(declared.dof());
  const auto plus = [&](const std::vector<double>& at, const Eigen::VectorXd& delta) {
    detail::Guarded y(declared.stored_size);
    block.plus(at.data(), delta.data(), y.data());
    if (!y.is_intact() || !y.is_written()) out.add("plus writes what it should not, or not all");
    return y.take();
  };
  const auto minus = [&](const std::vector<double>& y, const std::vector<double>& from) {
    detail::Guarded delta(static_cast<int>(dof));
    block.minus(y.data(), from.data(), delta.data());
    if (!delta.is_intact() || !delta.is_written()) out.add("minus writes what it should not, or not all");
    return Eigen::VectorXd(vector_at(delta.data(), static_cast<int>(dof)));
  };
  const auto near = [&](const char* law, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    if (!((a - b).cwiseAbs().maxCoeff() <= resolution + relative * b.norm()))
      out.add(law, ": ", a.transpose(), " instead of ", b.transpose());
  };
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(declared.dof());
  near("x [-] x = 0", minus(x, x), zero);
  near("(x [+] 0) [-] x = 0", minus(plus(x, zero), x), zero);
  for (const double size : {1e-8, 1e-3, 0.3, 1.0}) {
    for (std::size_t direction = 0; direction < 2 * dof; ++direction) {
      // Axes, and directions between them: cosines of incommensurable angles, so no run differs from another.
      Eigen::VectorXd delta = zero;
      for (std::size_t i = 0; i < dof; ++i)
        delta[static_cast<Eigen::Index>(i)] =
            direction < dof ? (i == direction)
                            : std::cos(1.7 * static_cast<double>(direction) + 2.3 * static_cast<double>(i));
      delta *= size * largest / delta.norm();
      const std::vector<double> y = plus(x, delta);
      near("(x [+] d) [-] x = d", minus(y, x), delta);
      near("x [+] (y [-] x) = y", minus(plus(x, minus(y, x)), y), zero);
      std::vector<double> in_place = x;
      block.plus(in_place.data(), delta.data(), in_place.data());
      if (in_place != y) out.add("in place, plus gives another result");
      detail::Guarded outputs(static_cast<int>(declared.outputs.size()));
      block.read(y.data(), outputs.data());
      if (!outputs.is_intact() || !outputs.is_written()) out.add("read writes what it should not, or not all");
      std::vector<double> written(y.size());
      if (const Result result = block.write(outputs.data(), written.data()); !result)
        out.add("write refuses what was read: ", result.reason);
      near("write(read(x)) = x", minus(written, y), zero);
    }
  }
  return out;
}

/// reset_jacobian: δ_new = G (δ_old − δ), by differences of what remains after δ has been injected.
inline Complaints check_reset(const StateBlock& block, const std::vector<double>& x, const Eigen::VectorXd& delta,
                              const Tolerance& tolerance) {
  Complaints out;
  const int dof = block.declaration().dof();
  detail::Guarded G(dof * dof);
  Eigen::MatrixXd expected = Eigen::MatrixXd::Identity(dof, dof);
  if (block.reset_jacobian(delta.data(), G.data())) expected = matrix_at(G.data(), dof, dof);
  const auto remaining = [&](const Eigen::VectorXd& error) {
    std::vector<double> truth(x.size()), injected(x.size());
    block.plus(x.data(), error.data(), truth.data());
    block.plus(x.data(), delta.data(), injected.data());
    Eigen::VectorXd left(dof);
    block.minus(truth.data(), injected.data(), left.data());
    return left;
  };
  const double h = 1e-4;
  for (int j = 0; j < dof; ++j) {
    const Eigen::VectorXd e = h * Eigen::VectorXd::Unit(dof, j);
    const Eigen::VectorXd column = (remaining(delta + e) - remaining(delta - e)) / (2 * h);
    if (!((column - expected.col(j)).cwiseAbs().maxCoeff() <= tolerance.relative))
      out.add("G column ", j, ": ", expected.col(j).transpose(), ", by differences ", column.transpose());
  }
  return out;
}

}  // namespace binnacle::test

/// Fails with every complaint in the message.
#define REQUIRE_NO_COMPLAINTS(check)                          \
  do {                                                        \
    const ::binnacle::test::Complaints complaints_ = (check); \
    INFO(complaints_.text());                                 \
    REQUIRE(complaints_.empty());                             \
  } while (false)
