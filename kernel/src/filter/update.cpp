// SPDX-License-Identifier: Apache-2.0
// One measurement: linearization, trust, gate, correction, and the ledger of what became of it.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "filter/engine.hpp"

namespace binnacle {

namespace {

std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

Outcome outcome_of(Refusal refusal) {
  switch (refusal) {
    case Refusal::unsupported: return Outcome::unsupported;
    case Refusal::invalid: return Outcome::invalid;
    default: return Outcome::rejected;
  }
}

/// Writes for each row of a part which group it is of, counted through all parts; returns the next part's first group.
int name_groups(const std::vector<ResidualGroup>& groups, int first_group, int rows, int* row_groups) {
  int group = 0;
  for (int i = 0; i < rows; ++i) {
    while (as_size(group) + 1 < groups.size() && groups[as_size(group) + 1].first_row <= i) ++group;
    row_groups[i] = first_group + group;
  }
  return first_group + std::max(1, static_cast<int>(groups.size()));
}

}  // namespace

bool Engine::is_withheld(const MeasurementPlan& plan, Time t) const {
  if (plan.withhold_every > 0 && plan.ledger.in(arena_)->reached % plan.withhold_every == 0) return true;
  return std::any_of(plan.withheld.begin(), plan.withheld.end(),
                     [&](const TimeSpan& window) { return window.contains(t, status().start); });
}

Result Engine::linearize(const MeasurementPlan& plan, const SampleView& sample, int& rows) {
  const auto& channel = channels_[as_size(plan.channel)];
  const double dt = sample.t0 == no_time ? 0.0 : seconds(sample.t - sample.t0);
  const int m_max = plan.max_rows;
  rows = 0;
  int first_group = 0;
  std::fill_n(work_.H, as_size(m_max) * plan.columns.columns.size(), 0.0);
  std::fill_n(R_nominal_.data(), m_max * m_max, 0.0);

  for (const auto& part : plan.parts) {
    SampleView seen = sample;
    seen.available = true;
    const int missing = read_fields(part.fields, sample, dt, gathered_.data());
    if (missing >= 0) return Result::invalid("a required field is not a number");
    if (!part.fields.row.empty()) read_row_fields(part.fields, channel, sample, gathered_rows_.data());
    seen.fields = gathered_.data();
    seen.row_fields = gathered_rows_.data();

    double* auxiliary = auxiliary_fields_.data();
    for (std::size_t i = 0; i < part.auxiliary.size(); ++i) {
      auxiliary_views_[i] = SampleView{};
      if (part.auxiliary[i] < 0) continue;
      const auto& kept = plan_.auxiliary[as_size(part.auxiliary[i])];
      const SampleView raw = latest(kept);
      SampleView& view = auxiliary_views_[i];
      view = raw;
      view.fields = auxiliary;
      read_fields(part.auxiliary_fields[i], raw, raw.t0 == no_time ? 0.0 : seconds(raw.t - raw.t0), auxiliary);
      auxiliary += part.auxiliary_fields[i].epoch.size();
      view.row_fields = auxiliary;
      read_row_fields(part.auxiliary_fields[i], channels_[as_size(kept.channel)], raw, auxiliary);
      auxiliary += part.auxiliary_fields[i].row.size() * as_size(raw.rows);
    }

    for (std::size_t p = 0; p < part.ports.size(); ++p)
      port_values_[p] = part.ports[p] < 0 ? nullptr : values_[as_size(part.ports[p])];
    const int part_rows = part.model->declaration().max_rows;
    std::fill_n(jacobians_.begin(), part.ports.size(), MatrixView{});
    for (const auto& read : part.reads) {
      jacobians_[as_size(read.port)] = MatrixView{at(read.jacobian), part_rows, read.dof, part_rows};
      std::fill_n(at(read.jacobian), part_rows * read.dof, 0.0);
    }
    for (int i = 0; i < part_rows; ++i) row_keys_[as_size(rows + i)] = i;

    MeasurementOutput out;
    out.residual = {work_.r + rows, part_rows};
    out.H = jacobians_.data();
    out.R = MatrixView{R_nominal_.data() + rows + rows * m_max, part_rows, part_rows, m_max};
    out.row_keys = {row_keys_.data() + rows, as_size(part_rows)};
    calling(part.type, "linearize");
    const MeasurementInput in{seen,
                              auxiliary_views_.data(),
                              port_values_.data(),
                              driving(part.driving_rates, driving_rate_fields_.data()),
                              part.memory.count > 0 ? part.memory.in(arena_) : nullptr,
                              {},
                              {}};
    const Result result = part.model->linearize(in, out);
    if (!result) return result;
    if (out.rows < 0 || out.rows > part_rows) return Result::failed("the model wrote more rows than it declared");
    for (int j = 0; j < part_rows; ++j)  // what a model wrote beyond its rows is not the next part's
      for (int i = 0; i < part_rows; ++i)
        if (i >= out.rows || j >= out.rows) out.R(i, j) = 0;
    assemble(part, rows, out.rows);
    first_group = name_groups(part.model->declaration().groups, first_group, out.rows, row_groups_.data() + rows);
    rows += out.rows;
  }
  if (rows == 0) return Result::unsupported("no rows");

  double sum = 0;  // NaN if anything is not finite
  for (int i = 0; i < rows; ++i) sum += work_.r[i] * 0.0;
  for (std::size_t c = 0; c < plan.columns.columns.size(); ++c)
    for (int i = 0; i < rows; ++i) sum += work_.H[as_size(i) + c * as_size(m_max)] * 0.0;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < rows; ++i) sum += R_nominal_[as_size(i + j * m_max)] * 0.0;
  if (sum != 0.0) return Result::invalid("the residual, its Jacobian or its noise is not finite");
  return Result::ok();
}

