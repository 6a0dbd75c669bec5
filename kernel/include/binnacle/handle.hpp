// SPDX-License-Identifier: Apache-2.0
// Handles: what a component asked for by name when it was bound, as an index for the loop.
#pragma once

#include <array>
#include <cstddef>

#include "binnacle/view.hpp"

namespace binnacle {

/// What a component asked for by name when it was bound, or declared that it emits: where it is, in the order of the spec
/// or the declaration, and whether it is there.
template <class Of>
class Handle {
 public:
  constexpr Handle() = default;
  constexpr explicit Handle(int index, bool is_bound = true) noexcept : index_(index), is_bound_(is_bound) {}

  /// False: an optional one that is left out.
  constexpr bool is_bound() const noexcept { return is_bound_; }
  constexpr int index() const noexcept { return index_; }
  friend constexpr bool operator==(const Handle&, const Handle&) = default;

 private:
  int index_ = 0;
  bool is_bound_ = false;
};
/// A field with one value per sample, from Binding::field(): `in.sample[field]`. Unbound it reads as NaN. The index counts
/// the per-epoch fields.
using Field = Handle<struct OfField>;
/// A mean rate of the filter's driving input, from Binding::driving_rate(): `in.u.rates[rate]`. Where one is unbound,
/// `in.u.rates` is always null.
using DrivingRate = Handle<struct OfDrivingRate>;
/// A channel that the component subscribes to (ComponentSpec::inputs), from Binding::input(): `in.auxiliary[input]`.
using Input = Handle<struct OfInput>;
/// A field with one value per sample, from ChannelDeclaration::carries(): `out[field] = …`.
using OutputField = Handle<struct OfOutputField>;
/// A field with one value per row, from ChannelDeclaration::carries_per_row(): `out(row, field) = …`.
using OutputRowField = Handle<struct OfOutputRowField>;
/// A channel of a source or transform, from its declaration's emits().
using OutputChannel = Handle<struct OfOutputChannel>;

/// Several of a kind that are read as one vector: `in.sample[fields]` is an Eigen::Matrix<double, N, 1>. Output fields that
/// were declared together are written as one: `out[fields] = v`.
template <class Handle, int N>
struct Several {
  std::array<Handle, static_cast<std::size_t>(N)> each;

  constexpr const Handle& operator[](int i) const noexcept { return each[static_cast<std::size_t>(i)]; }
  /// Whether all of them are.
  constexpr bool is_bound() const noexcept {
    for (const Handle& handle : each)
      if (!handle.is_bound()) return false;
    return true;
  }
  /// `numbers[each]`, as a vector.
  template <class Numbers>
  auto of(const Numbers& numbers) const {
    VectorOf<N> v;
    for (int i = 0; i < N; ++i) v[i] = numbers[(*this)[i]];
    return v;
  }
};
template <int N>
using Fields = Several<Field, N>;  ///< N fields, read as one vector
template <int N>
using DrivingRateVector = Several<DrivingRate, N>;  ///< N driving rates, read as one vector
template <int N>
using OutputFields = Several<OutputField, N>;  ///< N fields, written as one vector

/// A port of this component, from Binding::port(), in the order of ComponentSpec::ports: `in.x[port]`, `out.H[port]`,
/// `in.P(port, other)`. All of its views are null where it is an optional one left open.
class Port : public Handle<struct OfPort> {
 public:
  constexpr Port() noexcept : Handle(-1, false) {}
  constexpr Port(int index, int dof, int stored_size) noexcept
      : Handle(index, stored_size > 0), dof_(dof), stored_size_(stored_size) {}

  /// Error dimension of the block plugged in, all components counted; 0 when open.
  constexpr int dof() const noexcept { return dof_; }
  /// Doubles in its stored value; 0 when open.
  constexpr int stored_size() const noexcept { return stored_size_; }
  friend constexpr bool operator==(const Port&, const Port&) = default;

 private:
  int dof_ = 0;
  int stored_size_ = 0;
};

/// A field with one value per row, from Binding::row_field(): `in.sample(row, field)`. The index counts the per-row fields.
class RowField : public Handle<struct OfRowField> {
 public:
  constexpr RowField() = default;
  constexpr RowField(int index, int width, bool is_bound) noexcept : Handle(index, is_bound), width_(width) {}

  /// How many per-row fields there are.
  constexpr int width() const noexcept { return width_; }

 private:
  int width_ = 0;
};

/// A T that the kernel keeps for this component, from the declaration's keeps<T>(): `in.memory[handle]` is a T&.
template <class T>
struct Memory {
  using Type = T;  ///< of what is kept
  std::size_t offset = 0;
};

/// `count` of them: `in.memory[handle]` is a std::span<T>.
template <class T>
struct MemoryArray {
  std::size_t offset = 0;
  std::size_t count = 0;
};

}  // namespace binnacle
