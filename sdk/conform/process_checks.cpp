// SPDX-License-Identifier: Apache-2.0
// numbers.process: Φ against differences, Qd against its own halves, dt = 0, what the kernel may keep.
#include <algorithm>
#include <cmath>

#include "process_consistency.hpp"

namespace binnacle::conform {

namespace {

constexpr double ordinary_dt = 0.01;
/// What a model may leave out of Φ: an effect this small in one step, between plausible errors.
constexpr double negligible = 1e-6;
/// How far Φ may be from differences, of the largest element of Φ − I in the block: models are truncated in dt.
constexpr double truncation = 0.02;
/// Of sums of numbers of the size of the scales, and of 1 in Φ.
constexpr double rounding = 1e-12;

struct ProcessSubject {
  explicit ProcessSubject(Trial& trial) : composition(compose_example(trial)), process(trial, *composition) {
    memory = process.caller.fresh_memory();
  }
  const testing::ProcessCaller& caller() const { return process.caller; }
  const ProcessDeclaration& declared() const { return process.part.model->declaration(); }
  std::string name(std::size_t port) const { return process.part.type->spec.ports[port].name; }

  std::shared_ptr<const Composition> composition;
  ProcessFixture process;
  std::vector<std::byte> memory;
};

void transition_jacobian(Trial& trial) {
  const ProcessSubject subject(trial);
  if (!subject.process.is_closed())
    Trial::not_applicable("it has a continuous form only; the kernel makes x+ = Phi x of it");
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(600 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.process.ports(random, 0.3);
    const DrivenStep step = subject.process.step(random, ordinary_dt);
    const auto nominal = subject.process.call(ports, step, subject.memory);
    if (!nominal.result) Trial::skip(std::string("it refuses ordinary input: ") + nominal.result.reason);
    if (!trial.expect_none(testing::check_transition(subject.caller(), ports, step.step(), subject.memory,
                                                     {truncation, negligible, testing::step_sweep})))
      return;
  }
}

void moved_value(Trial& trial) {
  const ProcessSubject subject(trial);
  if (!subject.process.is_closed()) Trial::not_applicable("it has a continuous form only");
  for (int repeat = 0; repeat < trial.repeats(5); ++repeat) {
    auto random = trial.random(500 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.process.ports(random, 0.3);
    const DrivenStep step = subject.process.step(random, ordinary_dt);
    const auto nominal = subject.process.call(ports, step, subject.memory);
    if (!nominal.result) Trial::skip(std::string("it refuses ordinary input: ") + nominal.result.reason);
    if (!trial.expect_none(testing::check_values(subject.caller(), ports, step.step(), subject.memory))) return;
  }
}

void noise(Trial& trial) {
  const ProcessSubject subject(trial);
  int seen = 0;
  std::string refusal;
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(700 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.process.ports(random, 0.3);
    for (const double dt : {1e-4, ordinary_dt, 0.3}) {
      const auto p = subject.process.call(ports, subject.process.step(random, dt), subject.memory);
      if (!p.result) {
        refusal = p.result.reason;
        continue;
      }
      ++seen;
      std::ostringstream name;
      name << "Qd over " << dt << " s";
      if (!trial.expect_none(testing::check_noise_form(subject.caller().Q(ports, p), name.str()))) return;
    }
  }
  if (seen == 0) Trial::skip("it refuses ordinary input: " + refusal);
}

void rest(Trial& trial) {
  const ProcessSubject subject(trial);
  if (!subject.process.is_closed()) Trial::not_applicable("it has a continuous form only");
  auto random = trial.random(800);
  const PortStates ports = subject.process.ports(random, 0.3);
  const auto ordinary = subject.process.call(ports, subject.process.step(random, ordinary_dt), subject.memory);
  const DrivenStep still = subject.process.step(random, 0.0);
  if (!ordinary.result) Trial::skip(std::string("it refuses ordinary input: ") + ordinary.result.reason);
  trial.expect_none(testing::check_rest(subject.caller(), ports, still.step(), subject.memory,
                                        subject.caller().Q(ports, ordinary), rounding));
}

// ---- one step and its halves

struct Split {
  PortStates ports;
  testing::Propagated whole;
  testing::Accumulated halves;
};

void same_motion(Trial& trial, const ProcessSubject& subject, const Split& split) {
  for (std::size_t i = 0; i < split.ports.size(); ++i) {
    const PortState& at = split.ports[i];
    if (!subject.caller().moves(split.ports, i)) continue;
    Eigen::VectorXd change(at.dof()), gap(at.dof());
    at.block->minus(split.whole.x_plus[i], at.x, change);
    at.block->minus(split.halves.ports[i].x, split.whole.x_plus[i], gap);
    trial.expect(gap.norm() <= truncation * change.norm() + (negligible * at.scale).norm(),
                 "one step and two halves move '", subject.name(i), "' differently: by [", change.transpose(),
                 "] and [", (change + gap).transpose(), "]");
  }
}

void same_transition(Trial& trial, const ProcessSubject& subject, const Split& split) {
  const PortStates& ports = split.ports;
  const Eigen::MatrixXd Phi = subject.caller().Phi(ports, split.whole);
  for (std::size_t to = 0; to < ports.size(); ++to)
    for (std::size_t from = 0; from < ports.size(); ++from) {
      if (ports[to].is_open() || ports[from].is_open()) continue;
      const int row = testing::offset(ports, to), column = testing::offset(ports, from);
      const Eigen::MatrixXd once = Phi.block(row, column, ports[to].dof(), ports[from].dof());
      const Eigen::MatrixXd twice = split.halves.Phi.block(row, column, ports[to].dof(), ports[from].dof());
      Eigen::MatrixXd D = once;
      if (to == from) D -= Eigen::MatrixXd::Identity(D.rows(), D.cols());
      const double largest = D.cwiseAbs().maxCoeff();
      for (Eigen::Index i = 0; i < once.rows(); ++i)
        for (Eigen::Index j = 0; j < once.cols(); ++j)
          if (!trial.expect(std::abs(twice(i, j) - once(i, j)) <=
                                2 * truncation * largest + negligible * ports[to].scale[i] / ports[from].scale[j],
                            "Phi of '", subject.name(to), "' by '", subject.name(from), "' over a step is ", once(i, j),
                            ", over its halves ", twice(i, j)))
            return;
    }
}

void same_noise(Trial& trial, const ProcessSubject& subject, const Split& split) {
  const Eigen::MatrixXd Q = subject.caller().Q(split.ports, split.whole);
  for (Eigen::Index i = 0; i < Q.rows(); ++i)
    for (Eigen::Index j = 0; j < Q.cols(); ++j) {
      const double size = std::sqrt(Q(i, i) * Q(j, j));
      if (size == 0) continue;  // a model may leave out what enters by integration only
      if (!trial.expect(std::abs(Q(i, j) - split.halves.Q(i, j)) <= 0.05 * size, "Qd(", i, ",", j, ") over a step is ",
                        Q(i, j), ", over its halves ", split.halves.Q(i, j)))
        return;
    }
}

void composition(Trial& trial) {
  const ProcessSubject subject(trial);
  if (!subject.process.is_closed()) Trial::not_applicable("it has a continuous form only");
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(900 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.process.ports(random, 0.3);
    const DrivenStep whole = subject.process.step(random, ordinary_dt);
    const DrivenStep first = subject.process.first_half(whole), second = subject.process.second_half(whole);
    const Split split{ports, subject.process.call(ports, whole, subject.memory),
                      testing::accumulate(subject.caller(), ports, {first.step(), second.step()}, subject.memory)};
    if (!split.whole.result) Trial::skip(std::string("it refuses ordinary input: ") + split.whole.result.reason);
    if (!split.halves.result) Trial::skip(std::string("it refuses half a step: ") + split.halves.result.reason);
    same_motion(trial, subject, split);
    same_transition(trial, subject, split);
    same_noise(trial, subject, split);
  }
}

void discretization(Trial& trial) {
  const ProcessSubject subject(trial);
  if (!subject.process.is_closed() || !subject.declared().has_continuous_form)
    Trial::not_applicable("it has one form only");
  auto random = trial.random(950);
  const PortStates ports = subject.process.ports(random, 0.3);
  const auto closed = subject.process.call(ports, subject.process.step(random, ordinary_dt), subject.memory);
  if (!closed.result) Trial::skip(std::string("it refuses ordinary input: ") + closed.result.reason);
  const auto continuous = subject.caller().linearized(ports);
  const auto [Phi, Q] =
      testing::van_loan(subject.caller().F(ports, continuous), subject.caller().Q(ports, continuous), ordinary_dt);
  const Eigen::MatrixXd Phi_closed = subject.caller().Phi(ports, closed), Q_closed = subject.caller().Q(ports, closed);
  trial.expect((Phi - Phi_closed).cwiseAbs().maxCoeff() <= 1e-9 * Phi.cwiseAbs().maxCoeff(),
               "closed and continuous form give another Phi:\n", Phi_closed, "\nand\n", Phi);
  trial.expect((Q - Q_closed).cwiseAbs().maxCoeff() <= 1e-6 * Q.cwiseAbs().maxCoeff(),
               "closed and continuous form give another Qd:\n", Q_closed, "\nand\n", Q);
}

// ---- what the kernel may keep

/// Φ and Qd, or F and GQGᵀ, and x⁺ of the closed form.
struct Coefficients {
  Eigen::MatrixXd transition, noise;
  testing::Propagated p;
};

void same_coefficients(Trial& trial, const Coefficients& first, const Coefficients& other, double dt) {
  const auto same = [&](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, const char* name) {
    trial.expect((a.array() == b.array()).all(), "says that it is time-invariant, but ", name, " over ", dt,
                 " s is at one time and state\n", a, "\nand at others\n", b);
  };
  const bool is_closed = !other.p.x_plus.empty();
  same(first.transition, other.transition, is_closed ? "Phi" : "F");
  same(first.noise, other.noise, is_closed ? "Qd" : "GQGt");
}

/// Nor is a model at rest.
void same_state(Trial& trial, const ProcessSubject& subject, const PortStates& ports,
                const Coefficients& coefficients) {
  if (!subject.declared().is_at_rest) return;
  trial.expect(subject.declared().transition.empty() && subject.declared().noise.empty(),
               "says that it is at rest, but lists blocks of Phi or Qd");
  for (std::size_t port = 0; port < ports.size(); ++port)
    if (subject.caller().moves(ports, port))
      trial.expect(coefficients.p.x_plus[port] == ports[port].x, "says that it is at rest, but x+ of '",
                   subject.name(port), "' is not x");
}

/// A linear model with a diagonal Φ is not even asked for x⁺.
void same_product(Trial& trial, const ProcessSubject& subject, const PortStates& ports,
                  const Coefficients& coefficients) {
  const auto& couplings = subject.declared().transition;
  const auto is_diagonal = [](const Coupling& c) { return c.to == c.from && c.structure == Structure::diagonal; };
  if (!subject.declared().has_continuous_form || !std::all_of(couplings.begin(), couplings.end(), is_diagonal)) return;
  for (std::size_t port = 0; port < ports.size(); ++port) {
    if (!subject.caller().moves(ports, port)) continue;
    const int row = testing::offset(ports, port);
    for (int i = 0; i < ports[port].dof(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double product = coefficients.transition(row + i, row + i) * ports[port].x[at];
      trial.expect(coefficients.p.x_plus[port][at] == product, "x+ of '", subject.name(port), "' is ",
                   coefficients.p.x_plus[port][at], ", and Phi x is ", product);
    }
  }
}

void time_invariant(Trial& trial) {
  const ProcessSubject subject(trial);
  const auto& spec = subject.caller().spec();
  if (!subject.declared().is_time_invariant) Trial::not_applicable("it does not say that it is");
  if (!trial.expect(spec.fields.empty() && spec.inputs.empty() && subject.memory.empty(),
                    "says that it is time-invariant, but has an input, auxiliary channels or memory"))
    return;
  for (const double dt : {1e-4, ordinary_dt, 0.3}) {
    Coefficients first;
    for (std::uint64_t look = 0; look < 4; ++look) {
      auto random = trial.random(970 + look);
      const PortStates ports = subject.process.ports(random, 0.3);
      Step step = DrivenStep(dt, {}, false, static_cast<Time>(look + 1) * 3'000'000'000).step();
      step.bridges = look % 2 == 1;
      Coefficients now;
      if (subject.process.is_closed()) {
        now.p = subject.caller().propagate(ports, step, subject.memory);
        if (!now.p.result) Trial::skip(std::string("it refuses ordinary input: ") + now.p.result.reason);
        now.transition = subject.caller().Phi(ports, now.p);
        same_product(trial, subject, ports, now);
        same_state(trial, subject, ports, now);
      } else {
        now.p = subject.caller().linearized(ports);
        now.transition = subject.caller().F(ports, now.p);
      }
      now.noise = subject.caller().Q(ports, now.p);
      if (look == 0)
        first = now;
      else
        same_coefficients(trial, first, now, dt);
    }
  }
}

}  // namespace

std::vector<Check> process_checks() {
  const std::vector<Role> roles = {Role::process_model};
  return {
      check("numbers.process.value", 2, roles, {"life.repeatable"},
            "x+ is the same to the bit with and without Phi and Qd", moved_value),
      check("numbers.process.rest", 2, roles, {"life.repeatable"}, "dt = 0 gives x+ = x, Phi = I, Qd = 0", rest),
      check("numbers.process.jacobian", 2, roles, {"life.repeatable"},
            "Phi is the derivative of x+ on the manifold, and what is not declared is zero", transition_jacobian),
      check("numbers.process.noise", 2, roles, {"life.repeatable"}, "Qd is symmetric and positive semidefinite", noise),
      check("numbers.process.composition", 3, roles,
            {"numbers.process.jacobian", "numbers.process.noise", "numbers.process.rest"},
            "a step equals its two halves: x+, Phi, Qd", composition),
      check("numbers.process.discretization", 3, roles, {"numbers.process.composition"},
            "closed and continuous form agree", discretization),
      check("numbers.process.time_invariant", 2, roles, {"life.repeatable"},
            "what says that it is time-invariant gives the same Phi and Qd (F and GQGt) at every time and state",
            time_invariant),
      check("numbers.process.consistency", 5, roles,
            {"numbers.process.composition", "numbers.process.discretization", "numbers.process.time_invariant"},
            "NEES of a filter on a world that is the model stays in its band", process_consistency),
  };
}

}  // namespace binnacle::conform
