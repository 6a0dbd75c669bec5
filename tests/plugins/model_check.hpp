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

#include "binnacle/derived_block.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"
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

inline PortStates moved(PortStates ports, std::size_t port, int component, double by) {
  VectorXd delta = VectorXd::Zero(ports[port].dof());
  delta[component] = by;
  ports[port].block->plus(ports[port].x.data(), delta.data(), ports[port].x.data());
  return ports;
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
    first.examine(out);
    if (first.result && !first.equals_without_errors(*this, ports, step, memory))
      out.add("without Phi and Q it moves elsewhere");
    if (!first.equals(again)) out.add("the same call gave another result: the model has a state of its own");
    return first.propagation(*this, ports);
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
    const ProcessDeclaration& declared = model_.declaration();
    if (!declared.has_continuous_form) out.add("no continuous form is declared");
    std::vector<detail::Guarded> F, Q;
    std::vector<double*> F_at, Q_at;
    make_blocks(declared.transition, ports, F, F_at);
    make_blocks(declared.noise, ports, Q, Q_at);
    const auto x = detail::pointers(ports);
    ContinuousOutput made{F_at.data(), Q_at.data()};
    model_.linearized({x.data()}, made);
    examine_blocks("dynamics", F, out);
    examine_blocks("noise density", Q, out);
    return {assemble(dense(declared.transition, F, ports, false, false), ports),
            assemble(dense(declared.noise, Q, ports, true, false), ports)};
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

  /// One call of propagate() on guarded memory.
  struct Call {
    std::vector<detail::Guarded> x_plus, transition, noise;
    std::vector<std::byte> memory;
    Result result;

    Call(const ProcessCheck& check, const PortStates& ports, const Step& step, std::vector<std::byte> before)
        : memory(std::move(before)) {
      const ProcessDeclaration& declared = check.model_.declaration();
      std::vector<double*> x_at, transition_at, noise_at;
      for (std::size_t i = 0; i < ports.size(); ++i)
        x_plus.emplace_back(check.advances(i) ? static_cast<int>(ports[i].x.size()) : 0);
      for (std::size_t i = 0; i < ports.size(); ++i) x_at.push_back(check.advances(i) ? x_plus[i].data() : nullptr);
      check.make_blocks(declared.transition, ports, transition, transition_at);
      check.make_blocks(declared.noise, ports, noise, noise_at);
      const auto x = detail::pointers(ports);
      ProcessOutput made{x_at.data(), transition_at.data(), noise_at.data()};
      result = check.model_.propagate(ProcessInput{step, x.data(), {}, memory.data(), {}}, made);
    }
    void examine(Complaints& out) const {
      examine_blocks("x_plus", x_plus, out);
      examine_blocks("transition", transition, out);
      examine_blocks("noise", noise, out);
    }
    bool equals(const Call& other) const {
      const auto same = [](const auto& a, const auto& b) {
        return std::equal(a.begin(), a.end(), b.begin(),
                          [](const auto& p, const auto& q) { return p.take() == q.take(); });
      };
      return memory == other.memory && same(x_plus, other.x_plus) && same(transition, other.transition) &&
             same(noise, other.noise);
    }
    /// The same values and memory, to the bit, where neither Φ nor Q is wanted.
    bool equals_without_errors(const ProcessCheck& check, const PortStates& ports, const Step& step,
                               std::vector<std::byte> before) const {
      std::vector<detail::Guarded> values;
      std::vector<double*> x_at;
      for (std::size_t i = 0; i < ports.size(); ++i)
        values.emplace_back(check.advances(i) ? static_cast<int>(ports[i].x.size()) : 0);
      for (std::size_t i = 0; i < ports.size(); ++i) x_at.push_back(check.advances(i) ? values[i].data() : nullptr);
      const auto x = detail::pointers(ports);
      ProcessOutput out{x_at.data(), {}, {}};
      return check.model_.propagate(ProcessInput{step, x.data(), {}, before.data(), {}}, out) && before == memory &&
             std::equal(values.begin(), values.end(), x_plus.begin(),
                        [](const auto& a, const auto& b) { return a.take() == b.take(); });
    }
    Propagation propagation(const ProcessCheck& check, const PortStates& ports) const {
      Propagation p;
      for (const auto& values : x_plus) p.x_plus.push_back(values.take());
      p.transition = check.dense(check.model_.declaration().transition, transition, ports, false, true);
      p.noise = check.dense(check.model_.declaration().noise, noise, ports, true, false);
      p.memory = memory;
      return p;
    }
  };

  static void examine_blocks(const char* what, const std::vector<detail::Guarded>& blocks, Complaints& out) {
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (!blocks[i].is_intact()) out.add(what, " ", i, ": written beyond its end");
      if (!blocks[i].is_written()) out.add(what, " ", i, ": not written completely");
    }
  }

  bool advances(std::size_t port) const { return spec_.ports[port].access == PortAccess::advances; }
  bool is_declared(std::pair<int, int> key) const {
    const auto& all = model_.declaration().transition;
    return std::any_of(all.begin(), all.end(), [&](const Coupling& c) { return key == std::pair(c.to, c.from); });
  }

  void make_blocks(const std::vector<Coupling>& couplings, const PortStates& ports,
                   std::vector<detail::Guarded>& blocks, std::vector<double*>& at) const {
    for (const Coupling& c : couplings) {
      const int rows = ports[static_cast<std::size_t>(c.to)].dof();
      const int cols = ports[static_cast<std::size_t>(c.from)].dof();
      blocks.emplace_back(c.structure == Structure::diagonal ? rows : rows * cols);
    }
    for (auto& block : blocks) at.push_back(block.data());
  }

  /// All blocks between an advanced port and a bound one (noise: an advanced one), the undeclared filled in.
  Propagation::Blocks dense(const std::vector<Coupling>& couplings, const std::vector<detail::Guarded>& values,
                            const PortStates& ports, bool is_noise, bool identity) const {
    Propagation::Blocks blocks;
    for (std::size_t to = 0; to < ports.size(); ++to)
      for (std::size_t from = 0; from < ports.size(); ++from)
        if (advances(to) && ports[from].block && (!is_noise || advances(from))) {
          Eigen::MatrixXd& block = blocks[{static_cast<int>(to), static_cast<int>(from)}];
          block.setZero(ports[to].dof(), ports[from].dof());
          if (identity && to == from) block.setIdentity();
        }
    for (std::size_t i = 0; i < couplings.size(); ++i) {
      const Coupling& c = couplings[i];
      Eigen::MatrixXd& block = blocks.at({c.to, c.from});
      const std::vector<double> numbers = values[i].take();
      if (c.structure == Structure::diagonal) {
        block.setZero();
        block.diagonal() = vector_at(numbers.data(), static_cast<int>(block.rows()));
      } else {
        block = matrix_at(numbers.data(), static_cast<int>(block.rows()), static_cast<int>(block.cols()));
      }
      if (is_noise && c.to != c.from) blocks.at({c.from, c.to}) = block.transpose();
    }
    return blocks;
  }

  static int offset(const PortStates& ports, std::size_t port) {
    int sum = 0;
    for (std::size_t i = 0; i < port; ++i) sum += ports[i].dof();
    return sum;
  }
  static Eigen::MatrixXd assemble(const Propagation::Blocks& blocks, const PortStates& ports) {
    const int n = offset(ports, ports.size());
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n, n);
    for (const auto& [key, block] : blocks)
      all.block(offset(ports, static_cast<std::size_t>(key.first)), offset(ports, static_cast<std::size_t>(key.second)),
                block.rows(), block.cols()) = block;
    return all;
  }

  Eigen::MatrixXd accumulated(PortStates ports, const std::vector<Step>& parts, std::vector<std::byte> memory,
                              Complaints& out) const {
    const int n = offset(ports, ports.size());
    Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(n, n);
    for (const Step& part : parts) {
      const Propagation p = propagate(ports, part, memory, out);
      Eigen::MatrixXd Phi = assemble(p.transition, ports);
      for (std::size_t i = 0; i < ports.size(); ++i) {
        if (advances(i)) {
          ports[i].x = p.x_plus[i];
        } else if (ports[i].block) {
          Phi.block(offset(ports, i), offset(ports, i), ports[i].dof(), ports[i].dof()).setIdentity();
        }
      }
      Q = Phi * Q * Phi.transpose() + assemble(p.noise, ports);
      memory = p.memory;
    }
    return Q;
  }

  /// The least eigenvalue of Q scaled to ones on the diagonal.
  static double scaled_eigenvalue(const Eigen::MatrixXd& Q) {
    const Eigen::VectorXd root = Q.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = root.asDiagonal() * Q * root.asDiagonal();
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
  }

  void compare_noise(const PortStates& ports, std::size_t to, std::size_t from, const Eigen::MatrixXd& Q,
                     const Eigen::MatrixXd& fine, double relative, double neglected, Complaints& out) const {
    const auto part = [&](const Eigen::MatrixXd& m) {
      return m.block(offset(ports, to), offset(ports, from), ports[to].dof(), ports[from].dof()).eval();
    };
    const Eigen::MatrixXd expected = part(fine), given = part(Q);
    const double correlated = std::sqrt(fine.diagonal().segment(offset(ports, to), ports[to].dof()).maxCoeff() *
                                        fine.diagonal().segment(offset(ports, from), ports[from].dof()).maxCoeff());
    const double allowed = relative * expected.cwiseAbs().maxCoeff() + std::max(neglected, 1e-12) * correlated;
    for (Eigen::Index j = 0; j < given.cols(); ++j)
      for (Eigen::Index i = 0; i < given.rows(); ++i)
        if (!(std::abs(given(i, j) - expected(i, j)) <= allowed))
          out.add("noise ", spec_.ports[to].name, ", ", spec_.ports[from].name, " (", i, ",", j, "): given ",
                  given(i, j), ", integrated ", expected(i, j), ", allowed ", allowed);
  }

  const ProcessModel& model_;
  ComponentSpec spec_;
};

