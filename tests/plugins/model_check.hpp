// SPDX-License-Identifier: Apache-2.0
// binnacle/testing.hpp in the words of these tests: one call per check, models bound on plain blocks.
#pragma once

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>

#include "binnacle/measurement_model.hpp"
#include "binnacle/testing.hpp"
#include "binnacle/view.hpp"

namespace binnacle::test {

using testing::Complaints;
using testing::Measured;
using testing::PortState;
using testing::PortStates;
using testing::Tolerance;
using testing::van_loan;

namespace detail {

inline std::vector<const double*> pointers(const PortStates& ports) {
  std::vector<const double*> x;
  for (const PortState& port : ports) x.push_back(port.is_open() ? nullptr : port.x.data());
  return x;
}

/// Whether two calls wrote the same, to the bit where it is a number.
inline bool is_same(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] != b[i] && !(std::isnan(a[i]) && std::isnan(b[i]))) return false;
  return true;
}

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
  ProcessCheck(const ProcessModel& model, ComponentSpec spec)
      : spec_(std::make_shared<const ComponentSpec>(std::move(spec))), caller_(model, *spec_) {}

  std::vector<std::byte> fresh_memory() const { return caller_.fresh_memory(); }

  Propagation propagate(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory,
                        Complaints& out) const {
    const auto first = caller_.propagate(ports, step, memory), again = caller_.propagate(ports, step, memory);
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
  Complaints transition(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory,
                        const Tolerance& tolerance) const {
    Tolerance strict = tolerance;
    strict.neglects_declared = false;  // what a model declares must be right, however small
    return check_transition(caller_, ports, step, memory, strict);
  }
  double transition_error(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory) const {
    return testing::transition_error(caller_, ports, step, memory);
  }
  Complaints noise(const PortStates& ports, const Step& whole, const std::vector<Step>& parts,
                   const std::vector<std::byte>& memory, double relative, double neglected = 1e-12) const {
    return check_noise(caller_, ports, whole, parts, memory, relative, neglected);
  }
  /// dt = 0: x⁺ = x but for the resolution of ⊟; Φ = I and Q = 0 to the bit.
  Complaints zero_step(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory) const {
    const int n = testing::offset(ports, ports.size());
    return check_rest(caller_, ports, step, memory, Eigen::MatrixXd::Zero(n, n), 0.0);
  }
  /// F and GQGᵀ over the bound ports.
  std::pair<Eigen::MatrixXd, Eigen::MatrixXd> continuous(const PortStates& ports, Complaints& out) const {
    if (!caller_.declared().has_continuous_form) out.add("no continuous form is declared");
    const auto form = caller_.linearized(ports);
    if (!form.damage.empty()) out.add(form.damage);
    return {caller_.F(ports, form), caller_.Q(ports, form)};
  }

 private:
  static Eigen::MatrixXd block(const Eigen::MatrixXd& all, const PortStates& ports, std::size_t to, std::size_t from) {
    return all.block(testing::offset(ports, to), testing::offset(ports, from), ports[to].dof(), ports[from].dof());
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
  const testing::MeasurementCaller caller(model, spec);
  Complaints out = testing::check_measurement(caller, given(spec, sample, context, auxiliary), ports,
                                              caller.fresh_memory(), tolerance, resolution);
  const Measured m = caller.linearize(given(spec, sample, context, auxiliary), ports, caller.fresh_memory());
  out.add_all(testing::check_covariance(m.R));
  if (m.result && !(m.R.diagonal().minCoeff() > 0)) out.add("R has a variance that is not positive");
  return out;
}

/// J against differences, the value without it, and what is yielded.
inline Complaints check_derived(const DerivedBlock& model, const ComponentSpec& spec, const StateBlock& yields,
                                const PortStates& ports, const Driving& context, const Tolerance& tolerance,
                                double resolution) {
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
  const int dof = block.declaration().dof();
  const PortState at{&block, x, 1.0};
  for (const double size : {0.0, 1e-8, 1e-3, 0.3, 1.0})
    for (int direction = 0; direction < 2 * dof; ++direction) {
      // Axes, and directions between them: cosines of incommensurable angles, so no run differs from another.
      Eigen::VectorXd delta = Eigen::VectorXd::Zero(dof);
      for (int i = 0; i < dof; ++i) delta[i] = direction < dof ? (i == direction) : std::cos(1.7 * direction + 2.3 * i);
      delta *= size * largest / delta.norm();
      const testing::Exactness exactness{resolution + relative * delta.norm(), 0};
      out.add_all(testing::check_laws(at, delta, exactness));
      PortState y = at;
      block.plus(at.x, delta, y.x);
      out.add_all(testing::check_readable(y, exactness));
    }
  return out;
}

/// reset_jacobian by differences of what remains after δ has been injected.
inline Complaints check_reset(const StateBlock& block, const std::vector<double>& x, const Eigen::VectorXd& delta,
                              const Tolerance& tolerance) {
  return testing::check_reset({&block, x, 0.1}, delta, 0, tolerance.relative);
}

/// output_jacobian, that there is one, by differences of `step` in every component.
inline Complaints check_outputs(const StateBlock& block, const std::vector<double>& x, double step, double share) {
  const auto& declared = block.declaration();
  const int outputs = static_cast<int>(declared.outputs.size()), dof = declared.dof();
  std::vector<double> J(static_cast<std::size_t>(outputs * dof));
  Complaints out = testing::check_output_jacobian({&block, x, 1.0}, step, share);
  if (!block.output_jacobian(x, {J.data(), outputs, dof, outputs})) out.add("output_jacobian() gives none");
  return out;
}

}  // namespace binnacle::test

/// Fails with every complaint in the message.
#define REQUIRE_NO_COMPLAINTS(check)                             \
  do {                                                           \
    const ::binnacle::testing::Complaints complaints_ = (check); \
    INFO(complaints_.text());                                    \
    REQUIRE(complaints_.empty());                                \
  } while (false)
