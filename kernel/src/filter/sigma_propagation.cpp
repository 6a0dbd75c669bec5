// SPDX-License-Identifier: Apache-2.0
// One propagation by sigma points: x̄⁺, Φ as their statistical regression, and in Qd what that leaves. The models were called
// at the centre, with Jacobians; here they are called for their values alone.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "filter/estimator.hpp"

namespace binnacle::internal::filter {

namespace {

double largest_of(const double* numbers, int count) {
  double largest = 0;
  for (int i = 0; i < count; ++i) largest = std::max(largest, std::abs(numbers[i]));
  return largest;
}

}  // namespace

Estimator::SigmaStep::SigmaStep(const FilterPlan& plan, const std::vector<Place<std::byte>>& its_memories)
    : n(plan.n),
      points(plan.n, plan.n),
      memories(its_memories),
      x(as_size(plan.stored_size)),
      xi(as_size(plan.n)),
      back(as_size(plan.most_dof())),
      moved(as_size(std::max(plan.n, plan.most_dof()))),
      Phi(as_size(plan.n) * as_size(plan.n)),
      Omega(Phi.size()) {
  const std::size_t most_points = 1 + 2 * as_size(plan.n);
  next.resize(as_size(plan.stored_size) * most_points);
  e.resize(as_size(plan.n) * most_points);
  deltas.resize(as_size(plan.most_dof()) * most_points);
  std::size_t bytes = 0;
  for (const auto& memory : memories) bytes += memory.count;
  before.resize(bytes);
  after.resize(bytes);
}

void Estimator::SigmaStep::copy_memories(std::byte* arena, std::vector<std::byte>& to) const {
  std::byte* next_byte = to.data();
  for (const auto& memory : memories) next_byte = std::copy_n(memory.in(arena), memory.count, next_byte);
}

void Estimator::SigmaStep::put_memories(const std::vector<std::byte>& from, std::byte* arena) const {
  const std::byte* next_byte = from.data();
  for (const auto& memory : memories) {
    std::copy_n(next_byte, memory.count, memory.in(arena));
    next_byte += memory.count;
  }
}

/// After the models' calls at the centre: x_plus() is f(x̂), the tables hold their Jacobians and noise. Where sigma points
/// can not be had, these are what the step takes, and a note says why.
void Estimator::regress_step(const Driving& now, const Step& step, std::span<const InputSample> samples,
                             bool is_nominal) {
  const int n = plan_.n;
  expand_transition(plan_.jacobians, phi(), {sigma_->Phi.data(), n, n, n});
  expand_noise(plan_.jacobians, noise(), {at(plan_.regression_noise), n, n, n});
  // What is not finite at the centre is for the health check to find.
  const bool is_regressed = !is_nominal && is_finite(x_plus_) && run_points(now, step, samples);
  if (!is_regressed) std::copy(sigma_->Phi.begin(), sigma_->Phi.end(), at(plan_.regression));
}

bool Estimator::run_points(const Driving& now, const Step& step, std::span<const InputSample> samples) {
  auto& sigma = *sigma_;
  sigma.points.factor(covariance());
  const int count = sigma.points.count();
  if (count == 1) return false;  // P is zero: the Jacobians are all there is
  std::copy(x_plus_.begin(), x_plus_.end(), sigma.next.begin());
  std::copy_n(state(), plan_.stored_size, sigma.x.begin());
  sigma.copy_memories(arena_, sigma.after);
  bool is_whole = true;
  for (int point = 1; point < count && is_whole; ++point) is_whole = advance_point(point, now, step, samples);
  sigma.put_memories(sigma.after, arena_);
  std::copy_n(sigma.next.begin(), plan_.stored_size, x_plus_.begin());
  if (!is_whole) return false;
  for (const auto& block : plan_.blocks) average(block);
  hold_frozen(state());
  // Ω is about the points' mean, what P is of is about x̄⁺: E[e eᵀ] = Ω + ē ēᵀ + M P Mᵀ.
  const int n = plan_.n;
  const MatrixView Omega{sigma.Omega.data(), n, n, n}, Qd{at(plan_.regression_noise), n, n, n};
  const VectorView left(sigma.moved.data(), n);
  sigma.points.regress(sigma.errors(), sigma.jacobian(), {left, {at(plan_.regression), n, n, n}, Omega});
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) Qd(i, j) += Omega(i, j) + left[i] * left[j];
  return true;
}

/// x⁺ of a sigma point, to its column of `next`; false, with a note, where there is none.
bool Estimator::advance_point(int point, const Driving& now, const Step& step, std::span<const InputSample> samples) {
  sigma_->put_memories(sigma_->before, arena_);
  if (!perturb(point) || !run_values(now, step, samples)) return false;
  hold_frozen(sigma_->x.data());
  for (const auto& block : plan_.blocks)
    if (!is_finite(block.in(x_plus()))) {
      const auto& process = plan_.processes[as_size(block.process)];
      calls_.note_book.keep(process.type, process.pointer, "propagate", calls_.time(),
                            "it gave a value that is not finite for a sigma point: the step used the Jacobians");
      return false;
    }
  std::copy_n(x_plus(), plan_.stored_size, sigma_->next.data() + as_size(point) * as_size(plan_.stored_size));
  return true;
}