/// Φ and Q of ẋ = F x + w over dt (Van Loan 1978), as the kernel makes them of continuous forms: over a part of dt that
/// is short against F, because e^{−F dt} overflows for a fast decay, and then doubled.
inline std::pair<Eigen::MatrixXd, Eigen::MatrixXd> van_loan(const Eigen::MatrixXd& F, const Eigen::MatrixXd& GQG,
                                                            double dt) {
  const Eigen::Index n = F.rows();
  const int doublings = std::max(0, static_cast<int>(std::ceil(std::log2(F.norm() * dt + 1e-300))));
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  A.topLeftCorner(n, n) = -F;
  A.topRightCorner(n, n) = GQG;
  A.bottomRightCorner(n, n) = F.transpose();
  const Eigen::MatrixXd E = (A * std::ldexp(dt, -doublings)).exp();
  Eigen::MatrixXd Phi = E.bottomRightCorner(n, n).transpose();
  Eigen::MatrixXd Q = Phi * E.topRightCorner(n, n);
  for (int i = 0; i < doublings; ++i) {
    Q = (Phi * Q * Phi.transpose() + Q).eval();
    Phi = (Phi * Phi).eval();
  }
  return {Phi, Q};
}

/// A measurement model on memory as the kernel hands it out.
struct Measured {
  Result result;
  Eigen::VectorXd residual;
  std::vector<Eigen::MatrixXd> H;  // per entry of `reads`
  Eigen::MatrixXd R;
  std::vector<std::int64_t> keys;  // of the rows
};

