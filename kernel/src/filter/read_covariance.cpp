// SPDX-License-Identifier: Apache-2.0
#include "filter/read_covariance.hpp"

#include <algorithm>

namespace binnacle::filter {

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
