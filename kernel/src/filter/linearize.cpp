// SPDX-License-Identifier: Apache-2.0
// From a sample to r, H and nominal R: what models read, and the parts of a measurement, one after the other.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "filter/estimator.hpp"

namespace binnacle::internal::filter {

namespace {

/// Writes for each row of a part which group it is of, counted through all parts; returns the next part's first group.
int name_groups(const std::vector<ResidualGroup>& groups, int first_group, int rows, int* row_groups) {
  int group = 0;
  for (int i = 0; i < rows; ++i) {
    while (as_size(group) + 1 < groups.size() && groups[as_size(group) + 1].first_row <= i) ++group;
    row_groups[i] = first_group + group;
  }
  return first_group + std::max(1, static_cast<int>(groups.size()));
}

/// C += A B.
void add_product(ConstMatrixView A, ConstMatrixView B, MatrixView C) {
  for (int j = 0; j < C.cols; ++j)
    for (int k = 0; k < A.cols; ++k)
      for (int i = 0; i < C.rows; ++i) C(i, j) += A(i, k) * B(k, j);
}

}  // namespace

/// The ports of a model: null where one is open.
const double* const* Estimator::values_of(const std::vector<int>& ports) {
  for (std::size_t p = 0; p < ports.size(); ++p) port_values_[p] = ports[p] < 0 ? nullptr : values_[as_size(ports[p])];
  return port_values_.data();
}

/// What a component that reads these driving rates may know.
Driving Estimator::driving(const Driving& now, const std::vector<int>& driving_rates) {
  for (std::size_t i = 0; i < driving_rates.size() && now.rates; ++i)
    driving_rates_[i] = now.rates.data()[driving_rates[i]];
  return {now.t, driving_rates.empty() || !now.rates ? nullptr : driving_rates_.data(), now.bridges};
}

/// The latest samples of a model's auxiliary channels as it declared their fields, good until the next call; null for a
/// model without any.
const SampleView* Estimator::auxiliary(const AuxiliaryPlan& model) {
  if (model.channels.empty()) return nullptr;
  double* fields = auxiliary_fields_.data();
  for (std::size_t i = 0; i < model.channels.size(); ++i) {
    auxiliary_samples_[i] = SampleView{};
    if (model.channels[i] < 0) continue;
    const auto& kept = plan_.auxiliary[as_size(model.channels[i])];
    const auto& channel = channels_[as_size(kept.channel)];
    auxiliary_samples_[i] = convert(model.fields[i], channel, kept.in(arena_, channels_), fields);
    fields += model.fields[i].doubles(channel.declaration.max_rows);
  }
  return auxiliary_samples_.data();
}

/// By port: a Jacobian of so many rows for what the component reads, zeroed; null for its other ports.
template <class Component>
const MatrixView* Estimator::zeroed_jacobians(const Component& component, int rows) {
  std::fill_n(jacobians_.begin(), component.ports.size(), MatrixView{});
  for (const auto& read : component.reads) {
    const MatrixView J = jacobians_[as_size(read.port)] = {at(read.jacobian), rows, plan_.dof(read.value), rows};
    std::fill_n(J.data, J.rows * J.cols, 0.0);
  }
  return jacobians_.data();
}

/// Derived blocks: evaluates the values, given in order of dependence, where they are wanted with their Jacobians chained
/// to the state blocks; ends with the first refusal.
Result Estimator::evaluate_derived(const std::vector<int>& values, const Driving& now, Jacobians wanted) {
  for (const int index : values) {
    const auto& derived = plan_.derived_at(index);
    const auto& declared = derived.derived->declaration();
    DerivedOutput out{{at(derived.value), declared.stored_size},
                      wanted == Jacobians::wanted ? zeroed_jacobians(derived, declared.dof()) : nullptr};
    const DerivedInput in{values_of(derived.ports), driving(now, derived.driving_rates), calls_.notes()};
    const Result result = calls_.during(derived, "evaluate", [&] { return derived.derived->evaluate(in, out); });
    if (!result) return result;
    if (wanted == Jacobians::wanted) chain(derived);
  }
  return Result::ok();
}

/// Its Jacobians with respect to the state blocks.
void Estimator::chain(const DerivedPlan& derived) {
  const int dof = derived.dof();
  for (const auto& dependence : derived.dependences) {
    const MatrixView total{at(dependence.jacobian), dof, plan_.dof(dependence.block), dof};
    total.as().setZero();
    for (const auto& read : derived.reads) {
      const MatrixView J{at(read.jacobian), dof, plan_.dof(read.value), dof};
      if (read.value == dependence.block) total.as() += J.as();
      if (plan_.is_block(read.value)) continue;
      for (const auto& through : plan_.derived_at(read.value).dependences)
        if (through.block == dependence.block)
          add_product(J, {at(through.jacobian), J.cols, total.cols, J.cols}, total);
    }
  }
}

Result Estimator::linearize(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now,
                            bool is_plain) {
  std::copy_n(measurement.memory.in(arena_), measurement.memory.count, memory_backup_.data());
  was_linearized_instead_ = false;
  const Result result = run_parts(rows_, measurement, sample, now, Jacobians::wanted);
  if (!result || is_plain || measurement.update.type != UpdatePlan::Type::unscented) return result;
  return regress(measurement, sample, now);
}

/// The parts of a measurement, one after the other, where values_ lie.
Result Estimator::run_parts(SampleRows& rows, const MeasurementPlan& measurement, const SampleView& sample,
                            const Driving& now, Jacobians wanted) {
  rows.begin(measurement);
  const Result derived = evaluate_derived(measurement.derived, now, wanted);
  if (!derived) return derived;
  int first_group = 0;
  for (const auto& part : measurement.parts) {
    int part_rows = 0;
    const Result result = run_part(rows, part, sample, channels_[as_size(measurement.channel)], now, wanted, part_rows);
    if (!result) return result;
    if (wanted == Jacobians::wanted) assemble(rows, part, part_rows);
    first_group = name_groups(part.model->declaration().groups, first_group, part_rows, rows.groups.data() + rows.m);
    rows.m += part_rows;
  }
  if (rows.m == 0) return Result::unsupported("no rows");
  const int columns = static_cast<int>(measurement.columns.size());
  if (!is_finite(ConstVectorView(rows.r, rows.m)) || !is_finite(ConstMatrixView{rows.H, rows.m, columns, rows.m_max}))
    return Result::invalid("the residual or its Jacobian is not finite");
  return Result::ok();
}

void Estimator::roll_back(const MeasurementPlan& measurement) {
  std::copy_n(memory_backup_.data(), measurement.memory.count, measurement.memory.in(arena_));
}

Result Estimator::run_part(SampleRows& rows, const PartPlan& part, const SampleView& sample, const ChannelPlan& channel,
                           const Driving& now, Jacobians wanted, int& part_rows) {
  const auto noted = [&](const Result& result) {
    if (result.refusal != Refusal::invalid) return result;
    char text[sizeof KeptNote::text];
    std::snprintf(text, sizeof text, "invalid sample of '%s': %s", channel.name.c_str(), result.reason);
    if (!calls_.is_muted) calls_.note_book.keep(part.type, part.pointer, "linearize", calls_.time(), text);
    return result;
  };
  for (const auto& item : part.fields.epoch)
    if (item.required && (item.index < 0 || !std::isfinite(sample.fields[item.index])))
      return noted(Result::invalid("a required field is not a number"));
  SampleView seen = convert(part.fields, channel, sample, fields_.data());
  seen.available = true;

  const int most = part.model->declaration().max_rows, m = rows.m;
  std::iota(rows.keys.begin() + m, rows.keys.begin() + m + most, 0);
  MeasurementOutput out;
  out.residual = {rows.r + m, most};
  out.H = wanted == Jacobians::wanted ? zeroed_jacobians(part, most) : nullptr;
  out.R = MatrixView{rows.R_nominal.data() + m + m * rows.m_max, most, most, rows.m_max};
  out.row_keys = {rows.keys.data() + m, as_size(most)};
  const MeasurementInput in{seen,
                            auxiliary(part.auxiliary),
                            values_of(part.ports),
                            driving(now, part.driving_rates),
                            memory_of(part.memory),
                            covariance_of(part),
                            calls_.notes()};
  const Result result = calls_.during(part, "linearize", [&] { return part.model->linearize(in, out); });
  if (!result) return noted(result);
  if (out.rows < 0) return Result::failed("the model reports a negative number of rows");
  if (out.rows > most) return Result::failed("the model wrote more rows than it declared");
  part_rows = out.rows;
  // What a model wrote beyond its rows is not the next part's.
  for (int j = 0; j < most && part_rows < most; ++j)
    for (int i = j < part_rows ? part_rows : 0; i < most; ++i) out.R(i, j) = 0;
  const MatrixView R = out.R.block(0, 0, part_rows, part_rows);
  // It may come from the sample, as a residual does.
  if (!is_finite(R)) return noted(Result::invalid("the noise of the residual is not finite"));
  if (const std::string flaw = flaw_of_noise(R); !flaw.empty())
    throw Stop(call_text(part, "linearize", calls_.time()) + " gave " + flaw);
  return result;
}

void Estimator::assemble(SampleRows& rows, const PartPlan& part, int part_rows) {
  const int stride = part.model->declaration().max_rows;
  for (const auto& read : part.reads) {
    const MatrixView J{at(read.jacobian), part_rows, read.dof, stride};
    for (const auto& target : read.targets) {
      const auto& active = plan_.blocks[as_size(target.block)].active;
      for (std::size_t a = 0; a < active.size(); ++a) {
        double* const column = rows.H + rows.m + (as_size(target.first_column) + a) * as_size(rows.m_max);
        const MatrixView H{column, part_rows, 1, rows.m_max};
        if (target.is_direct)
          H.as() += J.as().col(active[a]);
        else
          add_product(J, {at(target.chain) + active[a] * read.dof, read.dof, 1, read.dof}, H);
      }
    }
  }
}

/// C P Cᵀ of all ports that a part reads, until the next call; with a row of C for each error component of each port: of a
/// state block a unit vector, or nothing where the component is frozen; of a derived value its Jacobian, which must be in
/// the workspace. Null where the model does not ask for it.
PortCovariance Estimator::covariance_of(const PartPlan& part) {
  if (!part.model->declaration().needs_covariance) return {};
  int rows = 0;
  std::fill_n(first_row_.begin(), part.ports.size(), -1);
  for (const auto& read : part.reads) {
    first_row_[as_size(read.port)] = rows;
    rows += read.dof;
  }
  const MatrixView sum{port_covariance_.data(), rows, rows, rows};
  sum.as().setZero();
  for (const auto& a : part.reads)
    for (const auto& b : part.reads)
      for (const auto& by_a : a.targets)
        for (const auto& by_b : b.targets)
          add_covariance(a, by_a, b, by_b, covariance(),
                         sum.block(first_row_[as_size(a.port)], first_row_[as_size(b.port)], a.dof, b.dof));
  return {port_covariance_.data(), rows, first_row_.data()};
}

/// What P between two state blocks contributes to the covariance between two reads.
void Estimator::add_covariance(const PartPlan::Read& a, const PartPlan::Target& by_a, const PartPlan::Read& b,
                               const PartPlan::Target& by_b, ConstMatrixView P, MatrixView into) {
  // C of one read, all components of the target's block counted.
  const auto coefficient = [&](const PartPlan::Read& read, const PartPlan::Target& target, int row, int component) {
    if (target.is_direct) return row == component ? 1.0 : 0.0;
    return at(target.chain)[row + component * read.dof];
  };
  const auto& block_a = plan_.blocks[as_size(by_a.block)];
  const auto& block_b = plan_.blocks[as_size(by_b.block)];
  for (int j = 0; j < b.dof; ++j)
    for (int i = 0; i < a.dof; ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < block_a.active.size(); ++k) {
        const double left = coefficient(a, by_a, i, block_a.active[k]);
        if (left == 0.0) continue;
        for (std::size_t l = 0; l < block_b.active.size(); ++l)
          sum += left * P(block_a.first + static_cast<int>(k), block_b.first + static_cast<int>(l)) *
                 coefficient(b, by_b, j, block_b.active[l]);
      }
      into(i, j) += sum;
    }
}

}  // namespace binnacle::internal::filter
