// SPDX-License-Identifier: Apache-2.0
#include "filter/linearizer.hpp"

#include <algorithm>

#include "filter/fields.hpp"
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

/// Of r and H: NaN if anything is not finite, else 0.
double not_finite(const MeasurementPlan& plan, const SampleRows& rows) {
  double sum = 0;
  for (int i = 0; i < rows.m; ++i) sum += rows.work.r[i] * 0.0;
  for (std::size_t c = 0; c < plan.columns.columns.size(); ++c)
    for (int i = 0; i < rows.m; ++i) sum += rows.work.H[as_size(i) + c * as_size(rows.work.m_max)] * 0.0;
  return sum;
}

}  // namespace

Linearizer::Linearizer(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, AuxiliaryReader& auxiliary,
                       Workspace& workspace, ModelCalls& calls)
    : plan_(plan),
      channels_(channels),
      auxiliary_(auxiliary),
      workspace_(workspace),
      calls_(calls),
      read_covariance_(plan),
      fields_(as_size(std::max(1, plan.max_fields))),
      row_fields_(as_size(std::max(1, plan.max_row_fields))) {}

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
  if (!has_finite_noise_ || not_finite(measurement, rows) != 0.0)
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
  const Result result =
      calls_.linearize(part, seen, auxiliary_.read(part.auxiliary), workspace_.values_of(part.ports),
                       workspace_.driving(now, part.driving_rates), read_covariance_.of(part, P, workspace_), out);
  if (!result) return result;
  if (out.rows < 0 || out.rows > most) return Result::failed("the model wrote more rows than it declared");
  part_rows = out.rows;
  if (part_rows < most)  // what a model wrote beyond its rows is not the next part's
    for (int j = 0; j < most; ++j)
      for (int i = 0; i < most; ++i)
        if (i >= part_rows || j >= part_rows) out.R(i, j) = 0;
  const MatrixView R{out.R.data, part_rows, part_rows, m_max};
  if (is_noise(R)) return result;
  for (int j = 0; j < part_rows; ++j)  // what is not finite may come from the sample: that is invalid, see run()
    for (int i = 0; i < part_rows; ++i)
      if (!(R(i, j) * 0.0 == 0.0)) {
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

namespace {

int rows_of(const PartPlan& part) {
  int rows = 0;
  for (const auto& read : part.reads) rows += read.dof;
  return rows;
}

/// C of one read: row `row`, column `component` of the target's block, all of its components counted.
double coefficient(const PartPlan::Read& read, const PartPlan::Target& target, int row, int component,
                   Workspace& workspace) {
  if (target.is_direct) return row == component ? 1.0 : 0.0;
  return workspace.at(target.chain)[row + component * read.dof];
}

}  // namespace

ReadCovariance::ReadCovariance(const FilterPlan& plan) : plan_(plan) {
  std::size_t doubles = 0, ports = 0;
  for (const auto& measurement : plan.measurements)
    for (const auto& part : measurement.parts) {
      if (!part.model->declaration().needs_covariance) continue;
      const std::size_t rows = as_size(rows_of(part));
      doubles = std::max(doubles, rows * rows);
      ports = std::max(ports, part.ports.size());
    }
  covariance_.resize(doubles);
  first_row_.resize(ports);
}

PortCovariance ReadCovariance::of(const PartPlan& part, const CovarianceForm& form, Workspace& workspace) {
  if (!part.model->declaration().needs_covariance) return {};
  const MatrixView P = form.view();
  rows_ = 0;
  std::fill_n(first_row_.begin(), part.ports.size(), -1);
  for (const auto& read : part.reads) {
    first_row_[as_size(read.port)] = rows_;
    rows_ += read.dof;
  }
  std::fill_n(covariance_.begin(), as_size(rows_) * as_size(rows_), 0.0);
  for (const auto& a : part.reads)
    for (const auto& b : part.reads)
      for (const auto& by_a : a.targets)
        for (const auto& by_b : b.targets) add(a, by_a, b, by_b, P, workspace);
  return {covariance_.data(), rows_, first_row_.data()};
}

/// What P between two state blocks contributes to the covariance between two reads.
void ReadCovariance::add(const PartPlan::Read& a, const PartPlan::Target& by_a, const PartPlan::Read& b,
                         const PartPlan::Target& by_b, MatrixView P, Workspace& workspace) {
  const auto& block_a = plan_.blocks[as_size(by_a.block)];
  const auto& block_b = plan_.blocks[as_size(by_b.block)];
  const int row = first_row_[as_size(a.port)], column = first_row_[as_size(b.port)];
  for (int j = 0; j < b.dof; ++j)
    for (int i = 0; i < a.dof; ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < block_a.active.size(); ++k) {
        const double left = coefficient(a, by_a, i, block_a.active[k], workspace);
        if (left == 0.0) continue;
        for (std::size_t l = 0; l < block_b.active.size(); ++l)
          sum += left * P(block_a.first + static_cast<int>(k), block_b.first + static_cast<int>(l)) *
                 coefficient(b, by_b, j, block_b.active[l], workspace);
      }
      covariance_[as_size(row + i) + as_size(column + j) * as_size(rows_)] += sum;
    }
}

}  // namespace binnacle::filter
