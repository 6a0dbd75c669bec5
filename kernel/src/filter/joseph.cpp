// SPDX-License-Identifier: Apache-2.0
#include "filter/joseph.hpp"

#include "filter/layout.hpp"

namespace binnacle::filter {

Joseph::Joseph(const TransitionPlan& plan, int most_dof, double* P)
    : plan_(plan),
      P_(P),
      predict_scratch_(filter::predict_scratch(plan)),
      transform_scratch_(as_size(padded(plan.n)) * as_size(most_dof)) {}

void Joseph::set(MatrixView P) { view().as() = P.as(); }

void Joseph::predict(const double* const* phi, const double* const* noise) {
  filter::predict(plan_, phi, noise, P_, predict_scratch_.data());
}

void Joseph::project(const UpdateColumns& columns, int m, const UpdateWork& work) const {
  filter::project(columns, P_, plan_.n, m, work);
}

void Joseph::correct(int m, const UpdateWork& work) { filter::correct(P_, plan_.n, m, work); }

void Joseph::transform(const double* T, int first, int d) {
  transform_block(T, first, d, P_, plan_.n, transform_scratch_.data());
}

void Joseph::inflate(int row, double variance) { view()(row, row) += variance; }

double Joseph::variance(int row) const { return view()(row, row); }

int Joseph::first_unsound(double bound) const {
  const int step = padded(plan_.n) + 1;
  for (int i = 0; i < plan_.n; ++i)
    if (!(P_[i * step] >= 0 && P_[i * step] < bound)) return i;
  return -1;
}

void Joseph::expand(MatrixView into) const { into.as() = view().as(); }

MatrixView Joseph::view() const { return {P_, plan_.n, plan_.n, padded(plan_.n)}; }

}  // namespace binnacle::filter
