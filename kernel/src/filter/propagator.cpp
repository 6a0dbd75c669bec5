// SPDX-License-Identifier: Apache-2.0
#include "filter/propagator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "filter/noise_check.hpp"

namespace binnacle::filter {

namespace {

int doubles_of(const Coupling& coupling, const std::vector<int>& ports, const FilterPlan& plan) {
  const auto dof = [&](int port) { return plan.dof(ports[as_size(port)]); };
  return coupling.structure == Structure::diagonal ? dof(coupling.to) : dof(coupling.to) * dof(coupling.from);
}

}  // namespace

Propagator::Propagator(const FilterPlan& plan, const CovarianceForm& P, AuxiliaryReader& auxiliary,
                       Workspace& workspace, ModelCalls& calls)
    : plan_(plan),
      P_(P),
      auxiliary_(auxiliary),
      workspace_(workspace),
      calls_(calls),
      x_plus_(as_size(plan.stored_size)),
      delta_(as_size(plan.most_dof())),
      samples_(as_size(plan.samples_per_step)),
      fields_(as_size(plan.samples_per_step) * as_size(std::max(1, plan.max_fields))) {
  for (const auto& block : plan.blocks)
    if (block.holds_frozen) held_.push_back(&block);
  for (std::size_t p = 0; p < plan.processes.size(); ++p) {
    const auto& process = plan.processes[p];
    auto& [inputs, outputs] = ports_.emplace_back();
    for (const int value : process.ports) {
      inputs.push_back(value < 0 ? nullptr : workspace.value(value));
      const bool is_advanced =
          value >= 0 && plan.is_block(value) && plan.blocks[as_size(value)].process == static_cast<int>(p);
      outputs.push_back(is_advanced ? x_plus_.data() + plan.blocks[as_size(value)].stored_offset : nullptr);
    }
    const auto& noise = process.model->declaration().noise;
    for (std::size_t k = 0; k < noise.size(); ++k) {
      if (noise[k].to != noise[k].from) continue;
      const int block = process.ports[as_size(noise[k].to)], size = plan.blocks[as_size(block)].dof();
      diagonals_.push_back({static_cast<int>(p), block, size, noise[k].structure == Structure::diagonal ? 1 : size + 1,
                            workspace.noise[as_size(process.first_noise) + k]});
    }
  }
}

void Propagator::run(const Moment& now, Time t1, std::span<const InputSample> samples, const double* x) {
  if (!plan_.process_derived.empty()) {
    const Result result = evaluate_derived(plan_, plan_.process_derived, now, workspace_, calls_);
    if (!result)
      throw Stop("a derived block cannot be evaluated at " + time_text(now.t) + ": " + std::string(result.reason));
  }
  run_models(now, t1, samples);
  hold_frozen(x);
  gather(plan_.gathers, workspace_.phi);
  gather(plan_.noise_gathers, workspace_.noise);
}

/// The step as a process with input sees it.
Step Propagator::read_input(const ProcessPlan& process, Step step, std::span<const InputSample> samples) {
  const auto width = process.fields.epoch.size();
  step.dt = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    SampleView raw;
    raw.fields = samples[i].fields;
    double* converted = fields_.data() + i * width;
    read_fields(process.fields, raw, samples[i].dt, converted);
    samples_[i] = samples[i];
    samples_[i].fields = converted;
    step.dt += samples[i].dt;
  }
  step.samples = {samples_.data(), samples.size()};
  return step;
}

void Propagator::run_models(const Moment& now, Time t1, std::span<const InputSample> samples) {
  const bool bridges = !samples.empty() && samples.front().bridges;  // such a sample is stepped alone
  const Step step{now.t, t1, seconds(t1 - now.t), {}, bridges};
  for (std::size_t p = 0; p < plan_.processes.size(); ++p) {
    const auto& process = plan_.processes[p];
    if (process.van_loan_group >= 0) {
      linearize(p);
      continue;
    }
    ProcessOutput out{ports_[p].outputs.data(), workspace_.phi.data() + process.first_transition,
                      workspace_.noise.data() + process.first_noise};
    const Result result = calls_.propagate(process, process.uses_input ? read_input(process, step, samples) : step,
                                           ports_[p].inputs.data(), auxiliary_.read(process.auxiliary), out);
    if (!result) throw Stop("process '" + process.name + "' cannot go on at " + time_text(t1) + ": " + result.reason);
  }
  check_noise(t1);
  for (const auto& group : plan_.van_loan) discretize_group(group, step.dt);
}