void Engine::assemble(const PartPlan& part, int first_row, int rows) {
  const int m_max = work_.m_max;
  const int stride = part.model->declaration().max_rows;
  for (const auto& read : part.reads) {
    const double* J = at(read.jacobian);
    for (const auto& target : read.targets) {
      const auto& active = plan_.blocks[as_size(target.block)].active;
      for (std::size_t a = 0; a < active.size(); ++a) {
        double* H = work_.H + first_row + (as_size(target.first_column) + a) * as_size(m_max);
        if (target.is_direct) {
          const double* column = J + active[a] * stride;
          for (int i = 0; i < rows; ++i) H[i] += column[i];
        } else {
          const double* chain = at(target.chain) + active[a] * read.dof;
          for (int k = 0; k < read.dof; ++k)
            for (int i = 0; i < rows; ++i) H[i] += J[i + k * stride] * chain[k];
        }
      }
    }
  }
}

void Engine::process(int measurement, const SampleView& sample) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  Ledger& ledger = *plan.ledger.in(arena_);
  ++ledger.reached;
  in_process_ = measurement;
  left_out_ = 0;
  work_.m_max = plan.max_rows;

  std::byte* const backup = memory_backup_.data();
  std::size_t kept = 0;
  for (const auto& part : plan.parts) {
    if (part.memory.count > 0) std::memcpy(backup + kept, part.memory.in(arena_), part.memory.count);
    kept += part.memory.count;
  }
  const auto roll_back_models = [&] {
    std::size_t offset = 0;
    for (const auto& part : plan.parts) {
      if (part.memory.count > 0) std::memcpy(part.memory.in(arena_), backup + offset, part.memory.count);
      offset += part.memory.count;
    }
  };

  int m = 0;
  Result result = evaluate_derived(plan.derived, true);
  if (result) result = linearize(plan, sample, m);
  if (!result) {
    roll_back_models();
    conclude(measurement, sample.t, outcome_of(result.refusal), result.reason, 0, 0, false, nullptr);
    return;
  }
  project(plan.columns, P(), plan_.n, m, work_);

  const bool withheld = is_withheld(plan, sample.t);
  std::byte* const noise_memory = plan.noise_memory.count > 0 ? plan.noise_memory.in(arena_) : nullptr;
  std::byte* const noise_backup = backup + plan.memory_bytes;
  if (noise_memory) std::memcpy(noise_backup, noise_memory, plan.noise_memory.count);
  const auto roll_back_noise = [&] {
    if (noise_memory) std::memcpy(noise_memory, noise_backup, plan.noise_memory.count);
  };
  double nis = 0, nis_offered = 0;
  const auto end_gated = [&](const char* reason) {
    roll_back_models();
    if (!plan.learn_from_gated) roll_back_noise();
    conclude(measurement, sample.t, Outcome::gated, reason, m, nis_offered, true, nullptr);
    recover(plan);
  };

  for (const int offered = m;;) {
    for (int j = 0; j < m; ++j) std::copy_n(R_nominal_.data() + j * work_.m_max, m, work_.R + j * work_.m_max);
    if (plan.noise && !withheld) estimate_noise(plan, sample.t, m);
    if (!factor_innovation(m, work_)) {
      roll_back_models();
      roll_back_noise();
      conclude(measurement, sample.t, Outcome::rejected, "H P H' + R is not positive definite", 0, 0, false, nullptr);
      return;
    }
    nis = normalized_innovation_squared(m, work_);
    if (left_out_ == 0) nis_offered = nis;
    if (withheld || plan.gate_unit == GateUnit::sample) break;
    const unsigned char* outliers = outlier_test_.find(plan.gate_unit, plan.gate_limit, m, row_keys_.data(), work_);
    if (!outliers) break;
    for (int i = 0; i < m; ++i) {
      if (!outliers[i]) continue;
      left_out_groups_[as_size(left_out_)] = plan.gate_unit == GateUnit::key ? 0 : row_groups_[as_size(i)];
      left_out_keys_[as_size(left_out_++)] = row_keys_[as_size(i)];
    }
    if (2 * left_out_ > offered) return end_gated("no majority of its rows agrees with the rest");
    roll_back_noise();
    m = leave_out(outliers, m, static_cast<int>(plan.columns.columns.size()), plan_.n, R_nominal_.data(),
                  row_keys_.data(), row_groups_.data(), work_);
  }
  if (withheld) {
    roll_back_models();
    conclude(measurement, sample.t, Outcome::withheld, "", m, nis, true, nullptr);
    return;
  }
  if (plan.gate > 0 && plan.gate_unit == GateUnit::sample && nis > plan.gate_limit[as_size(m)])
    return end_gated("NIS beyond the gate");

  const bool records = observer_ && observer_->wants_matrices();
  if (observer_) std::copy_n(x(), plan_.stored_size, x_before_.data());
  if (records) std::copy_n(P(), as_size(padded(plan_.n)) * as_size(plan_.n), P_before_.data());

  correct(plan_.corrected.empty() ? nullptr : plan_.corrected.data(), P(), plan_.n, m, work_);
  gain_times_residual(plan_.n, m, work_, delta_.data());
  if (plan.noise && plan.noise->wants_after()) {
    // Post-fit residual to first order: r − H δ. G and HPHt are made anew with P⁺ and no longer those of the update.
    for (int i = 0; i < m; ++i) {
      double predicted = 0;
      for (std::size_t c = 0; c < plan.columns.columns.size(); ++c)
        predicted += work_.H[as_size(i) + c * as_size(work_.m_max)] * delta_[as_size(plan.columns.columns[c])];
      post_fit_[as_size(i)] = work_.r[i] - predicted;
    }
    project(plan.columns, P(), plan_.n, m, work_);
    calling(plan.noise_type, "after");
    plan.noise->after(Outcome::accepted, post_fit_.data(), MatrixView{work_.HPHt, m, m, work_.m_max}, noise_memory);
  }
  inject(delta_.data());
  ledger.consecutive_gated = 0;
  count_left_out(plan);
  ledger.last_accepted = sample.t;
  conclude(measurement, sample.t, Outcome::accepted, "", m, nis, true, delta_.data());
  check_health();
}

