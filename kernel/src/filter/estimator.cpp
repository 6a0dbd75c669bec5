// SPDX-License-Identifier: Apache-2.0
#include "filter/estimator.hpp"

#include <cmath>
#include <cstdio>

namespace binnacle::internal::filter {

constexpr double largest_variance = 1e30;

Estimator::Estimator(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena,
                     ModelCalls& calls)
    : plan_(plan),
      channels_(channels),
      arena_(arena),
      calls_(calls),
      P_(make_covariance(plan.covariance_kind, plan.transition, plan.most_dof(), plan.max_rows,
                         plan.covariance.in(arena))),
      rows_(plan),
      outlier_test_(plan.max_rows),
      opening_(plan.n, plan.max_rows),
      workspace_(plan.workspace),
      x_plus_(as_size(plan.stored_size)),
      x_corrected_(as_size(plan.stored_size)) {
  allocate();
  for (const auto one : plan.ones) workspace_[one] = 1.0;
  for (const auto offset : plan.transition_blocks) phi_.push_back(at(offset));
  for (const auto offset : plan.noise_blocks) noise_.push_back(at(offset));
  for (const auto& block : plan.blocks) values_.push_back(state() + block.stored_offset);
  for (const auto& derived : plan.derived) values_.push_back(at(derived.value));
  for (const auto& block : plan.blocks)
    if (block.holds_frozen) held_.push_back(&block);
  for (std::size_t p = 0; p < plan.processes.size(); ++p) list_ports(plan.processes[p], static_cast<int>(p));
  list_gathers();
  if (!plan.is_unscented) return;
  std::vector<Place<std::byte>> memories;
  for (const auto& process : plan.processes)
    if (process.memory.count > 0) memories.push_back(process.memory);
  sigma_ = std::make_unique<SigmaStep>(plan, memories);
}

void Estimator::allocate() {
  const auto fit = [](auto& list, std::size_t size) { list.resize(std::max(list.size(), size)); };
  const auto fit_auxiliary = [&](const AuxiliaryPlan& model) {
    std::size_t doubles = 0;
    for (std::size_t i = 0; i < model.channels.size(); ++i) {
      if (model.channels[i] < 0) continue;
      const auto& channel = channels_[as_size(plan_.auxiliary[as_size(model.channels[i])].channel)];
      doubles += model.fields[i].doubles(channel.declaration.max_rows);
    }
    fit(auxiliary_samples_, model.channels.size());
    fit(auxiliary_fields_, doubles);
  };
  const auto fit_model = [&](const auto& model) {
    fit(port_values_, model.ports.size());
    fit(jacobians_, model.ports.size());
    fit(driving_rates_, model.driving_rates.size());
  };
  for (const auto& block : plan_.blocks) fit(outputs_, as_size(block.outputs()));
  for (const auto& derived : plan_.derived) fit_model(derived);
  samples_.resize(as_size(plan_.samples_per_step));
  for (const auto& process : plan_.processes) {
    fit_auxiliary(process.auxiliary);
    fit(fields_, samples_.size() * process.fields.epoch.size());
  }
  for (const auto& measurement : plan_.measurements) {
    fit(memory_backup_, measurement.memory.count);
    fit(noise_backup_, measurement.noise_memory.count);
    for (const auto& part : measurement.parts) {
      fit_model(part);
      fit_auxiliary(part.auxiliary);
      fit(fields_, part.fields.doubles(channels_[as_size(measurement.channel)].declaration.max_rows));
      fit(first_row_, part.ports.size());
      std::size_t dof = 0;
      for (const auto& read : part.reads) dof += as_size(read.dof);
      if (part.model->declaration().needs_covariance) fit(port_covariance_, dof * dof);
    }
  }
  for (const auto& group : plan_.van_loan) fit(group_x_, as_size(group.columns));
  const std::size_t most_dof = as_size(plan_.most_dof());
  block_delta_.resize(most_dof);
  block_jacobian_.resize(most_dof * most_dof);
  resets_.reserve(plan_.blocks.size());
  using enum UpdatePlan::Type;
  const auto any = [&](UpdatePlan::Type type) {
    return std::ranges::any_of(plan_.measurements, [&](const auto& its) { return its.update.type == type; });
  };
  if (any(iterated)) iteration_ = std::make_unique<Iteration>(plan_);
  if (any(unscented)) sigma_points_ = std::make_unique<SeenSigmaPoints>(plan_);
  if (iteration_ || sigma_points_) other_ = std::make_unique<OtherStates>(plan_);
  for (auto* square : {&initial_P_, &reset_jacobians_}) square->resize(as_size(plan_.n) * as_size(plan_.n));
}

void Estimator::list_ports(const ProcessPlan& process, int index) {
  auto& [inputs, outputs, reads_as_it_stands] = ports_.emplace_back();
  reads_as_it_stands = process.fields.is_as_it_stands();
  for (const int value : process.ports) {
    inputs.push_back(value < 0 ? nullptr : values_[as_size(value)]);
    const bool is_advanced = value >= 0 && plan_.is_block(value) && plan_.blocks[as_size(value)].process == index;
    outputs.push_back(is_advanced ? x_plus_.data() + plan_.blocks[as_size(value)].stored_offset : nullptr);
  }
  const auto& noise = process.model->declaration().noise;
  for (std::size_t k = 0; k < noise.size(); ++k) {
    if (noise[k].to != noise[k].from) continue;
    const BlockPlan& block = plan_.blocks[as_size(process.ports[as_size(noise[k].to)])];
    diagonals_.push_back({&process, &block, noise_[as_size(process.first_noise) + k],
                          noise[k].structure == Structure::diagonal ? 1 : block.dof() + 1});
    for (const int component : block.active)
      noise_variances_.push_back(diagonals_.back().q + component * diagonals_.back().step);
  }
  if (process.kept == ProcessPlan::Kept::all) list_scalings(process);
}

void Estimator::list_scalings(const ProcessPlan& process) {
  const auto& transition = process.model->declaration().transition;
  for (std::size_t port = 0; port < process.ports.size(); ++port) {
    double* const next = ports_.back().outputs[port];
    if (!next) continue;
    const auto own = std::ranges::find(transition, static_cast<int>(port), &Coupling::to);
    const auto place = as_size(process.first_transition + static_cast<int>(own - transition.begin()));
    const BlockPlan& block = plan_.blocks[as_size(process.ports[port])];
    scalings_.push_back(
        {next, own == transition.end() ? nullptr : phi_[place], ports_.back().inputs[port], block.stored_size});
  }
}

void Estimator::reset() {
  std::fill_n(x(), plan_.stored_size, 0.0);
  std::fill(initial_P_.begin(), initial_P_.end(), 0.0);
  P_->set({initial_P_.data(), plan_.n, plan_.n, plan_.n});
  const auto start = [&](const auto& type, const auto& pointer, const auto& model, const Place<std::byte>& memory) {
    std::fill_n(memory.in(arena_), memory.count, std::byte{});
    if (memory.count > 0) calls_.during(type, pointer, "start", [&] { model->start(memory.in(arena_)); });
  };
  for (const auto& process : plan_.processes) start(process.type, process.pointer, process.model, process.memory);
  for (const auto& measurement : plan_.measurements) {
    start(measurement.noise_type, measurement.pointer, measurement.noise, measurement.noise_memory);
    for (const auto& part : measurement.parts) start(part.type, part.pointer, part.model, part.memory);
  }
}

void Estimator::start(bool anew) {
  for (const auto& block : plan_.blocks) start_value(block, block.start(anew), x());
  std::fill(initial_P_.begin(), initial_P_.end(), 0.0);
  const MatrixView P{initial_P_.data(), plan_.n, plan_.n, plan_.n};
  for (const auto& block : plan_.blocks) start_covariance(block, anew, P);
  if (const int row = P_->set(P); row >= 0)
    throw Stop("the initial covariance is not positive semidefinite at '" + component_name(row) + "'");
  for (int i = 0; i < plan_.n; ++i) plan_.initial_variances.in(arena_)[i] = P(i, i);
  std::fill_n(plan_.stationary_variances.in(arena_), plan_.n, std::numeric_limits<double>::quiet_NaN());
}

bool Estimator::is_contradicted() {
  constexpr double surely = 5;
  std::fill(initial_P_.begin(), initial_P_.end(), 0.0);
  const MatrixView P{initial_P_.data(), plan_.n, plan_.n, plan_.n};
  for (const auto& block : plan_.blocks) {
    const InitialPlan& again = block.start(true);
    if (again.channel < 0) continue;
    const LatestPlan& witness = plan_.initial[as_size(again.channel)];
    const auto is_judged = [&](const MeasurementPlan& measurement) { return measurement.channel == witness.channel; };
    if (!witness.is_of_restart || std::ranges::any_of(plan_.measurements, is_judged)) continue;
    try {
      start_value(block, again, x_corrected_.data());
      start_covariance(block, true, P);
    } catch (const Stop&) {
      continue;  // it could not be started from
    }
    const VectorView delta(block_delta_.data(), block.dof());
    calls_.during(block, "minus", [&] { block.block->minus(block.in(x_corrected_.data()), block.in(state()), delta); });
    for (std::size_t a = 0; a < block.active.size(); ++a) {
      const int row = block.first + static_cast<int>(a);
      const double off = delta[block.active[a]];
      if (off * off > surely * surely * (P(row, row) + P_->variance(row))) return true;
    }
  }
  return false;
}

void Estimator::start_value(const BlockPlan& block, const InitialPlan& initial, double* stored) {
  const VectorView value = block.in(stored);
  if (initial.channel < 0) {
    std::copy(initial.value.begin(), initial.value.end(), value.data());
    return;
  }
  const SampleView view = plan_.initial[as_size(initial.channel)].in(arena_, channels_);
  const VectorView outputs(outputs_.data(), block.outputs());
  for (int i = 0; i < outputs.size(); ++i) outputs[i] = view.fields[initial.fields[as_size(i)]];
  const Result result = calls_.during(block, "write", [&] { return block.block->write(outputs, value); });
  if (!result) throw Stop("block '" + block.name + "' refuses its initial value: " + result.reason);
}

/// A component's own sigma, or its row of the covariance of the sample that the block's value is from.
void Estimator::start_covariance(const BlockPlan& block, bool anew, MatrixView P) {
  const InitialPlan& initial = block.start(anew);
  for (std::size_t a = 0; a < block.active.size(); ++a) {
    const auto component = as_size(block.active[a]);
    const int row = block.first + static_cast<int>(a);
    const double sigma = initial.sigma[component];
    if (std::isfinite(sigma)) {
      P(row, row) = sigma * sigma;
      continue;
    }
    const LatestPlan& kept = plan_.initial[as_size(initial.channel)];
    const SampleView view = kept.in(arena_, channels_);
    const int dof = channels_[as_size(kept.channel)].covariance_dof;
    if (!view.covariance)
      throw Stop("block '" + block.name + "' takes its initial sigma from a sample without covariance");
    for (const auto& other : plan_.blocks) {
      const InitialPlan& its = other.start(anew);
      if (its.channel != initial.channel || its.covariance.empty()) continue;
      for (std::size_t b = 0; b < other.active.size(); ++b) {
        const auto other_component = as_size(other.active[b]);
        if (std::isfinite(its.sigma[other_component])) continue;
        P(row, other.first + static_cast<int>(b)) =
            view.covariance[initial.covariance[component] + its.covariance[other_component] * dof];
      }
    }
  }
}

void Estimator::inflate(const MeasurementPlan& measurement) {
  for (const auto& inflation : measurement.inflations) P_->inflate(inflation.row, inflation.variance);
}

/// "velocity.x"
std::string Estimator::component_name(int row) const {
  for (const auto& block : plan_.blocks)
    if (row >= block.first && row < block.first + base::count_of(block.active))
      return block.name + "." + block.declaration().error[as_size(block.active[as_size(row - block.first)])].name;
  return "";
}

void Estimator::predict(Time t1) {
  if (const int row = P_->predict(phi(), noise()); row >= 0)
    throw Stop("the process noise is not positive semidefinite at '" + component_name(row) + "' at " + time_text(t1));
  if (plan_.n > 0 && std::isnan(*plan_.stationary_variances.in(arena_))) note_stationary_variances();
}

bool Estimator::is_sound() const {
  const double* const x = state();
  double sum = 0;  // of zeros, where all are finite
  for (int i = 0; i < plan_.stored_size; ++i) sum += x[i] * 0.0;
  return sum == 0.0 && P_->is_below(largest_variance);
}

void Estimator::stop_unsound(Time t, const std::string& culprit) const {
  const std::string why = culprit.empty() ? "" : ": " + culprit;
  for (const auto& block : plan_.blocks) {
    if (!is_finite(block.in(state()))) throw Stop("block '" + block.name + "' is not finite at " + time_text(t) + why);
    for (std::size_t a = 0; a < block.active.size(); ++a) {
      const int row = block.first + static_cast<int>(a);
      const double variance = P_->variance(row);
      if (variance >= 0 && variance < largest_variance) continue;
      char text[64];
      std::snprintf(text, sizeof text, " has the variance %.3g at ", variance);
      throw Stop("'" + component_name(row) + "'" + text + time_text(t) + why);
    }
  }
  throw Stop("the state is not finite at " + time_text(t) + why);
}

void Estimator::write(SampleWriter& slot, const double* x, ConstMatrixView P) {
  double* out = slot.fields;
  for (const auto& block : plan_.blocks) {
    const VectorView outputs(out, block.outputs());
    calls_.during(block, "read", [&] { block.block->read(block.in(x), outputs); });
    out += outputs.size();
  }
  slot.rows = 0;
  slot.attach_covariance().as() = P.as();
}

}  // namespace binnacle::internal::filter
