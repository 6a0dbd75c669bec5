// SPDX-License-Identifier: Apache-2.0
// Process models: Φ against differences, Qd against finer integration, rest.
#include <algorithm>
#include <cmath>

#include "algebra/decompositions.hpp"
#include "differences.hpp"
#include "guarded.hpp"

namespace binnacle::testing {

namespace {

Eigen::VectorXd scales(const PortStates& ports) {
  Eigen::VectorXd all(offset(ports, ports.size()));
  for (std::size_t i = 0; i < ports.size(); ++i)
    if (!ports[i].is_open()) all.segment(offset(ports, i), ports[i].dof()) = ports[i].scale;
  return all;
}

/// x⁺ of port `to` as an error about the nominal one.
Function change_of(const ProcessCaller& process, const Step& step, const std::vector<std::byte>& memory,
                   const Propagated& nominal, std::size_t to) {
  return [&process, &step, &memory, &nominal, to](const PortStates& at) -> Eigen::VectorXd {
    const Propagated p = process.propagate(at, step, memory);
    if (!p.result) return Eigen::VectorXd::Constant(at[to].dof(), NAN);
    Eigen::VectorXd delta(at[to].dof());
    at[to].block->minus(p.x_plus[to], nominal.x_plus[to], delta);
    return delta;
  };
}

auto block_of(const Eigen::MatrixXd& all, const PortStates& ports, std::size_t to, std::size_t from) {
  return all.block(offset(ports, to), offset(ports, from), ports[to].dof(), ports[from].dof());
}

/// Φ of the block, less the identity where it is that of a port on itself.
Eigen::MatrixXd change_in(const Eigen::MatrixXd& block, bool is_own) {
  return is_own ? (block - Eigen::MatrixXd::Identity(block.rows(), block.cols())).eval() : block;
}

}  // namespace

Complaints check_transition(const ProcessCaller& process, const PortStates& ports, const Step& step,
                            const std::vector<std::byte>& memory, const Tolerance& tolerance) {
  Complaints out;
  const Propagated nominal = process.propagate(ports, step, memory);
  if (!nominal.damage.empty()) out.add(nominal.damage);
  if (!nominal.result) return out.add("refused: ", nominal.result.reason), out;
  const Eigen::MatrixXd Phi = process.Phi(ports, nominal);
  for (std::size_t to = 0; to < ports.size(); ++to) {
    if (!process.moves(ports, to)) continue;
    const Function change = change_of(process, step, memory, nominal, to);
    for (std::size_t from = 0; from < ports.size(); ++from) {
      if (ports[from].is_open()) continue;
      const Eigen::MatrixXd block = block_of(Phi, ports, to, from);
      const double largest = change_in(block, to == from).cwiseAbs().maxCoeff();
      const std::string name =
          "Phi of '" + process.spec().ports[to].name + "' by '" + process.spec().ports[from].name + "'";
      compare({name, block, largest == 0 ? "nothing is declared" : "",
               [&](Eigen::Index i, Eigen::Index j) {
                 const double neglected = largest > 0 && !tolerance.neglects_declared ? 0 : tolerance.neglected;
                 return tolerance.relative * largest + neglected * ports[to].scale[i] / ports[from].scale[j];
               },
               ports[to].resolution},
              ports, from, change, tolerance.steps, out);
    }
  }
  return out;
}

double transition_error(const ProcessCaller& process, const PortStates& ports, const Step& step,
                        const std::vector<std::byte>& memory) {
  const Propagated nominal = process.propagate(ports, step, memory);
  if (!nominal.result) return INFINITY;
  const Eigen::MatrixXd Phi = process.Phi(ports, nominal);
  double largest = 0;
  for (std::size_t to = 0; to < ports.size(); ++to) {
    if (!process.moves(ports, to)) continue;
    const Function change = change_of(process, step, memory, nominal, to);
    for (std::size_t from = 0; from < ports.size(); ++from) {
      if (ports[from].is_open()) continue;
      const Eigen::MatrixXd difference = differences(ports, from, 1.0, change) - block_of(Phi, ports, to, from);
      for (Eigen::Index j = 0; j < difference.cols(); ++j)
        for (Eigen::Index i = 0; i < difference.rows(); ++i)
          largest = std::max(largest, std::abs(difference(i, j)) * ports[from].scale[j] / ports[to].scale[i]);
    }
  }
  return largest;
}

Complaints check_values(const ProcessCaller& process, const PortStates& ports, const Step& step,
                        const std::vector<std::byte>& memory) {
  Complaints out;
  const Propagated with = process.propagate(ports, step, memory);
  const Propagated without = process.propagate(ports, step, memory, unwritten(), false);
  if (!without.damage.empty()) out.add("without Phi and Qd: ", without.damage);
  if (with.result.refusal != without.result.refusal) out.add("without Phi and Qd it refuses otherwise");
  const auto same = [](const auto& a, const auto& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_bits);
  };
  // Of its memory counts what the next call makes of it: bytes of padding may differ.
  const Propagated next = process.propagate(ports, step, with.memory);
  const Propagated other = process.propagate(ports, step, without.memory);
  bool goes_on_alike = next.result.refusal == other.result.refusal;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (!same(with.x_plus[i], without.x_plus[i]))
      out.add("the value on '", process.spec().ports[i].name, "' differs when neither Phi nor Qd is requested");
    goes_on_alike = goes_on_alike && same(next.x_plus[i], other.x_plus[i]);
  }
  if (!goes_on_alike)
    out.add("its memory differs when neither Phi nor Qd is requested: the next call gives a different answer");
  return out;
}

