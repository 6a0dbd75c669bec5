// SPDX-License-Identifier: Apache-2.0
#include "filter/linearizer.hpp"

#include <algorithm>

#include "filter/noise_check.hpp"

namespace binnacle::filter {

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

}  // namespace

Linearizer::Linearizer(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, AuxiliaryReader& auxiliary,
                       Workspace& workspace, ModelCalls& calls)
    : plan_(plan),
      channels_(channels),
      auxiliary_(auxiliary),
      workspace_(workspace),
      calls_(calls),
      fields_(as_size(std::max(1, plan.max_fields))),
      row_fields_(as_size(std::max(1, plan.max_row_fields))) {
  for (const auto& measurement : plan.measurements)
    for (const auto& part : measurement.parts) {
      if (!part.model->declaration().needs_covariance) continue;
      std::size_t rows = 0;
      for (const auto& read : part.reads) rows += as_size(read.dof);
      read_covariance_.resize(std::max(read_covariance_.size(), rows * rows));
      first_row_.resize(std::max(first_row_.size(), part.ports.size()));
    }
}

Result Linearizer::run(const MeasurementPlan& measurement, const SampleView& sample, const Moment& now,
                       const CovarianceForm& P, SampleRows& rows) {
  const auto& channel = channels_[as_size(measurement.channel)];
  rows.begin(measurement);
  const Result derived = evaluate_derived(plan_, measurement.derived, now, workspace_, calls_);
  if (!derived) return derived;
  int first_group = 0;
  has_finite_noise_ = true;
  for (const auto& part : measurement.parts) {
    int part_rows = 0;
    const Result result = run_part(part, sample, channel, now, P, rows, part_rows);
    if (!result) return result;
    assemble(part, part_rows, rows);
    first_group = name_groups(part.model->declaration().groups, first_group, part_rows, rows.groups.data() + rows.m);
    rows.m += part_rows;
  }
  if (rows.m == 0) return Result::unsupported("no rows");
  const int columns = static_cast<int>(measurement.columns.size());
  if (!has_finite_noise_ || !is_finite(ConstVectorView(rows.work.r, rows.m)) ||
      !is_finite(ConstMatrixView{rows.work.H, rows.m, columns, rows.work.m_max}))
    return Result::invalid("the residual, its Jacobian or its noise is not finite");
  return Result::ok();
}

Result Linearizer::run_part(const PartPlan& part, const SampleView& sample, const ChannelPlan& channel,
                            const Moment& now, const CovarianceForm& P, SampleRows& rows, int& part_rows) {
  SampleView seen = sample;
  seen.available = true;
  if (read_fields(part.fields, sample, interval_of(sample), fields_.data()) >= 0)
    return Result::invalid("a required field is not a number");
  if (!part.fields.row.empty()) read_row_fields(part.fields, channel, sample, row_fields_.data());
  seen.fields = fields_.data();
  seen.row_fields = row_fields_.data();

  const int most = part.model->declaration().max_rows, m_max = rows.work.m_max;
  std::fill_n(workspace_.jacobians.begin(), part.ports.size(), MatrixView{});
  for (const auto& read : part.reads) {
    workspace_.jacobians[as_size(read.port)] = MatrixView{workspace_.at(read.jacobian), most, read.dof, most};
    std::fill_n(workspace_.at(read.jacobian), most * read.dof, 0.0);
  }
  for (int i = 0; i < most; ++i) rows.keys[as_size(rows.m + i)] = i;

  MeasurementOutput out;
  out.residual = {rows.work.r + rows.m, most};
  out.H = workspace_.jacobians.data();
  out.R = MatrixView{rows.R_nominal.data() + rows.m + rows.m * m_max, most, most, m_max};
  out.row_keys = {rows.keys.data() + rows.m, as_size(most)};
  const Result result = calls_.linearize(part, seen, auxiliary_.read(part.auxiliary), workspace_.values_of(part.ports),
                                         workspace_.driving(now, part.driving_rates), covariance_of(part, P), out);
  if (!result) return result;
  if (out.rows < 0 || out.rows > most) return Result::failed("the model wrote more rows than it declared");
  part_rows = out.rows;
  if (part_rows < most)  // what a model wrote beyond its rows is not the next part's
    for (int j = 0; j < most; ++j)
      for (int i = 0; i < most; ++i)
        if (i >= part_rows || j >= part_rows) out.R(i, j) = 0;
  const MatrixView R{out.R.data, part_rows, part_rows, m_max};
  if (is_noise(R)) return result;
  if (!is_finite(R)) {  // it may come from the sample: that is invalid, see run()
    has_finite_noise_ = false;
    return result;
  }
  throw Stop(call_text(part.type, part.pointer, "linearize", calls_.time()) + " gave " + flaw_of_noise(R));
}

void Linearizer::assemble(const PartPlan& part, int part_rows, SampleRows& rows) {
  const int m_max = rows.work.m_max;
  const int stride = part.model->declaration().max_rows;
  for (const auto& read : part.reads) {
    const double* J = workspace_.at(read.jacobian);
    for (const auto& target : read.targets) {
      const auto& active = plan_.blocks[as_size(target.block)].active;
      for (std::size_t a = 0; a < active.size(); ++a) {
        double* H = rows.work.H + rows.m + (as_size(target.first_column) + a) * as_size(m_max);
        if (target.is_direct) {
          const double* column = J + active[a] * stride;
          for (int i = 0; i < part_rows; ++i) H[i] += column[i];
        } else {
          const double* chain = workspace_.at(target.chain) + active[a] * read.dof;
          for (int k = 0; k < read.dof; ++k)
            for (int i = 0; i < part_rows; ++i) H[i] += J[i + k * stride] * chain[k];
        }
      }
    }
  }
}

// ---- the covariance of what a model reads

/// Null where the model does not ask for it.
PortCovariance Linearizer::covariance_of(const PartPlan& part, const CovarianceForm& form) {
  if (!part.model->declaration().needs_covariance) return {};
  int rows = 0;
  std::fill_n(first_row_.begin(), part.ports.size(), -1);
  for (const auto& read : part.reads) {
    first_row_[as_size(read.port)] = rows;
    rows += read.dof;
  }
  const MatrixView sum{read_covariance_.data(), rows, rows, rows}, P = form.view();
  sum.as().setZero();
  for (const auto& a : part.reads)
    for (const auto& b : part.reads)
      for (const auto& by_a : a.targets)
        for (const auto& by_b : b.targets)
          add_covariance(a, by_a, b, by_b, P,
                         sum.block(first_row_[as_size(a.port)], first_row_[as_size(b.port)], a.dof, b.dof));
  return {read_covariance_.data(), rows, first_row_.data()};
}

/// What P between two state blocks contributes to the covariance between two reads.
void Linearizer::add_covariance(const PartPlan::Read& a, const PartPlan::Target& by_a, const PartPlan::Read& b,
                                const PartPlan::Target& by_b, MatrixView P, MatrixView into) {
  // C of one read, all components of the target's block counted.
  const auto coefficient = [&](const PartPlan::Read& read, const PartPlan::Target& target, int row, int component) {
    if (target.is_direct) return row == component ? 1.0 : 0.0;
    return workspace_.at(target.chain)[row + component * read.dof];
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

}  // namespace binnacle::filter