void Engine::estimate_noise(const MeasurementPlan& plan, Time t, int rows) {
  const Ledger& ledger = *plan.ledger.in(arena_);
  Innovation innovation;
  innovation.t = t;
  innovation.dt = ledger.last_accepted == no_time ? 0.0 : seconds(t - ledger.last_accepted);
  innovation.rows = rows;
  innovation.row_keys = {row_keys_.data(), as_size(rows)};
  innovation.row_groups = {row_groups_.data(), as_size(rows)};
  innovation.residual = work_.r;
  innovation.HPHt = MatrixView{work_.HPHt, rows, rows, work_.m_max};
  innovation.R_nominal = MatrixView{R_nominal_.data(), rows, rows, work_.m_max};
  calling(plan.noise_type, "estimate");
  plan.noise->estimate(innovation, plan.noise_memory.count > 0 ? plan.noise_memory.in(arena_) : nullptr,
                       MatrixView{work_.R, rows, rows, work_.m_max});
}

/// A sample was gated: after enough of them in a row the filter is reopened.
void Engine::recover(const MeasurementPlan& plan) {
  Ledger& ledger = *plan.ledger.in(arena_);
  ++ledger.consecutive_gated;
  if (plan.recover_after == 0 || ledger.consecutive_gated < plan.recover_after) return;
  const int ld = padded(plan_.n);
  for (const auto& inflation : plan.inflations) P()[inflation.row + inflation.row * ld] += inflation.variance;
  ledger.consecutive_gated = 0;
  ++ledger.recoveries;
}