/// SigmaStep::x = x̂ ⊞ ξ. Its errors must be there to a hundredth of the block's sigma: not so far that they wrap around, nor
/// below what the stored value resolves.
bool Estimator::perturb(int point) {
  constexpr double share = 0.01;
  auto& sigma = *sigma_;
  sigma.points.offset(point, sigma.xi);
  for (const auto& block : plan_.blocks) {
    if (block.active.empty()) continue;
    const VectorView delta(block_delta_.data(), block.dof()), back(sigma.back.data(), block.dof());
    delta.as().setZero();
    for (std::size_t a = 0; a < block.active.size(); ++a) delta[block.active[a]] = sigma.xi[as_size(block.first) + a];
    double variance = 0;
    for (std::size_t a = 0; a < block.active.size(); ++a)
      variance = std::max(variance, P_->variance(block.first + static_cast<int>(a)));
    const ConstVectorView from = block.in(state());
    const VectorView to = block.in(sigma.x.data());
    if (largest_of(delta.data(), delta.size()) == 0) {
      to.as() = from.as();
      continue;
    }
    calls_.during(block, "plus", [&] { block.block->plus(from, delta, to); });
    calls_.during(block, "minus", [&] { block.block->minus(to, from, back); });
    back.as() -= delta.as();
    if (largest_of(back.data(), back.size()) <= share * std::sqrt(variance)) continue;
    calls_.note("minus", "sigma points lie beyond its chart or below its resolution: the step used the Jacobians");
    return false;
  }
  return true;
}

/// x_plus() of the models at SigmaStep::x, without Jacobians.
bool Estimator::run_values(const Driving& now, const Step& step, std::span<const InputSample> samples) {
  const Elsewhere at_point(*this, sigma_->x.data(), [&](const double* x) {
    for (std::size_t b = 0; b < plan_.blocks.size(); ++b) values_[b] = x + plan_.blocks[b].stored_offset;
    for (std::size_t p = 0; p < plan_.processes.size(); ++p)
      for (std::size_t port = 0; port < plan_.processes[p].ports.size(); ++port)
        if (const int value = plan_.processes[p].ports[port]; value >= 0 && plan_.is_block(value))
          ports_[p].inputs[port] = values_[as_size(value)];
  });
  const auto is_refused = [&](const Result& result, const char* call) {
    if (result) return false;
    char text[sizeof KeptNote::text];
    std::snprintf(text, sizeof text, "a sigma point was refused, so the step used the Jacobians: %s", result.reason);
    calls_.note(call, text);
    return true;
  };
  if (is_refused(evaluate_derived(plan_.process_derived, now, Jacobians::none), "evaluate")) return false;
  for (std::size_t p = 0; p < plan_.processes.size(); ++p)
    if (plan_.processes[p].van_loan_group < 0 && is_refused(run_model(p, step, samples, Jacobians::none), "propagate"))
      return false;
  for (const auto& group : plan_.van_loan) advance_group(group);
  return true;
}

/// The block's part of x̄⁺, in x_plus(), and of the errors e. The mean on the manifold: x̄ ← x̄ ⊞ Σ w (x_i ⊟ x̄) (Hauberg, Lauze
/// and Pedersen, Unscented Kalman filtering on Riemannian manifolds, 2013), to a billionth of the points' own deviation, or
/// until it comes no nearer: what is left then is in Qd.
void Estimator::average(const BlockPlan& block) {
  constexpr double near = 1e-9;
  constexpr int most = 10;
  auto& sigma = *sigma_;
  const int count = sigma.points.count(), dof = block.dof();
  const MatrixView deltas{sigma.deltas.data(), dof, count, dof};
  const VectorView mean = block.in(x_plus_.data()), moved(sigma.moved.data(), dof);
  double before = 0;
  for (int iteration = 0;; ++iteration) {
    for (int point = 0; point < count; ++point) {
      const double* const stored = sigma.next.data() + as_size(point) * as_size(plan_.stored_size);
      const VectorView delta(&deltas(0, point), dof);
      calls_.during(block, "minus", [&] { block.block->minus(block.in(stored), mean, delta); });
    }
    double off = 0;
    for (int i = 0; i < dof; ++i) {
      double sum = 0, square = 0;
      for (int point = 0; point < count; ++point) {
        sum += sigma.points.weight(point) * deltas(i, point);
        square += sigma.points.weight(point) * deltas(i, point) * deltas(i, point);
      }
      moved[i] = sum;
      if (square > 0) off = std::max(off, std::abs(sum) / std::sqrt(square));
    }
    if (off <= near || (iteration > 0 && off > 0.5 * before) || iteration + 1 == most) break;
    before = off;
    calls_.during(block, "plus", [&] { block.block->plus(mean, moved, mean); });
  }
  for (std::size_t a = 0; a < block.active.size(); ++a)
    for (int point = 0; point < count; ++point)
      sigma.errors()(block.first + static_cast<int>(a), point) = deltas(block.active[a], point);
}

}  // namespace binnacle::internal::filter
