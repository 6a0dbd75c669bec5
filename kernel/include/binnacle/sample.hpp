// SPDX-License-Identifier: Apache-2.0
// Channels and samples: the only wire between components.
#pragma once

#include <array>
#include <cassert>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/handle.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// What a channel carries. Declared by its source or transform once it is bound:
///
///     ChannelDeclaration fix("fix");
///     lat_ = fix.carries(field::level("lat", "rad"));
///     velocity_ = fix.carries(field::level("vn", "m/s"), field::level("ve", "m/s"), field::level("vd", "m/s"));
///     fix_ = declaration_.emits(std::move(fix));
struct ChannelDeclaration {
  std::string name;                   // "" : the channel has the component's own name; else NAME.name
  std::vector<FieldSpec> fields;      // per-epoch fields and per-row fields, in any order
  int max_rows = 0;                   // rows of the per-row fields; 0 when there are none
  std::vector<NamedUnit> covariance;  // error components of an attached covariance, in order; empty: none
  Time max_interval = 0;              // longest interval of a sample; 0: samples are instants. Informative

  ChannelDeclaration() = default;
  explicit ChannelDeclaration(std::string its_name, std::vector<FieldSpec> its_fields = {})
      : name(std::move(its_name)), fields(std::move(its_fields)) {}

  int count(bool per_row) const {
    int found = 0;
    for (const FieldSpec& field : fields) found += field.is_per_row == per_row;
    return found;
  }
  OutputField carries(FieldSpec field) {
    field.is_per_row = false;
    fields.push_back(std::move(field));
    return OutputField(count(false) - 1);
  }
  /// Several that are written as one vector.
  template <std::size_t N>
  OutputFields<static_cast<int>(N)> carries(std::array<FieldSpec, N> together) {
    OutputFields<static_cast<int>(N)> handles;
    for (std::size_t i = 0; i < N; ++i) handles.each[i] = carries(std::move(together[i]));
    return handles;
  }
  template <class... More>
  OutputFields<static_cast<int>(2 + sizeof...(More))> carries(FieldSpec first, FieldSpec second, More... more) {
    return carries(std::array{std::move(first), std::move(second), std::move(more)...});
  }
  /// One value per row, of which a sample has up to max_rows.
  OutputRowField carries_per_row(FieldSpec field) {
    field.is_per_row = true;
    fields.push_back(std::move(field));
    return OutputRowField(count(true) - 1);
  }
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
  VectorOf<N> operator[](const Several<Field, N>& several) const noexcept {
    return several.of(*this);
  }
  double operator()(int row, RowField field) const noexcept {
    assert(row_fields && row >= 0 && row < rows);
    return row_fields[row * field.width() + field.index()];
  }
};

/// Where a source or transform writes a sample, by the handles of the channel's fields. All numbers are NaN at first.
///
///     out.t = t;
///     out[lat_] = 0.5;
///     out[velocity_] = v_n;                        // OutputFields<3>
///     out(row, pseudorange_) = rho;                // out.rows says how many rows there are
///     out.attach_covariance().as<3, 3>() = P;
struct SampleWriter {
  Time t = no_time;
  Time t0 = no_time;
  int rows = 0;
  bool has_covariance = false;

  double* fields = nullptr;      // per-epoch fields: field_count
  double* row_fields = nullptr;  // max_rows × row_width, row-major
  double* covariance = nullptr;  // covariance_dof², column-major
  int field_count = 0, row_width = 0, max_rows = 0, covariance_dof = 0;

  double& operator[](OutputField field) const noexcept {
    assert(fields && field.index() < field_count);
    return fields[field.index()];
  }
  template <int N>
  MapOf<N> operator[](OutputFields<N> several) const noexcept {
    assert(fields && several[0].index() + N <= field_count);
    return MapOf<N>(fields + several[0].index());
  }
  double& operator()(int row, OutputRowField field) const noexcept { return row_view(row)[field.index()]; }
  /// All per-epoch fields, in the order of the declaration.
  VectorView all() const noexcept { return {fields, field_count}; }
  /// All fields of a row.
  VectorView row_view(int row) const noexcept {
    assert(row_fields && row >= 0 && row < max_rows);
    return {row_fields + row * row_width, row_width};
  }
  MatrixView attach_covariance() noexcept {
    has_covariance = true;
    return {covariance, covariance_dof, covariance_dof, covariance_dof};
  }
  /// The kernel's: as it is before each sample.
  void clear() noexcept {
    t = t0 = no_time;
    rows = 0;
    has_covariance = false;
    const auto forget = [](double* numbers, int count) {
      for (int i = 0; i < count; ++i) numbers[i] = std::numeric_limits<double>::quiet_NaN();
    };
    forget(fields, field_count);
    forget(row_fields, max_rows * row_width);
    forget(covariance, covariance_dof * covariance_dof);
  }
};

}  // namespace binnacle
