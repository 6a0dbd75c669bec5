// SPDX-License-Identifier: Apache-2.0
// One propagation: models, joint discretization, gathering of what is frozen or derived, covariance, health.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "filter/engine.hpp"

namespace binnacle {

namespace {

std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

std::string at_time(Time t) {
  char text[48];
  std::snprintf(text, sizeof text, " at %.9g s", seconds(t));
  return text;
}

}  // namespace

void Engine::step_pending(int whole) {
  auto& h = head();
  PendingInput* pending = plan_.pending.in(arena_);
  double* fields = plan_.pending_fields.in(arena_);
  const int width = plan_.input_fields;

  const auto is_fragment = [&](int i) { return pending[i].t0 != pending[i].whole_t0; };
  for (int done = 0; done < whole && !h.broken;) {
    int group = 1;
    if (!is_fragment(done))
      while (done + group < whole && group < plan_.samples_per_step && !is_fragment(done + group)) ++group;
    for (int i = 0; i < group; ++i) {
      const auto& sample = pending[done + i];
      const double fraction =
          is_fragment(done + i) ? seconds(sample.t1 - sample.t0) / seconds(sample.whole_t1 - sample.whole_t0) : 1.0;
      double* raw = sample_fields_.data() + i * width;
      for (int f = 0; f < width; ++f)
        raw[f] =
            fields[(done + i) * width + f] * (plan_.input_kinds[as_size(f)] == FieldKind::increment ? fraction : 1.0);
      samples_[as_size(i)] =
          InputSample{sample.t0, sample.t1, sample.whole_dt * fraction, sample.whole_t0, sample.whole_t1, raw};
    }
    step(pending[done + group - 1].t1, group);
    done += group;
  }
  std::copy(pending + whole, pending + h.pending, pending);
  std::copy(fields + whole * width, fields + h.pending * width, fields);
  h.pending -= whole;
}

void Engine::step_fragment(Time t1) {
  PendingInput& sample = plan_.pending.in(arena_)[0];
  const double* fields = plan_.pending_fields.in(arena_);
  const double fraction = seconds(t1 - sample.t0) / seconds(sample.whole_t1 - sample.whole_t0);
  double* raw = sample_fields_.data();
  for (int f = 0; f < plan_.input_fields; ++f)
    raw[f] = fields[f] * (plan_.input_kinds[as_size(f)] == FieldKind::increment ? fraction : 1.0);
  samples_[0] = InputSample{sample.t0, t1, sample.whole_dt * fraction, sample.whole_t0, sample.whole_t1, raw};
  sample.t0 = t1;
  step(t1, 1);
}

void Engine::remember_driving_rates(const InputSample& sample) {
  if (!(sample.dt > 0)) return;
  double* rates = plan_.driving_rates.in(arena_);
  for (int f = 0; f < plan_.input_fields; ++f)
    rates[f] = plan_.input_kinds[as_size(f)] == FieldKind::increment ? sample.fields[f] / sample.dt : sample.fields[f];
  head().driving_rates_known = 1;
}

Driving Engine::driving(const std::vector<int>& fields, double* storage) {
  Driving u;
  u.t = head().t;
  if (!fields.empty() && status().driving_rates_known) {
    const double* rates = plan_.driving_rates.in(arena_);
    for (std::size_t i = 0; i < fields.size(); ++i) storage[i] = rates[as_size(fields[i])];
    u.rates = storage;
  }
  return u;
}

Result Engine::evaluate_derived(const std::vector<int>& values, bool with_jacobians) {
  for (const int index : values) {
    const auto& derived = plan_.derived[as_size(index) - plan_.blocks.size()];
    for (std::size_t p = 0; p < derived.ports.size(); ++p)
      port_values_[p] = derived.ports[p] < 0 ? nullptr : values_[as_size(derived.ports[p])];
    const int dof = derived.dof();
    std::fill_n(jacobians_.begin(), derived.ports.size(), MatrixView{});
    for (const auto& read : derived.reads) {
      const int columns = read.value < static_cast<int>(plan_.blocks.size())
                              ? plan_.blocks[as_size(read.value)].dof()
                              : plan_.derived[as_size(read.value) - plan_.blocks.size()].dof();
      jacobians_[as_size(read.port)] = MatrixView{at(read.jacobian), dof, columns, dof};
      if (with_jacobians) std::fill_n(at(read.jacobian), dof * columns, 0.0);
    }
    calling(derived.type, "evaluate");
    DerivedOutput out{{at(derived.value), derived.derived->declaration().stored_size},
                      with_jacobians ? PortJacobians(jacobians_.data()) : PortJacobians()};
    const Result result = derived.derived->evaluate(
        DerivedInput{port_values_.data(), driving(derived.driving_rates, driving_rate_fields_.data())}, out);
    if (!result) return result;
    if (!with_jacobians) continue;

    for (const auto& dependence : derived.dependences)
      std::fill_n(at(dependence.jacobian), dof * plan_.blocks[as_size(dependence.block)].dof(), 0.0);
    for (const auto& read : derived.reads) {
      const double* J = at(read.jacobian);
      const bool is_block = read.value < static_cast<int>(plan_.blocks.size());
      for (const auto& dependence : derived.dependences) {
        const int columns = plan_.blocks[as_size(dependence.block)].dof();
        double* total = at(dependence.jacobian);
        if (is_block) {
          if (read.value != dependence.block) continue;
          for (int i = 0; i < dof * columns; ++i) total[i] += J[i];
          continue;
        }
        const auto& inner = plan_.derived[as_size(read.value) - plan_.blocks.size()];
        for (const auto& through : inner.dependences) {
          if (through.block != dependence.block) continue;
          const double* chain = at(through.jacobian);
          const int inner_dof = inner.dof();
          for (int c = 0; c < columns; ++c)
            for (int k = 0; k < inner_dof; ++k)
              for (int r = 0; r < dof; ++r) total[r + c * dof] += J[r + k * dof] * chain[k + c * inner_dof];
        }
      }
    }
  }
  return Result::ok();
}

bool Engine::propagate_models(Time t0, Time t1, int samples) {
  for (const auto& process : plan_.processes) {
    double dt = seconds(t1 - t0);
    std::span<const InputSample> model_samples;
    if (process.uses_input) {
      const auto width = process.fields.epoch.size();
      dt = 0;
      for (int i = 0; i < samples; ++i) {
        SampleView raw;
        raw.fields = samples_[as_size(i)].fields;
        double* converted = model_fields_.data() + as_size(i) * width;
        read_fields(process.fields, raw, samples_[as_size(i)].dt, converted);
        model_samples_[as_size(i)] = samples_[as_size(i)];
        model_samples_[as_size(i)].fields = converted;
        dt += samples_[as_size(i)].dt;
      }
      model_samples = {model_samples_.data(), as_size(samples)};
    }
    for (std::size_t p = 0; p < process.ports.size(); ++p) {
      const int value = process.ports[p];
      port_values_[p] = value < 0 ? nullptr : values_[as_size(value)];
      const bool is_advanced = value >= 0 && value < static_cast<int>(plan_.blocks.size()) &&
                               &plan_.processes[as_size(plan_.blocks[as_size(value)].process)] == &process;
      port_outputs_[p] = !is_advanced ? nullptr : x_plus_.data() + plan_.blocks[as_size(value)].stored_offset;
    }
    calling(process.type, process.van_loan_group >= 0 ? "linearized" : "propagate");
    if (process.van_loan_group >= 0) {
      ContinuousOutput out{phi_.data() + process.first_transition, noise_.data() + process.first_noise};
      process.model->linearized(ContinuousInput{port_values_.data()}, out);
      continue;
    }
    ProcessOutput out{port_outputs_.data(), phi_.data() + process.first_transition,
                      noise_.data() + process.first_noise};
    const Result result =
        process.model->propagate(ProcessInput{Step{t0, t1, dt, model_samples},
                                              port_values_.data(),
                                              {},
                                              process.memory.count > 0 ? process.memory.in(arena_) : nullptr,
                                              {}},
                                 out);
    if (!result) {
      fail("process '" + process.name + "' cannot go on" + at_time(t1) + ": " + result.reason);
      return false;
    }
  }
  for (const auto& group : plan_.van_loan) run_van_loan(group, seconds(t1 - t0));
  return true;
}

void Engine::run_van_loan(const VanLoanGroup& group, double dt) {
  const auto n = as_size(group.columns);
  double* const F = at(group.work);
  double* const Q = F + n * n;
  double* const Phi = Q + n * n;
  double* const Qd = Phi + n * n;
  double* const work = Qd + n * n;
  const auto spread = [&](const std::vector<VanLoanGroup::Block>& blocks, const std::vector<double*>& table,
                          double* matrix, bool mirrored) {
    std::fill_n(matrix, n * n, 0.0);
    for (const auto& block : blocks) {
      const double* from = table[as_size(block.table)];
      for (int j = 0; j < block.columns; ++j)
        for (int i = 0; i < block.rows; ++i) {
          if (block.structure == Structure::diagonal && i != j) continue;
          const double value = block.structure == Structure::diagonal ? from[i] : from[i + j * block.rows];
          matrix[as_size(block.row + i) + as_size(block.column + j) * n] = value;
          if (mirrored) matrix[as_size(block.column + j) + as_size(block.row + i) * n] = value;
        }
    }
  };
  spread(group.dynamics, phi_, F, false);
  spread(group.noise, noise_, Q, true);
  // What is frozen is taken as known: its noise must not reach others through the coupling.
  for (const auto& part : group.advanced) {
    const auto& use = plan_.blocks[as_size(part.value)].use;
    for (int i = 0; i < part.dof; ++i) {
      if (use[as_size(i)] != Use::frozen) continue;
      const auto row = as_size(part.first + i);
      for (std::size_t j = 0; j < n; ++j) Q[row + j * n] = Q[j + row * n] = 0;
    }
  }
  discretize(F, Q, group.columns, dt, Phi, Qd, work);

  const auto collect = [&](const std::vector<VanLoanGroup::Block>& blocks, const std::vector<double*>& table,
                           const double* matrix) {
    for (const auto& block : blocks) {
      double* to = table[as_size(block.table)];
      for (int j = 0; j < block.columns; ++j)
        for (int i = 0; i < block.rows; ++i)
          to[i + j * block.rows] = matrix[as_size(block.row + i) + as_size(block.column + j) * n];
    }
  };
  collect(group.phi, phi_, Phi);
  collect(group.qd, noise_, Qd);

  for (const auto& part : group.advanced) {
    double* out = x_plus_.data() + plan_.blocks[as_size(part.value)].stored_offset;
    std::fill_n(out, part.dof, 0.0);
    for (const auto* inputs : {&group.advanced, &group.read})
      for (const auto& input : *inputs) {
        const double* in = values_[as_size(input.value)];
        for (int j = 0; j < input.dof; ++j)
          for (int i = 0; i < part.dof; ++i)
            out[i] += Phi[as_size(part.first + i) + as_size(input.first + j) * n] * in[j];
      }
  }
}

void Engine::gather(const std::vector<GatherPlan>& plans, const std::vector<double*>& table) {
  for (const auto& plan : plans) {
    const auto& to = plan_.blocks[as_size(plan.to_block)];
    const auto& from = plan_.blocks[as_size(plan.from_block)];
    const int rows = static_cast<int>(to.active.size());
    const int columns = static_cast<int>(from.active.size());
    const int dof = to.dof();
    double* target = at(plan.target);
    std::fill_n(target, rows * columns, 0.0);
    for (const auto& term : plan.terms) {
      const double* block = table[as_size(term.source)];
      for (int c = 0; c < columns; ++c) {
        const int column = from.active[as_size(c)];
        for (int r = 0; r < rows; ++r) {
          const int row = to.active[as_size(r)];
          double value = 0;
          if (term.derived < 0) {
            value =
                term.structure == Structure::diagonal ? (row == column ? block[row] : 0.0) : block[row + column * dof];
          } else {
            const int inner = plan_.derived[as_size(term.derived) - plan_.blocks.size()].dof();
            const double* chain = at(term.chain) + column * inner;
            if (term.structure == Structure::diagonal) {
              value = block[row] * chain[row];
            } else {
              for (int k = 0; k < inner; ++k) value += block[row + k * dof] * chain[k];
            }
          }
          target[r + c * rows] += value;
        }
      }
    }
  }
}

void Engine::hold_frozen() {
  for (const auto& block : plan_.blocks) {
    if (!block.holds_frozen) continue;
    double* next = x_plus_.data() + block.stored_offset;
    const double* now = x() + block.stored_offset;
    if (block.active.empty()) {
      std::copy_n(now, block.declaration().stored_size, next);
      continue;
    }
    block.block->minus(next, now, block_delta_.data());
    for (int i = 0; i < block.dof(); ++i)
      if (block.use[as_size(i)] == Use::frozen) block_delta_[as_size(i)] = 0;
    block.block->plus(now, block_delta_.data(), next);
  }
}

void Engine::step(Time t1, int samples) {
  auto& h = head();
  const Time t0 = h.t;
  if (!plan_.process_derived.empty()) {
    const Result result = evaluate_derived(plan_.process_derived, true);
    if (!result) {
      fail(std::string("a derived block cannot be evaluated") + at_time(t0) + ": " + result.reason);
      return;
    }
  }
  if (!propagate_models(t0, t1, samples)) return;
  hold_frozen();
  gather(plan_.gathers, phi_);
  gather(plan_.noise_gathers, noise_);

  const bool records = observer_ && observer_->wants_matrices();
  const auto p_size = as_size(padded(plan_.n)) * as_size(plan_.n);
  const bool keeps_P = records || (observer_ && observer_->wants_covariance());
  if (keeps_P) std::copy_n(P(), p_size, P_before_.data());
  predict(plan_.transition, phi_.data(), noise_.data(), P(), predict_scratch_.data());

  if (observer_) {
    StepRecord record;
    record.t0 = t0;
    record.t1 = t1;
    record.x0 = x();
    record.x1 = x_plus_.data();
    if (keeps_P) {
      record.P0 = {P_before_.data(), plan_.n, plan_.n, padded(plan_.n)};
      record.P1 = covariance();
    }
    if (records) {
      std::fill(Phi_dense_.begin(), Phi_dense_.end(), 0.0);
      for (int i = 0; i < plan_.n; ++i) Phi_dense_[as_size(i + i * plan_.n)] = 1;
      for (const auto& diagonal : plan_.transition.diagonals)
        Phi_dense_[as_size(diagonal.row + diagonal.row * plan_.n)] = phi_[as_size(diagonal.block)][diagonal.offset];
      for (const auto& group : plan_.transition.groups)
        for (int r = 0; r < group.rows; ++r) {
          Phi_dense_[as_size((group.first_row + r) * (plan_.n + 1))] = 0;
          for (const auto& column : group.columns)
            Phi_dense_[as_size(group.first_row + r + column.column * plan_.n)] =
                phi_[as_size(column.block)][column.offset + r];
        }
      record.Phi = {Phi_dense_.data(), plan_.n, plan_.n, plan_.n};
    }
    observer_->stepped(record);
  }
  std::copy_n(x_plus_.data(), plan_.stored_size, x());
  h.t = t1;
  ++h.steps;
  if (samples > 0) remember_driving_rates(samples_[as_size(samples - 1)]);
  check_health();
}

void Engine::check_health() {
  constexpr double bound = 1e30;
  bool is_sound = true;
  double sum = 0;
  for (int i = 0; i < plan_.stored_size; ++i) sum += x()[i] * 0.0;  // NaN if anything is not finite
  is_sound = sum == 0.0;
  const double* diagonal = P();
  const int step = padded(plan_.n) + 1;
  for (int i = 0; i < plan_.n; ++i) is_sound = is_sound && diagonal[i * step] >= 0 && diagonal[i * step] < bound;
  if (is_sound) return;

  for (const auto& block : plan_.blocks) {
    const double* value = x() + block.stored_offset;
    for (int i = 0; i < block.declaration().stored_size; ++i)
      if (!std::isfinite(value[i])) {
        fail("block '" + block.name + "' is not finite" + at_time(head().t));
        return;
      }
    for (std::size_t a = 0; a < block.active.size(); ++a) {
      const double variance = diagonal[(block.first + static_cast<int>(a)) * step];
      if (variance >= 0 && variance < bound) continue;
      char text[64];
      std::snprintf(text, sizeof text, " has the variance %.3g", variance);
      fail("'" + block.name + "." + block.declaration().error[as_size(block.active[a])].name + "'" + text +
           at_time(head().t));
      return;
    }
  }
}

}  // namespace binnacle
