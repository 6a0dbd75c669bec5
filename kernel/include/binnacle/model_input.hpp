// SPDX-License-Identifier: Apache-2.0
// What every model is handed besides its own: values of ports, the driving rates, auxiliary samples, covariance, notes.
#pragma once

#include <cassert>

#include "binnacle/handle.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/time.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// Stored values by port: `x[port]` has Port::stored_size() doubles, and is null for an open port.
template <class Double>
class PortVectors {
 public:
  constexpr PortVectors() = default;
  constexpr PortVectors(Double* const* by_port) noexcept : by_port_(by_port) {}

  VectorViewOf<Double> operator[](Port port) const noexcept {
    Double* const data = port.is_bound() ? by_port_[port.index()] : nullptr;
    return data ? VectorViewOf<Double>(data, port.stored_size()) : VectorViewOf<Double>();
  }

 private:
  Double* const* by_port_ = nullptr;
};
using PortValues = PortVectors<const double>;  ///< where they are read
/// Where they are written; null, too, for ports that are only read.
using PortOutputs = PortVectors<double>;

/// Jacobians by port (H of a measurement, J of a derived block): `H[port]` is rows × Port::dof(), zeroed by the kernel.
/// Null for ports that are open or whose Jacobian is not declared, and for all when only values are wanted.
class PortJacobians {
 public:
  constexpr PortJacobians() = default;
  constexpr PortJacobians(const MatrixView* by_port) noexcept : by_port_(by_port) {}

  MatrixView operator[](Port port) const noexcept {
    return by_port_ && port.is_bound() ? by_port_[port.index()] : MatrixView();
  }
  /// Whether any are wanted.
  constexpr explicit operator bool() const noexcept { return by_port_ != nullptr; }

 private:
  const MatrixView* by_port_ = nullptr;
};

/// The mean rates of the last driving interval: `rates[rate]`, `rates[three_of_them]`. Null until the first interval has
/// ended, and where an optional one is missing.
class DrivingRates {
 public:
  constexpr DrivingRates() = default;
  constexpr DrivingRates(const double* values) noexcept : values_(values) {}

  constexpr explicit operator bool() const noexcept { return values_ != nullptr; }
  double operator[](DrivingRate rate) const noexcept {
    assert(values_);
    return values_[rate.index()];
  }
  template <int N>
  VectorOf<N> operator[](const Several<DrivingRate, N>& rates) const noexcept {
    return rates.of(*this);
  }
  const double* data() const noexcept { return values_; }

 private:
  const double* values_ = nullptr;
};

/// What models and derived blocks may know besides the state (the `u` of the design).
struct Driving {
  Time t = no_time;  // of the state
  DrivingRates rates;
  bool bridges = false;  // the last driving interval bridged a hole in the input: its rates are held over the hole
};

/// The latest samples of the auxiliary channels: `auxiliary[input]`. Ask `available` first: a channel may have emitted
/// nothing yet.
class AuxiliarySamples {
 public:
  constexpr AuxiliarySamples() = default;
  constexpr AuxiliarySamples(const SampleView* by_input) noexcept : by_input_(by_input) {}

  const SampleView& operator[](Input input) const noexcept {
    assert(by_input_);
    return by_input_[input.index()];
  }

 private:
  const SampleView* by_input_ = nullptr;
};

/// Covariances between ports that the model reads, where its declaration wants_covariance(): P(a, b) is dof(a)×dof(b),
/// a priori. Considered components are in it; those of a frozen component are 0. Null for open ports.
class PortCovariance {
 public:
  constexpr PortCovariance() = default;
  /// first_row: by port, −1 where there is none.
  constexpr PortCovariance(const double* data, int stride, const int* first_row) noexcept
      : data_(data), stride_(stride), first_row_(first_row) {}

  constexpr explicit operator bool() const noexcept { return data_ != nullptr; }
  ConstMatrixView operator()(Port a, Port b) const noexcept {
    if (!data_ || !a.is_bound() || !b.is_bound()) return {};
    const int row = first_row_[a.index()], col = first_row_[b.index()];
    if (row < 0 || col < 0) return {};
    return {data_ + row + static_cast<long>(col) * stride_, a.dof(), b.dof(), stride_};
  }

 private:
  const double* data_ = nullptr;
  int stride_ = 0;
  const int* first_row_ = nullptr;
};

/// Where a model leaves a note for people: models must not print. The kernel counts equal notes, keeps the first with its
/// time and place, and shows them with the run's summary.
class Notes {
 public:
  using Function = void (*)(void* keeper, const char* text);  ///< the kernel's, which keeps a note
  constexpr Notes() = default;
  constexpr Notes(void* keeper, Function function) noexcept : keeper_(keeper), function_(function) {}

  /// Notes of a component are equal when their text is. It is copied, up to its 119th byte.
  void leave(const char* text) const {
    if (function_) function_(keeper_, text);
  }

 private:
  void* keeper_ = nullptr;
  Function function_ = nullptr;
};

}  // namespace binnacle