Complaints check_rest(const ProcessCaller& process, const PortStates& ports, const Step& step,
                      const std::vector<std::byte>& memory, const Eigen::MatrixXd& ordinary, double rounding) {
  Complaints out;
  const Propagated still = process.propagate(ports, step, memory);
  if (!still.damage.empty()) out.add(still.damage);
  if (!still.result) return out.add("it refuses dt = 0: ", still.result.reason), out;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (!process.moves(ports, i)) continue;
    Eigen::VectorXd delta(ports[i].dof());
    ports[i].block->minus(still.x_plus[i], ports[i].x, delta);
    if (!(delta.cwiseAbs().array() <= (rounding * ports[i].scale.array() + 8 * ports[i].resolution)).all())
      out.add("dt = 0 moves '", process.spec().ports[i].name, "' by [", delta.transpose(), "]");
  }
  const Eigen::VectorXd scale = scales(ports);
  const Eigen::MatrixXd Phi = process.Phi(ports, still), Q = process.Q(ports, still);
  for (Eigen::Index j = 0; j < Phi.cols(); ++j)
    for (Eigen::Index i = 0; i < Phi.rows(); ++i) {
      const double wanted = i == j ? 1 : 0, allowed = rounding * scale[i] / scale[j];
      if (!(std::abs(Phi(i, j) - wanted) <= allowed))
        out.add("over dt = 0 Phi is not the identity: Phi(", i, ",", j, ") differs from ", wanted, " by ",
                Phi(i, j) - wanted, ", allowed for rounding ", allowed);
      const double size = std::sqrt(ordinary(i, i) * ordinary(j, j));
      if (!(std::abs(Q(i, j)) <= rounding * size))
        out.add("over dt = 0 Qd is not zero: Qd(", i, ",", j, ") is ", Q(i, j), ", over an ordinary dt ",
                ordinary(i, j));
    }
  return out;
}

Complaints check_noise_form(const Eigen::MatrixXd& Q, const std::string& of) {
  Complaints out;
  if (Q.size() == 0) return out;
  const double largest = Q.cwiseAbs().maxCoeff();
  if (!((Q - Q.transpose()).cwiseAbs().maxCoeff() <= 1e-12 * largest)) out.add(of, " is not symmetric");
  if (!(Q.diagonal().array() >= 0).all()) return out.add(of, " has a negative variance"), out;
  const Eigen::VectorXd inverse = Q.diagonal().cwiseSqrt().unaryExpr([](double v) { return v > 0 ? 1 / v : 0; });
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * Q * inverse.asDiagonal();
  const double least = algebra::eigenvalues(correlation).minCoeff();
  if (!(least >= -1e-9))
    out.add(of, " is not positive semidefinite: scaled to ones on its diagonal it has the eigenvalue ", least);
  return out;
}

