// SPDX-License-Identifier: Apache-2.0
// One propagation but for P: process models, joint discretization, gathering of what is frozen or derived.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "filter/estimator.hpp"

namespace binnacle::internal::filter {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// A block of Φ, F, Qd or GQGᵀ as a process wrote it.
ConstVectorView block_of(const Coupling& coupling, const double* block, const std::vector<int>& ports,
                         const FilterPlan& plan) {
  const auto dof = [&](int port) { return plan.dof(ports[as_size(port)]); };
  return {block, coupling.structure == Structure::diagonal ? dof(coupling.to) : dof(coupling.to) * dof(coupling.from)};
}

}  // namespace

void Estimator::propagate(const Driving& now, Time t1, std::span<const InputSample> samples, bool is_nominal) {
  if (sigma_) sigma_->copy_memories(arena_, sigma_->before);
  if (const Result result = evaluate_derived(plan_.process_derived, now, Jacobians::wanted); !result)
    throw Stop("a derived block cannot be evaluated at " + time_text(now.t) + ": " + result.reason);
  const bool bridges = !samples.empty() && samples.front().bridges;  // such a sample is stepped alone
  const Step step{now.t, t1, seconds(t1 - now.t), {}, bridges};
  // What time-invariant models wrote, and the kernel made of it, is a function of the step's length alone. Until all have
  // written, there is nothing of this one.
  const bool is_kept = step.dt == std::exchange(kept_dt_, not_a_number);
  for (std::size_t p = 0; p < plan_.processes.size(); ++p) run_process(p, step, samples, is_kept);
  check_noise(t1);
  for (const auto& group : plan_.van_loan)
    if (!is_kept || !group.is_kept) discretize_group(group, step.dt);
  kept_dt_ = step.dt;
  for (const auto& group : plan_.van_loan) advance_group(group);
  if (is_kept) scale_blocks();
  hold_frozen(state());
  gather();
  if (sigma_) regress_step(now, step, samples, is_nominal);
}

/// What of a process does not hold from the step before.
void Estimator::run_process(std::size_t index, const Step& step, std::span<const InputSample> samples, bool is_kept) {
  using Kept = ProcessPlan::Kept;
  const auto& process = plan_.processes[index];
  const bool has_written = is_kept && process.kept != Kept::nothing;
  if (process.van_loan_group >= 0) {
    if (!has_written) run_continuous(index);
    return;
  }
  if (is_kept && process.kept == Kept::all) return;
  const Result result = run_model(index, step, samples, has_written ? Jacobians::none : Jacobians::wanted);
  if (!result)
    throw Stop("process '" + process.name + "' cannot continue at " + time_text(step.t1) + ": " + result.reason);
}

/// x⁺ = Φ x of what is kept whole: the model's own product, to the bit.
void Estimator::scale_blocks() {
  for (const auto& [next, factors, now, count] : scalings_)
    for (int i = 0; i < count; ++i) next[i] = factors ? factors[i] * now[i] : now[i];
}

/// The step as a process with input sees it.
void Estimator::read_input(std::size_t index, std::span<const InputSample> samples, Step& step) {
  const auto& process = plan_.processes[index];
  const auto width = process.fields.epoch.size();
  step.dt = 0;
  if (ports_[index].reads_as_it_stands) {
    for (const InputSample& sample : samples) step.dt += sample.dt;
    step.samples = samples;
    return;
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples_[i] = samples[i];
    samples_[i].fields = fields_.data() + i * width;
    convert(process.fields, samples[i].fields, samples[i].dt, fields_.data() + i * width);
    step.dt += samples[i].dt;
  }
  step.samples = {samples_.data(), samples.size()};
}

Result Estimator::run_model(std::size_t index, const Step& step, std::span<const InputSample> samples,
                            Jacobians wanted) {
  const auto& process = plan_.processes[index];
  ProcessOutput out{ports_[index].outputs.data(), {}, {}};
  if (wanted == Jacobians::wanted)
    out.phi = phi_.data() + process.first_transition, out.Qd = noise_.data() + process.first_noise;
  ProcessInput in{step, ports_[index].inputs.data(), auxiliary(process.auxiliary), memory_of(process.memory),
                  calls_.notes()};
  if (process.uses_input) read_input(index, samples, in.step);
  return calls_.during(process, "propagate", [&] { return process.model->propagate(in, out); });
}

