// SPDX-License-Identifier: Apache-2.0
// Channels and samples: the only wire between components.
#pragma once

#include <Eigen/Core>

#include <cassert>
#include <string>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/handle.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"

namespace binnacle {

/// What a channel carries. Declared by its source or transform once it is bound.
struct ChannelDeclaration {
  std::string name;                   // "" : the channel has the component's own name; else NAME.name
  std::vector<FieldSpec> fields;      // per-epoch fields and per-row fields, in any order
  int max_rows = 0;                   // rows of the per-row fields; 0 when there are none
  std::vector<NamedUnit> covariance;  // error components of an attached covariance, in order; empty: none
  Time max_interval = 0;              // longest interval of a sample; 0: samples are instants. Informative
};

/// One sample, read-only. Valid during the call that it is handed to.
///
/// In a sample given to a component the fields are those the component declared, in its order, already converted to the
/// declared kind; an optional field that the channel lacks is NaN. A rate or increment belongs to the interval (t0, t].
///
///     const double z = sample[speed_];                  // per epoch
///     const Eigen::Vector3d v = sample[v_n_];           // Fields<3>
///     const double rho = sample(row, pseudorange_);     // per row
struct SampleView {
  Time t = no_time;
  Time t0 = no_time;  // start of the interval; no_time when the sample is an instant
  int rows = 0;
  const double* fields = nullptr;      // per-epoch fields
  const double* row_fields = nullptr;  // rows × (number of per-row fields), row-major
  const double* covariance = nullptr;  // column-major, in the channel's error components; null: none
  bool available = false;              // false: an auxiliary channel that has emitted nothing yet

  double operator[](Field field) const noexcept {
    assert(fields);
    return fields[field.index()];
  }
  template <int N>
  Eigen::Matrix<double, N, 1> operator[](const Several<Field, N>& several) const noexcept {
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v[i] = (*this)[several[i]];
    return v;
  }
  double operator()(int row, RowField field) const noexcept {
    assert(row_fields && row >= 0 && row < rows);
    return row_fields[row * field.width() + field.index()];
  }
};

/// Where a source or transform writes a sample. `fields`, `row_fields` and `covariance` point at storage of the
/// declared size, filled with NaN.
struct SampleSlot {
  Time t = no_time;
  Time t0 = no_time;
  int rows = 0;
  double* fields = nullptr;
  double* row_fields = nullptr;
  double* covariance = nullptr;
  bool has_covariance = false;
};

}  // namespace binnacle