Accumulated accumulate(const ProcessCaller& process, const PortStates& ports, const std::vector<Step>& parts,
                       const std::vector<std::byte>& memory) {
  const int n = offset(ports, ports.size());
  Accumulated all{Result::ok(), ports, Eigen::MatrixXd::Identity(n, n), Eigen::MatrixXd::Zero(n, n), memory};
  for (const Step& part : parts) {
    const Propagated p = process.propagate(all.ports, part, all.memory);
    all.result = p.result;
    if (!p.result) return all;
    const Eigen::MatrixXd Phi = process.Phi(all.ports, p);
    all.Q = (Phi * all.Q * Phi.transpose() + process.Q(all.ports, p)).eval();
    all.Phi = (Phi * all.Phi).eval();
    all.ports = process.after(all.ports, p);
    all.memory = p.memory;
  }
  return all;
}

Complaints check_noise(const ProcessCaller& process, const PortStates& ports, const Step& whole,
                       const std::vector<Step>& parts, const std::vector<std::byte>& memory, double relative,
                       double neglected) {
  Complaints out;
  const Propagated coarse = process.propagate(ports, whole, memory);
  if (!coarse.damage.empty()) out.add(coarse.damage);
  const Accumulated fine = accumulate(process, ports, parts, memory);
  if (!coarse.result || !fine.result)
    return out.add("refused: ", coarse.result ? fine.result.reason : coarse.result.reason), out;
  const Eigen::MatrixXd Q = process.Q(ports, coarse);
  out.add_all(check_noise_form(Q, "Qd"));
  const auto variance = [&](std::size_t port) {
    return fine.Q.diagonal().segment(offset(ports, port), ports[port].dof()).maxCoeff();
  };
  for (std::size_t to = 0; to < ports.size(); ++to)
    for (std::size_t from = to; from < ports.size(); ++from) {
      if (!process.moves(ports, to) || !process.moves(ports, from)) continue;
      const Eigen::MatrixXd given = block_of(Q, ports, to, from), wanted = block_of(fine.Q, ports, to, from);
      const double allowed =
          relative * wanted.cwiseAbs().maxCoeff() + neglected * std::sqrt(variance(to) * variance(from));
      for (Eigen::Index j = 0; j < given.cols(); ++j)
        for (Eigen::Index i = 0; i < given.rows(); ++i)
          if (!(std::abs(given(i, j) - wanted(i, j)) <= allowed))
            out.add("Qd of '", process.spec().ports[to].name, "', '", process.spec().ports[from].name, "' (", i, ",", j,
                    "): ", given(i, j), ", integrated ", wanted(i, j), ", allowed ", allowed);
    }
  return out;
}

std::pair<Eigen::MatrixXd, Eigen::MatrixXd> van_loan(const Eigen::MatrixXd& F, const Eigen::MatrixXd& GQGt, double dt) {
  // Over a part of dt that is short against F, because e^{−F dt} overflows for a fast decay, and then doubled.
  const Eigen::Index n = F.rows();
  const int doublings = std::max(0, static_cast<int>(std::ceil(std::log2(F.norm() * dt + 1e-300))));
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  A.topLeftCorner(n, n) = -F;
  A.topRightCorner(n, n) = GQGt;
  A.bottomRightCorner(n, n) = F.transpose();
  const Eigen::MatrixXd E = algebra::exponential(A * std::ldexp(dt, -doublings));
  Eigen::MatrixXd Phi = E.bottomRightCorner(n, n).transpose();
  Eigen::MatrixXd Q = Phi * E.topRightCorner(n, n);
  for (int i = 0; i < doublings; ++i) {
    Q = (Phi * Q * Phi.transpose() + Q).eval();
    Phi = (Phi * Phi).eval();
  }
  return {Phi, Q};
}

}  // namespace binnacle::testing