void Engine::count_left_out(const MeasurementPlan& plan) {
  plan.ledger.in(arena_)->rows_left_out += left_out_;
  LeftOut* const table = plan.left_out.in(arena_);
  for (int i = 0; i < left_out_; ++i) {
    const std::int64_t key = left_out_keys_[as_size(i)], group = left_out_groups_[as_size(i)];
    for (std::size_t k = 0; k < plan.left_out.count; ++k) {
      if (table[k].count > 0 && (table[k].key != key || table[k].group != group)) continue;
      table[k] = {key, group, table[k].count + 1};
      break;
    }
  }
}

void Engine::inject(double* delta) {
  for (const auto& block : plan_.blocks) {
    if (block.active.empty()) continue;
    const int dof = block.dof();
    std::fill_n(block_delta_.data(), dof, 0.0);
    for (std::size_t a = 0; a < block.active.size(); ++a)
      block_delta_[as_size(block.active[a])] = delta[as_size(block.first) + a];
    double* value = x() + block.stored_offset;
    calling(block.type, "plus");
    block.block->plus(value, block_delta_.data(), value);
    double* reset = block_reset_.data();
    calling(block.type, "reset_jacobian");
    if (!block.block->reset_jacobian(block_delta_.data(), reset)) continue;
    const int active = static_cast<int>(block.active.size());
    double* compact = reset;
    if (!block.is_whole()) {
      compact = reset + dof * dof;
      for (int c = 0; c < active; ++c)
        for (int r = 0; r < active; ++r)
          compact[r + c * active] = reset[block.active[as_size(r)] + block.active[as_size(c)] * dof];
    }
    transform_block(compact, block.first, active, P(), plan_.n, reset_scratch_.data());
  }
}

/// For the step observer: H over all rows of P, not only over those of the blocks that are touched.
MatrixView Engine::dense_H(const MeasurementPlan& plan, int rows) {
  std::fill_n(H_dense_.data(), as_size(rows) * as_size(plan_.n), 0.0);
  for (std::size_t c = 0; c < plan.columns.columns.size(); ++c)
    std::copy_n(work_.H + c * as_size(work_.m_max), rows, H_dense_.data() + as_size(plan.columns.columns[c] * rows));
  return {H_dense_.data(), rows, plan_.n, rows};
}

void Engine::conclude(int measurement, Time t, Outcome outcome, const char* reason, int rows, double nis,
                      bool linearized, const double* delta) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  Ledger& ledger = *plan.ledger.in(arena_);
  ++ledger.outcomes[static_cast<int>(outcome)];
  in_process_ = -1;
  if (outcome == Outcome::accepted) {
    ledger.nis_sum += nis;
    ++ledger.nis_count;
    ledger.dof_sum += rows;
  } else if (reason[0] != '\0') {
    std::strncpy(ledger.last_reason, reason, sizeof ledger.last_reason - 1);
  }
  if (!observer_) return;
  UpdateRecord record;
  record.measurement = measurement;
  record.t = t;
  record.outcome = outcome;
  record.reason = reason;
  record.x0 = x();
  if (linearized) {
    record.rows = rows;
    record.row_keys = row_keys_.data();
    record.row_groups = row_groups_.data();
    record.left_out = left_out_;
    record.left_out_keys = left_out_keys_.data();
    record.residual = work_.r;
    record.nis = nis;
    record.S = MatrixView{work_.S, rows, rows, work_.m_max};
    record.R = MatrixView{work_.R, rows, rows, work_.m_max};
    if (observer_->wants_matrices()) record.H = dense_H(plan, rows);
  }
  if (outcome == Outcome::accepted) {
    record.delta = delta;
    record.x0 = x_before_.data();
    record.x1 = x();
    if (observer_->wants_matrices()) {
      record.P0 = {P_before_.data(), plan_.n, plan_.n, padded(plan_.n)};
      record.P1 = covariance();
    }
  }
  observer_->offered(record);
}

}  // namespace binnacle