/// The discretization of what is not finite would not end.
void Propagator::linearize(std::size_t index) {
  const auto& process = plan_.processes[index];
  ContinuousOutput out{workspace_.phi.data() + process.first_transition, workspace_.noise.data() + process.first_noise};
  calls_.linearized(process, ports_[index].inputs.data(), auxiliary_.read(process.auxiliary), out);
  const auto& transition = process.model->declaration().transition;
  for (std::size_t k = 0; k < transition.size(); ++k)
    if (!is_finite(ConstVectorView(workspace_.phi[as_size(process.first_transition) + k],
                                   doubles_of(transition[k], process.ports, plan_))))
      throw Stop(call_text(process.type, process.pointer, "linearized", calls_.time()) + " gave F(" +
                 plan_.blocks[as_size(process.ports[as_size(transition[k].to)])].name + "), which is not finite");
}

/// What is infinite comes out in the health check.
void Propagator::check_noise(Time t) const {
  for (const auto& diagonal : diagonals_)
    for (int i = 0; i < diagonal.dof; ++i)
      if (const double q = diagonal.q[i * diagonal.step]; !(q >= 0 && q <= std::numeric_limits<double>::max())) {
        judge_noise(diagonal, t);
        break;
      }
}

/// Variances are not negative; what is so by rounding, next to the component's own variance, is let pass.
void Propagator::judge_noise(const Diagonal& diagonal, Time t) const {
  constexpr double largest = std::numeric_limits<double>::max(), rounding = 1e-12;
  const auto& block = plan_.blocks[as_size(diagonal.block)];
  for (std::size_t a = 0; a < block.active.size(); ++a) {
    const double variance = diagonal.q[block.active[a] * diagonal.step];
    if (variance >= -rounding * P_.variance(block.first + static_cast<int>(a)) && variance <= largest) continue;
    const auto& plan = plan_.processes[as_size(diagonal.process)];
    char value[32];
    std::snprintf(value, sizeof value, "%.3g", variance);
    throw Stop(call_text(plan.type, plan.pointer, plan.van_loan_group >= 0 ? "linearized" : "propagate", t) +
               " gave '" + block.name + "." + block.declaration().error[as_size(block.active[a])].name +
               "' the process noise " + value + ", which is no variance");
  }
}

std::string Propagator::culprit(Time t1) const {
  for (const auto& process : plan_.processes) {
    if (process.van_loan_group >= 0) continue;  // examined before it was discretized
    const auto blame = [&](const std::string& what) {
      return call_text(process.type, process.pointer, "propagate", t1) + " gave " + what + ", which is not finite";
    };
    const auto name = [&](int port) {
      const int value = process.ports[as_size(port)];
      return plan_.is_block(value) ? plan_.blocks[as_size(value)].name : plan_.derived_at(value).name;
    };
    const auto find = [&](const std::vector<Coupling>& couplings, const double* const* table, const char* matrix) {
      for (std::size_t k = 0; k < couplings.size(); ++k)
        if (!is_finite(ConstVectorView(table[k], doubles_of(couplings[k], process.ports, plan_))))
          return blame(std::string(matrix) + "(" + name(couplings[k].to) + ", " + name(couplings[k].from) + ")");
      return std::string();
    };
    for (const auto& block : plan_.blocks)
      if (&plan_.processes[as_size(block.process)] == &process &&
          !is_finite(ConstVectorView(x_plus_).segment(block.stored_offset, block.declaration().stored_size)))
        return blame("'" + block.name + "'");
    const auto& declared = process.model->declaration();
    std::string found = find(declared.transition, workspace_.phi.data() + process.first_transition, "Phi");
    if (found.empty()) found = find(declared.noise, workspace_.noise.data() + process.first_noise, "Qd");
    if (!found.empty()) return found;
  }
  return "";
}

namespace {

void spread(const std::vector<VanLoanGroup::Block>& blocks, const std::vector<double*>& table, std::size_t n,
            bool is_mirrored, double* matrix) {
  std::fill_n(matrix, n * n, 0.0);
  for (const auto& block : blocks) {
    const double* from = table[as_size(block.table)];
    for (int j = 0; j < block.columns; ++j)
      for (int i = 0; i < block.rows; ++i) {
        if (block.structure == Structure::diagonal && i != j) continue;
        const double value = block.structure == Structure::diagonal ? from[i] : from[i + j * block.rows];
        matrix[as_size(block.row + i) + as_size(block.column + j) * n] = value;
        if (is_mirrored) matrix[as_size(block.column + j) + as_size(block.row + i) * n] = value;
      }
  }
}

void collect(const std::vector<VanLoanGroup::Block>& blocks, const double* matrix, int n,
             const std::vector<double*>& table) {
  for (const auto& block : blocks)
    matrix_at(table[as_size(block.table)], block.rows, block.columns) =
        matrix_at(matrix, n, n).block(block.row, block.column, block.rows, block.columns);
}

}  // namespace