/// The discretization of what is not finite would not end.
void Estimator::run_continuous(std::size_t index) {
  const auto& process = plan_.processes[index];
  double* const* const F = phi_.data() + process.first_transition;
  ContinuousOutput out{F, noise_.data() + process.first_noise};
  const ContinuousInput in{ports_[index].inputs.data(), auxiliary(process.auxiliary), calls_.notes()};
  calls_.during(process, "linearized", [&] { process.model->linearized(in, out); });
  const auto& transition = process.model->declaration().transition;
  for (std::size_t k = 0; k < transition.size(); ++k)
    if (!is_finite(block_of(transition[k], F[k], process.ports, plan_)))
      throw Stop(call_text(process, "linearized", calls_.time()) + " gave F(" +
                 plan_.blocks[as_size(process.ports[as_size(transition[k].to)])].name + "), which is not finite");
}

/// Variances are not negative; what is so by rounding, next to the component's own variance, is let pass. What is infinite
/// elsewhere comes out in the health check.
void Estimator::check_noise(Time t) const {
  constexpr double largest = std::numeric_limits<double>::max(), rounding = 1e-12;
  if (std::ranges::all_of(noise_variances_, [](const double* q) { return *q >= 0 && *q <= largest; })) return;
  for (const auto& [process, block, q, step] : diagonals_)
    for (std::size_t a = 0; a < block->active.size(); ++a) {
      const double variance = q[block->active[a] * step];
      if (variance >= 0 && variance <= largest) continue;
      const int row = block->first + static_cast<int>(a);
      if (variance >= -rounding * P_->variance(row) && variance <= largest) continue;
      char value[32];
      std::snprintf(value, sizeof value, "%.3g", variance);
      throw Stop(call_text(*process, process->van_loan_group >= 0 ? "linearized" : "propagate", t) + " gave '" +
                 block->name + "." + block->declaration().error[as_size(block->active[a])].name +
                 "' the process noise " + value + ", which is not a variance");
    }
}

/// After a step whose result is not finite: "…: propagate at 3 s gave Phi(a, b), which is not finite", or "" where no
/// process is to blame.
std::string Estimator::culprit(Time t1) const {
  for (const auto& process : plan_.processes) {
    if (process.van_loan_group >= 0) continue;  // examined before it was discretized
    std::string found;
    const auto name = [&](int port) {
      const int value = process.ports[as_size(port)];
      return plan_.is_block(value) ? plan_.blocks[as_size(value)].name : plan_.derived_at(value).name;
    };
    const auto examine = [&](const std::vector<Coupling>& couplings, const double* const* table, const char* matrix) {
      for (std::size_t k = 0; k < couplings.size() && found.empty(); ++k)
        if (!is_finite(block_of(couplings[k], table[k], process.ports, plan_)))
          found = std::string(matrix) + "(" + name(couplings[k].to) + ", " + name(couplings[k].from) + ")";
    };
    for (const auto& block : plan_.blocks)
      if (&plan_.processes[as_size(block.process)] == &process && found.empty() && !is_finite(block.in(x_plus())))
        found = "'" + block.name + "'";
    const auto& declared = process.model->declaration();
    examine(declared.transition, phi() + process.first_transition, "Phi");
    examine(declared.noise, noise() + process.first_noise, "Qd");
    if (!found.empty()) return call_text(process, "propagate", t1) + " gave " + found + ", which is not finite";
  }
  return "";
}

