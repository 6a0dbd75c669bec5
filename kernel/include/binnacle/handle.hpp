// SPDX-License-Identifier: Apache-2.0
// Handles: what a component asked for by name when it was bound, as an index for the loop.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

namespace binnacle {

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

/// A field with one value per sample, from Binding::field(): `in.sample[field]`.
class Field {
 public:
  constexpr Field() = default;
  constexpr Field(int index, bool is_bound) noexcept : index_(index), is_bound_(is_bound) {}

  /// False: an optional field that the channel lacks; it reads as NaN.
  constexpr bool is_bound() const noexcept { return is_bound_; }
  /// Among the per-epoch fields, in the order of the spec.
  constexpr int index() const noexcept { return index_; }

 private:
  int index_ = 0;
  bool is_bound_ = false;
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

/// A mean rate of the filter's driving input, from Binding::driving_rate(): `in.u.rates[rate]`.
class DrivingRate {
 public:
  constexpr DrivingRate() = default;
  constexpr DrivingRate(int index, bool is_bound) noexcept : index_(index), is_bound_(is_bound) {}

  /// False: an optional one that the driving input lacks; then `in.u.rates` is always null.
  constexpr bool is_bound() const noexcept { return is_bound_; }
  constexpr int index() const noexcept { return index_; }

 private:
  int index_ = 0;
  bool is_bound_ = false;
};

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
};
template <int N>
using Fields = Several<Field, N>;
template <int N>
using DrivingRateVector = Several<DrivingRate, N>;

/// A channel that the component subscribes to (ComponentSpec::inputs), from Binding::input(): `in.auxiliary[input]`.
class Input {
 public:
  constexpr Input() = default;
  constexpr Input(int index, bool is_bound) noexcept : index_(index), is_bound_(is_bound) {}

  constexpr bool is_bound() const noexcept { return is_bound_; }
  constexpr int index() const noexcept { return index_; }
  friend constexpr bool operator==(const Input&, const Input&) = default;

 private:
  int index_ = -1;
  bool is_bound_ = false;
};

/// A field of a channel that is emitted, with one value per sample, from ChannelDeclaration::carries(): `out[field] = …`.
class OutputField {
 public:
  constexpr OutputField() = default;
  constexpr explicit OutputField(int index) noexcept : index_(index) {}
  /// Among the per-epoch fields, in the order of the declaration.
  constexpr int index() const noexcept { return index_; }

 private:
  int index_ = 0;
};

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

/// A field with one value per row, from ChannelDeclaration::carries_per_row(): `out(row, field) = …`.
class OutputRowField {
 public:
  constexpr OutputRowField() = default;
  constexpr explicit OutputRowField(int index) noexcept : index_(index) {}
  constexpr int index() const noexcept { return index_; }

 private:
  int index_ = 0;
};

/// A channel that a source or transform emits on, from its declaration's emits().
class OutputChannel {
 public:
  constexpr OutputChannel() = default;
  constexpr explicit OutputChannel(int index) noexcept : index_(index) {}
  constexpr int index() const noexcept { return index_; }
  friend constexpr bool operator==(const OutputChannel&, const OutputChannel&) = default;

 private:
  int index_ = 0;
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
