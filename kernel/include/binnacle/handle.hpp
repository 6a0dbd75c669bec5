// SPDX-License-Identifier: Apache-2.0
// Handles: what a component asked for by name when it was bound, as an index for the loop.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

namespace binnacle {

/// What a component asked for by name when it was bound: where it is, in the order of the spec, and whether it is there.
template <class Of>
class Handle {
 public:
  constexpr Handle() = default;
  constexpr Handle(int index, bool is_bound) noexcept : index_(index), is_bound_(is_bound) {}

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

/// Several of a kind that are read as one vector: `in.sample[fields]` is an Eigen::Matrix<double, N, 1>.
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
  Eigen::Matrix<double, N, 1> of(const Numbers& numbers) const {
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v[i] = numbers[(*this)[i]];
    return v;
  }
};
template <int N>
using Fields = Several<Field, N>;
template <int N>
using DrivingRateVector = Several<DrivingRate, N>;

/// A port of this component, from Binding::port(). `in.x[port]`, `out.H[port]`, `in.P(port, other)`.
class Port {
 public:
  constexpr Port() = default;
  constexpr Port(int index, int dof, int stored_size) noexcept : index_(index), dof_(dof), stored_size_(stored_size) {}

  /// False: an optional port left open. All of its views are null.
  constexpr bool is_bound() const noexcept { return stored_size_ > 0; }
  /// In the order of ComponentSpec::ports.
  constexpr int index() const noexcept { return index_; }
  /// Error dimension of the block plugged in, all components counted; 0 when open.
  constexpr int dof() const noexcept { return dof_; }
  /// Doubles in its stored value; 0 when open.
  constexpr int stored_size() const noexcept { return stored_size_; }
  friend constexpr bool operator==(const Port&, const Port&) = default;

 private:
  int index_ = -1;
  int dof_ = 0;
  int stored_size_ = 0;
};

/// A field with one value per row, from Binding::row_field(): `in.sample(row, field)`.
class RowField {
 public:
  constexpr RowField() = default;
  constexpr RowField(int index, int width, bool is_bound) noexcept
      : index_(index), width_(width), is_bound_(is_bound) {}

  constexpr bool is_bound() const noexcept { return is_bound_; }
  /// Among the per-row fields, in the order of the spec.
  constexpr int index() const noexcept { return index_; }
  /// How many per-row fields there are.
  constexpr int width() const noexcept { return width_; }

 private:
  int index_ = 0;
  int width_ = 0;
  bool is_bound_ = false;
};

/// Something that a component declared that it emits, in the order of the declaration.
template <class Of>
class OutputHandle {
 public:
  constexpr OutputHandle() = default;
  constexpr explicit OutputHandle(int index) noexcept : index_(index) {}
  constexpr int index() const noexcept { return index_; }
  friend constexpr bool operator==(const OutputHandle&, const OutputHandle&) = default;

 private:
  int index_ = 0;
};
/// A field with one value per sample, from ChannelDeclaration::carries(): `out[field] = …`.
using OutputField = OutputHandle<struct OfOutputField>;
/// A field with one value per row, from ChannelDeclaration::carries_per_row(): `out(row, field) = …`.
using OutputRowField = OutputHandle<struct OfOutputRowField>;
/// A channel of a source or transform, from its declaration's emits().
using OutputChannel = OutputHandle<struct OfOutputChannel>;

/// N of them that were declared together: `out[fields] = v` for an Eigen vector.
template <int N>
class OutputFields {
 public:
  constexpr OutputFields() = default;
  constexpr explicit OutputFields(int first) noexcept : first_(first) {}
  constexpr int first() const noexcept { return first_; }
  constexpr OutputField operator[](int i) const noexcept { return OutputField(first_ + i); }

 private:
  int first_ = 0;
};

/// A T that the kernel keeps for this component, from the declaration's keeps<T>(): `in.memory[handle]` is a T&.
template <class T>
class Memory {
 public:
  using Type = T;
  constexpr Memory() = default;
  constexpr explicit Memory(std::size_t offset) noexcept : offset_(offset) {}
  constexpr std::size_t offset() const noexcept { return offset_; }

 private:
  std::size_t offset_ = 0;
};

/// `count` of them: `in.memory[handle]` is a std::span<T>.
template <class T>
class MemoryArray {
 public:
  constexpr MemoryArray() = default;
  constexpr MemoryArray(std::size_t offset, std::size_t count) noexcept : offset_(offset), count_(count) {}
  constexpr std::size_t offset() const noexcept { return offset_; }
  constexpr std::size_t count() const noexcept { return count_; }

 private:
  std::size_t offset_ = 0;
  std::size_t count_ = 0;
};

}  // namespace binnacle