namespace {

/// The blocks of a table in the group's matrix.
void spread(const std::vector<VanLoanGroup::Block>& blocks, const std::vector<double*>& table, bool is_mirrored,
            MatrixView matrix) {
  matrix.as().setZero();
  for (const auto& block : blocks) {
    const bool is_diagonal = block.structure == Structure::diagonal;
    const double* from = table[as_size(block.table)];
    for (int j = 0; j < block.columns; ++j)
      for (int i = 0; i < block.rows; ++i) {
        if (is_diagonal && i != j) continue;
        const int row = block.row + i, column = block.column + j;
        matrix(row, column) = from[is_diagonal ? i : i + j * block.rows];
        if (is_mirrored) matrix(column, row) = matrix(row, column);
      }
  }
}

void collect(const std::vector<VanLoanGroup::Block>& blocks, MatrixView matrix, const std::vector<double*>& table) {
  for (const auto& block : blocks)
    matrix_at(table[as_size(block.table)], block.rows, block.columns) =
        matrix.block(block.row, block.column, block.rows, block.columns).as();
}

using Matrix = Eigen::Map<Eigen::MatrixXd, Eigen::Unaligned>;
using ConstMatrix = Eigen::Map<const Eigen::MatrixXd, Eigen::Unaligned>;

/// C = A B, or A Bᵀ. Models are sparse.
template <bool is_transposed = false>
void multiply(const auto& A, const auto& B, Matrix& C) {
  C.setZero();
  for (int j = 0; j < C.cols(); ++j)
    for (int k = 0; k < C.cols(); ++k)
      if (const double b = is_transposed ? B(j, k) : B(k, j); b != 0) C.col(j) += A.col(k) * b;
}

double norm_1(const ConstMatrix& A) {
  double largest = 0;
  for (int j = 0; j < A.cols(); ++j) {
    double sum = 0;
    for (int i = 0; i < A.rows(); ++i) sum += std::abs(A(i, j));
    largest = std::max(largest, sum);
  }
  return largest;
}

}  // namespace

void discretize(const double* F_data, const double* Q_data, int n, double dt, double* Phi_data, double* Qd_data,
                double* work) {
  const std::size_t size = as_size(n) * as_size(n);
  const ConstMatrix F(F_data, n, n), Q(Q_data, n, n);
  Matrix Phi(Phi_data, n, n), Qd(Qd_data, n, n);
  Matrix term(work, n, n);          // (F h)^k / k!
  Matrix noise(work + size, n, n);  // k-th Taylor term of Qd
  Matrix scratch(work + 2 * size, n, n), other(work + 3 * size, n, n);

  int doublings = 0;
  const double reach = norm_1(F) * dt;
  if (reach > 0.25) doublings = std::max(0, static_cast<int>(std::ceil(std::log2(reach / 0.25))));
  const double h = std::ldexp(dt, -doublings);

  // Phi = Σ (F h)^k/k!;  Qd = Σ T_k with T_1 = Q h, T_{k+1} = (F T_k + T_k Fᵀ) h/(k+1).
  Phi.setIdentity();
  term.setIdentity();
  Qd = noise = Q * h;
  constexpr int order = 14;  // 0.5^15/15! < 1e-16 for Qd, whose terms grow twice as fast
  for (int k = 1; k <= order; ++k) {
    multiply(F, term, scratch);
    Phi += term = scratch * (h / k);
    multiply(F, noise, scratch);
    multiply<true>(noise, F, other);
    Qd += noise = (scratch + other) * (h / (k + 1));
  }
  for (int d = 0; d < doublings; ++d) {
    multiply(Phi, Qd, scratch);
    multiply<true>(scratch, Phi, other);
    Qd += other;
    multiply(Phi, Phi, scratch);
    Phi = scratch;
  }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < j; ++i) Qd(i, j) = Qd(j, i) = 0.5 * (Qd(i, j) + Qd(j, i));
}

void Estimator::discretize_group(const VanLoanGroup& group, double dt) {
  const int n = group.columns;
  const auto matrix = [&](int k) { return MatrixView{at(group.work) + k * n * n, n, n, n}; };
  const MatrixView F = matrix(0), Q = matrix(1), Phi = matrix(2), Qd = matrix(3);
  spread(group.dynamics, phi_, false, F);
  spread(group.noise, noise_, true, Q);
  // What is frozen is taken as known: its noise must not reach others through the coupling.
  for (const auto& part : group.advanced)
    for (int i = 0; i < part.dof; ++i)
      if (plan_.blocks[as_size(part.value)].use[as_size(i)] == Use::frozen)
        for (int j = 0; j < n; ++j) Q(part.first + i, j) = Q(j, part.first + i) = 0;
  discretize(F.data, Q.data, n, dt, Phi.data, Qd.data, matrix(4).data);
  collect(group.phi, Phi, phi_);
  collect(group.qd, Qd, noise_);
}