/// `with_H` false: only values are wanted.
inline Measured linearize_once(const MeasurementModel& model, const SampleView& sample, const PortStates& ports,
                               const Driving& u, Complaints& out, const SampleView* auxiliary, bool with_H) {
  const MeasurementDeclaration& declared = model.declaration();
  const int rows = declared.max_rows;
  std::vector<detail::Guarded> H;
  std::vector<MatrixView> views(ports.size());
  for (const int port : declared.read_ports) H.emplace_back(rows * ports[static_cast<std::size_t>(port)].dof(), 0.0);
  for (std::size_t i = 0; i < H.size(); ++i) {
    const auto port = static_cast<std::size_t>(declared.read_ports[i]);
    views[port] = {H[i].data(), rows, ports[port].dof(), rows};
  }
  detail::Guarded residual(rows), R(rows * rows, 0.0);
  std::vector<std::int64_t> keys(static_cast<std::size_t>(rows));
  std::vector<std::byte> memory(declared.memory_bytes);
  model.start(memory.data());
  const auto x = detail::pointers(ports);
  MeasurementOutput at{0,
                       {residual.data(), rows},
                       with_H ? PortJacobians(views.data()) : PortJacobians(),
                       {R.data(), rows, rows, rows},
                       keys};
  Measured m;
  m.result = model.linearize({sample, auxiliary, x.data(), u, memory.data(), {}, {}}, at);
  if (!m.result) return m;
  if (at.rows < 0 || at.rows > rows) out.add("rows: ", at.rows, " of at most ", rows);
  m.residual = vector_at(residual.data(), at.rows);
  for (std::size_t i = 0; i < H.size(); ++i)
    m.H.push_back(views[static_cast<std::size_t>(declared.read_ports[i])].as().topRows(at.rows));
  m.R = at.R.as().topLeftCorner(at.rows, at.rows);
  m.keys.assign(keys.begin(), keys.begin() + at.rows);
  const auto intact = [](const detail::Guarded& block) { return block.is_intact(); };
  if (!residual.is_intact() || !R.is_intact() || !std::all_of(H.begin(), H.end(), intact))
    out.add("written beyond the end of a block");
  return m;
}

