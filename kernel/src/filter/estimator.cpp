// SPDX-License-Identifier: Apache-2.0
#include "filter/estimator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "filter/joseph.hpp"
#include "filter/noise_check.hpp"

namespace binnacle::filter {

constexpr double largest_variance = 1e30;

Estimator::Estimator(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena,
                     ModelCalls& calls)
    : plan_(plan),
      channels_(channels),
      arena_(arena),
      calls_(calls),
      P_(std::make_unique<Joseph>(plan.transition, plan.most_dof(), plan.covariance.in(arena))),
      workspace_(plan, plan.state.in(arena)),
      auxiliary_(plan, channels, arena),
      propagator_(plan, *P_, auxiliary_, workspace_, calls),
      linearizer_(plan, channels, auxiliary_, workspace_, calls),
      judge_(plan, arena, calls),
      corrector_(plan, calls),
      rows_(plan),
      initial_P_(as_size(plan.n) * as_size(plan.n)) {
  std::size_t bytes = 0, outputs = 0;
  for (const auto& measurement : plan.measurements) bytes = std::max(bytes, measurement.memory_bytes);
  for (const auto& block : plan.blocks) outputs = std::max(outputs, block.declaration().outputs.size());
  memory_backup_.resize(bytes);
  initial_outputs_.resize(outputs);
}

// ---- the start

void Estimator::reset() {
  std::fill_n(x(), plan_.stored_size, 0.0);
  std::fill(initial_P_.begin(), initial_P_.end(), 0.0);
  P_->set({initial_P_.data(), plan_.n, plan_.n, plan_.n});
  const auto clear = [&](const Place<std::byte>& memory) {
    std::fill_n(memory.in(arena_), memory.count, std::byte{});
    return memory.count > 0;
  };
  for (const auto& process : plan_.processes)
    if (clear(process.memory)) calls_.start(process);
  for (const auto& measurement : plan_.measurements) {
    if (measurement.noise && clear(measurement.noise_memory)) calls_.start_noise(measurement);
    for (const auto& part : measurement.parts)
      if (clear(part.memory)) calls_.start(part);
  }
}

SampleView Estimator::initial_sample(const BlockPlan& block) const {
  const auto& plan = plan_.initial[as_size(block.initial.channel)];
  return latest(plan, channels_[as_size(plan.channel)], arena_);
}

void Estimator::start() {
  for (const auto& block : plan_.blocks) start_value(block);
  std::fill(initial_P_.begin(), initial_P_.end(), 0.0);
  const MatrixView P{initial_P_.data(), plan_.n, plan_.n, plan_.n};
  for (const auto& block : plan_.blocks) start_covariance(block, P);
  P_->set(P);
}

void Estimator::start_value(const BlockPlan& block) {
  double* value = x() + block.stored_offset;
  const auto& initial = block.initial;
  if (initial.channel < 0) {
    std::copy(initial.value.begin(), initial.value.end(), value);
    return;
  }
  const SampleView view = initial_sample(block);
  for (std::size_t i = 0; i < block.declaration().outputs.size(); ++i)
    initial_outputs_[i] = view.fields[initial.fields[i]];
  const Result result = calls_.write(block, initial_outputs_.data(), value);
  if (!result) throw Stop("block '" + block.name + "' refuses its initial value: " + result.reason);
}

/// A component's own sigma, or its row of the covariance of the sample that the block's value is from.
void Estimator::start_covariance(const BlockPlan& block, MatrixView P) {
  for (std::size_t a = 0; a < block.active.size(); ++a) {
    const auto component = as_size(block.active[a]);
    const int row = block.first + static_cast<int>(a);
    const double sigma = block.initial.sigma[component];
    if (std::isfinite(sigma)) {
      P(row, row) = sigma * sigma;
      continue;
    }
    const SampleView view = initial_sample(block);
    const int dof = channels_[as_size(plan_.initial[as_size(block.initial.channel)].channel)].covariance_dof;
    if (!view.covariance)
      throw Stop("block '" + block.name + "' takes its initial sigma from a sample without covariance");
    for (const auto& other : plan_.blocks) {
      if (other.initial.channel != block.initial.channel || other.initial.covariance.empty()) continue;
      for (std::size_t b = 0; b < other.active.size(); ++b) {
        const auto other_component = as_size(other.active[b]);
        if (std::isfinite(other.initial.sigma[other_component])) continue;
        P(row, other.first + static_cast<int>(b)) =
            view.covariance[block.initial.covariance[component] + other.initial.covariance[other_component] * dof];
      }
    }
  }
}

// ---- a sample

Result Estimator::linearize(const MeasurementPlan& measurement, const SampleView& sample, const Moment& now) {
  std::byte* backup = memory_backup_.data();
  for (const auto& part : measurement.parts) {
    if (part.memory.count > 0) std::memcpy(backup, part.memory.in(arena_), part.memory.count);
    backup += part.memory.count;
  }
  return linearizer_.run(measurement, sample, now, *P_, rows_);
}

void Estimator::roll_back(const MeasurementPlan& measurement) {
  const std::byte* backup = memory_backup_.data();
  for (const auto& part : measurement.parts) {
    if (part.memory.count > 0) std::memcpy(part.memory.in(arena_), backup, part.memory.count);
    backup += part.memory.count;
  }
}

void Estimator::learn(const MeasurementPlan& measurement) {
  if (!measurement.noise || !measurement.noise->declaration().looks_back) return;
  calls_.after(measurement, {corrector_.post_fit(), rows_.m}, rows_.square(rows_.work.HPHt));
}

void Estimator::inflate(const MeasurementPlan& measurement) {
  for (const auto& inflation : measurement.inflations) P_->inflate(inflation.row, inflation.variance);
}

// ---- health

bool Estimator::is_sound() const {
  return P_->first_unsound(largest_variance) < 0 && is_finite(ConstVectorView(state(), plan_.stored_size));
}

void Estimator::stop_unsound(Time t, const std::string& culprit) const {
  const std::string why = culprit.empty() ? "" : ": " + culprit;
  for (const auto& block : plan_.blocks) {
    const double* value = state() + block.stored_offset;
    for (int i = 0; i < block.declaration().stored_size; ++i)
      if (!std::isfinite(value[i])) throw Stop("block '" + block.name + "' is not finite at " + time_text(t) + why);
    for (std::size_t a = 0; a < block.active.size(); ++a) {
      const double variance = P_->variance(block.first + static_cast<int>(a));
      if (variance >= 0 && variance < largest_variance) continue;
      char text[64];
      std::snprintf(text, sizeof text, " has the variance %.3g at ", variance);
      throw Stop("'" + block.name + "." + block.declaration().error[as_size(block.active[a])].name + "'" + text +
                 time_text(t) + why);
    }
  }
  throw Stop("the state is not finite at " + time_text(t) + why);
}

void Estimator::write(SampleWriter& slot) {
  double* out = slot.fields;
  for (const auto& block : plan_.blocks) {
    calls_.read(block, state() + block.stored_offset, out);
    out += block.declaration().outputs.size();
  }
  slot.rows = 0;
  slot.has_covariance = true;
  P_->expand({slot.covariance, plan_.n, plan_.n, plan_.n});
}

}  // namespace binnacle::filter