/// x⁺ = Φ x, with Φ of the last discretization.
void Estimator::advance_group(const VanLoanGroup& group) {
  const int n = group.columns;
  const double* const Phi = at(group.work) + 2 * n * n;
  double* const now = group_x_.data();
  for (const auto* parts : {&group.advanced, &group.read})
    for (const auto& part : *parts) std::copy_n(values_[as_size(part.value)], part.dof, now + part.first);
  for (const auto& part : group.advanced) {
    double* const next = x_plus_.data() + plan_.blocks[as_size(part.value)].stored_offset;
    for (int i = 0; i < part.dof; ++i) {
      double sum = 0;
      for (int j = 0; j < n; ++j) sum += Phi[part.first + i + j * n] * now[j];
      next[i] = sum;
    }
  }
}

/// An element of a block of Φ, chained through the derived value in between.
double Estimator::gathered(const GatherPlan::Term& term, const double* block, int row, int column, int dof) {
  const bool is_diagonal = term.structure == Structure::diagonal;
  if (term.derived < 0) return is_diagonal ? (row == column ? block[row] : 0.0) : block[row + column * dof];
  const int inner = plan_.derived_at(term.derived).dof();
  const double* chain = at(term.chain) + column * inner;
  if (is_diagonal) return block[row] * chain[row];
  double value = 0;
  for (int k = 0; k < inner; ++k) value += block[row + k * dof] * chain[k];
  return value;
}

/// Blocks of one term without a derived value are copies of elements; what a diagonal one lacks stays zero.
void Estimator::list_gathers() {
  for (const auto& plan : plan_.gathers) {
    const auto& own = plan.terms.front();
    if (plan.terms.size() > 1 || own.derived >= 0) {
      gathered_.summed.push_back(&plan);
      continue;
    }
    const auto& to = plan_.blocks[as_size(plan.to_block)];
    const auto& from = plan_.blocks[as_size(plan.from_block)];
    double* target = at(plan.target);
    for (const int column : from.active)
      for (const int row : to.active) {
        double* const element = target++;
        const bool is_diagonal = own.structure == Structure::diagonal;
        if (is_diagonal && row != column) continue;
        gathered_.copies.push_back(
            {phi_[as_size(own.source)] + (is_diagonal ? row : row + column * to.dof()), element});
      }
  }
}

void Estimator::gather() {
  const Gathered::Copy* const end = gathered_.copies.data() + gathered_.copies.size();
  for (const auto* copy = gathered_.copies.data(); copy != end; ++copy)
    *copy->to = 0.0 + *copy->from;  // as a sum: no negative zero
  for (const GatherPlan* const plan : gathered_.summed) {
    const auto& to = plan_.blocks[as_size(plan->to_block)];
    const auto& from = plan_.blocks[as_size(plan->from_block)];
    const int rows = static_cast<int>(to.active.size());
    const int columns = static_cast<int>(from.active.size());
    double* target = at(plan->target);
    std::fill_n(target, rows * columns, 0.0);
    for (const auto& term : plan->terms) {
      const double* block = phi_[as_size(term.source)];
      for (int c = 0; c < columns; ++c)
        for (int r = 0; r < rows; ++r)
          target[r + c * rows] += gathered(term, block, to.active[as_size(r)], from.active[as_size(c)], to.dof());
    }
  }
}

/// What is frozen stays as it is in x, where its block holds it.
void Estimator::hold_frozen(const double* x) {
  for (const BlockPlan* const held : held_) {
    const BlockPlan& block = *held;
    const VectorView next = block.in(x_plus_.data());
    const ConstVectorView now = block.in(x);
    if (block.active.empty()) {
      next.as() = now.as();
      continue;
    }
    const VectorView delta(block_delta_.data(), block.dof());
    calls_.during(block, "minus", [&] { block.block->minus(next, now, delta); });
    for (int i = 0; i < delta.size(); ++i)
      if (block.use[as_size(i)] == Use::frozen) delta[i] = 0;
    calls_.during(block, "plus", [&] { block.block->plus(now, delta, next); });
  }
}

}  // namespace binnacle::internal::filter