inline Measured linearize(const MeasurementModel& model, const SampleView& sample, const PortStates& ports,
                          const Driving& u, Complaints& out, const SampleView* auxiliary = nullptr) {
  const Measured m = linearize_once(model, sample, ports, u, out, auxiliary, true);
  const Measured values = linearize_once(model, sample, ports, u, out, auxiliary, false);
  const auto same = [](const auto& a, const auto& b) {
    return a.size() == b.size() &&
           std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
  };
  if (m.result.refusal != values.result.refusal || !same(m.residual, values.residual) || !same(m.R, values.R) ||
      m.keys != values.keys)
    out.add("without H it gives another residual, R or keys");
  if (m.result && m.residual.size() < 1) out.add("no rows");
  return m;
}

/// H, that of ports which are not read included, against −∂r/∂δ; R symmetric and positive.
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
  const int dof = yields.declaration().dof();
  if (declared.kind != yields.declaration().kind) out.add("yields ", declared.kind);
  if (declared.dof() != dof || declared.stored_size != yields.declaration().stored_size) out.add("wrong size yielded");
  const auto value = [&](const PortStates& at, const MatrixView* J) {
    detail::Guarded y(declared.stored_size);
    const auto x = detail::pointers(at);
    DerivedOutput made{{y.data(), declared.stored_size}, J ? PortJacobians(J) : PortJacobians()};
    const Result result = model.evaluate({x.data(), context}, made);
    if (!result) out.add("refused: ", result.reason);
    if (!y.is_intact() || !y.is_written()) out.add("the value is not written as declared");
    return y.take();
  };
  std::vector<detail::Guarded> J;
  std::vector<MatrixView> views(ports.size());
  for (const int port : declared.read_ports) J.emplace_back(dof * ports[static_cast<std::size_t>(port)].dof(), 0.0);
  for (std::size_t i = 0; i < J.size(); ++i) {
    const auto port = static_cast<std::size_t>(declared.read_ports[i]);
    views[port] = {J[i].data(), dof, ports[port].dof(), dof};
  }
  const std::vector<double> nominal = value(ports, views.data());
  if (nominal != value(ports, nullptr)) out.add("without Jacobians the value is another");
  for (std::size_t port = 0; port < ports.size(); ++port) {
    if (!ports[port].block) continue;
    const auto change = [&](const PortStates& at) {
      Eigen::VectorXd delta(dof);
      yields.minus(value(at, nullptr).data(), nominal.data(), delta.data());
      return delta;
    };
    const auto found = std::find(declared.read_ports.begin(), declared.read_ports.end(), static_cast<int>(port));
    const bool is_read = found != declared.read_ports.end();
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(dof, ports[port].dof());
    if (is_read) block = views[port].as();
    detail::compare("J of " + spec.ports[port].name, detail::differences(ports, port, change), block, is_read, false,
                    detail::roundoff(resolution, ports[port].step), 0, tolerance, out);
  }
  for (const auto& block : J)
    if (!block.is_intact()) out.add("written beyond the end of J");
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