void Propagator::discretize_group(const VanLoanGroup& group, double dt) {
  const auto n = as_size(group.columns);
  double* const F = workspace_.at(group.work);
  double* const Q = F + n * n;
  double* const Phi = Q + n * n;
  double* const Qd = Phi + n * n;
  spread(group.dynamics, workspace_.phi, n, false, F);
  spread(group.noise, workspace_.noise, n, true, Q);
  // What is frozen is taken as known: its noise must not reach others through the coupling.
  for (const auto& part : group.advanced) {
    const auto& use = plan_.blocks[as_size(part.value)].use;
    for (int i = 0; i < part.dof; ++i) {
      if (use[as_size(i)] != Use::frozen) continue;
      const auto row = as_size(part.first + i);
      for (std::size_t j = 0; j < n; ++j) Q[row + j * n] = Q[j + row * n] = 0;
    }
  }
  discretize(F, Q, group.columns, dt, Phi, Qd, Qd + n * n);
  collect(group.phi, Phi, group.columns, workspace_.phi);
  collect(group.qd, Qd, group.columns, workspace_.noise);
  advance_group(group, Phi);
}

/// x⁺ = Φ x.
void Propagator::advance_group(const VanLoanGroup& group, const double* Phi) {
  const auto columns = matrix_at(Phi, group.columns, group.columns);
  for (const auto& part : group.advanced) {
    auto out = vector_at(x_plus_.data() + plan_.blocks[as_size(part.value)].stored_offset, part.dof);
    out.setZero();
    for (const auto* inputs : {&group.advanced, &group.read})
      for (const auto& input : *inputs)
        for (int j = 0; j < input.dof; ++j)
          out += columns.col(input.first + j).segment(part.first, part.dof) * workspace_.value(input.value)[j];
  }
}

/// An element of a block of Φ or Qd, chained through the derived value in between.
double Propagator::gathered(const GatherPlan::Term& term, const double* block, int row, int column, int dof) {
  const bool is_diagonal = term.structure == Structure::diagonal;
  if (term.derived < 0) return is_diagonal ? (row == column ? block[row] : 0.0) : block[row + column * dof];
  const int inner = plan_.derived_at(term.derived).dof();
  const double* chain = workspace_.at(term.chain) + column * inner;
  if (is_diagonal) return block[row] * chain[row];
  double value = 0;
  for (int k = 0; k < inner; ++k) value += block[row + k * dof] * chain[k];
  return value;
}

void Propagator::gather(const std::vector<GatherPlan>& plans, const std::vector<double*>& table) {
  for (const auto& plan : plans) {
    const auto& to = plan_.blocks[as_size(plan.to_block)];
    const auto& from = plan_.blocks[as_size(plan.from_block)];
    const int rows = static_cast<int>(to.active.size());
    const int columns = static_cast<int>(from.active.size());
    double* target = workspace_.at(plan.target);
    std::fill_n(target, rows * columns, 0.0);
    for (const auto& term : plan.terms) {
      const double* block = table[as_size(term.source)];
      for (int c = 0; c < columns; ++c)
        for (int r = 0; r < rows; ++r)
          target[r + c * rows] += gathered(term, block, to.active[as_size(r)], from.active[as_size(c)], to.dof());
    }
  }
}

void Propagator::hold_frozen(const double* x) {
  for (const BlockPlan* held : held_) {
    const BlockPlan& block = *held;
    double* next = x_plus_.data() + block.stored_offset;
    const double* now = x + block.stored_offset;
    if (block.active.empty()) {
      std::copy_n(now, block.declaration().stored_size, next);
      continue;
    }
    calls_.minus(block, next, now, delta_.data());
    for (int i = 0; i < block.dof(); ++i)
      if (block.use[as_size(i)] == Use::frozen) delta_[as_size(i)] = 0;
    calls_.plus(block, now, delta_.data(), next);
  }
}

}  // namespace binnacle::filter
