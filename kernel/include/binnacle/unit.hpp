// SPDX-License-Identifier: Apache-2.0
// Units at the edge: text with a unit becomes SI, and back for display.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace binnacle {

/// Exponents of the base units, doubled so that those of sqrt(...) are whole. An angle never passes for a plain number.
struct Dimension {
  /// Indices into `doubled`.
  enum Base : std::size_t { length, time, angle, mass, temperature, current, base_count };

  std::array<int, base_count> doubled{};  ///< of m, s, rad, kg, K, A

  bool operator==(const Dimension&) const = default;
  bool is_dimensionless() const { return *this == Dimension{}; }
};

Dimension operator*(const Dimension& a, const Dimension& b);
Dimension operator/(const Dimension& a, const Dimension& b);

/// value in SI = scale * value in this unit.
struct Unit {
  double scale = 1.0;
  Dimension dimension;
};

/// value in the SI unit of the dimension.
struct Quantity {
  double value = 0.0;
  Dimension dimension;
};

/// A value, or one line that says what is wrong with the text.
template <class T>
class Parsed {
 public:
  Parsed(T value) : value_(std::move(value)) {}  // NOLINT(google-explicit-constructor): reads as a return value
  static Parsed failure(std::string message) {
    Parsed parsed;
    parsed.error_ = std::move(message);
    return parsed;
  }

  explicit operator bool() const { return value_.has_value(); }
  const T& operator*() const { return value_.value(); }
  const T* operator->() const { return &value_.value(); }
  const std::string& error() const { return error_; }

 private:
  Parsed() = default;

  std::optional<T> value_;
  std::string error_;
};

/// Units: m s min h day Hz rad deg arcmin arcsec mil (1/6400 of a turn) gon g (9.80665 m/s^2, so `mg` and
/// `ug` are accelerations) Gal kg kn nmi ft ppm ppb % K A Pa T V N 1, with prefixes n u m c h k M G where
/// they make sense. Grammar: `*` or `.` multiply, `/` divides (from left to right: m/s/h = (m/s)/h), `^2`,
/// `^-1`, `sqrt(...)`, `(...)`. What is wrong reads like `unknown unit 'deg/hr'; did you mean 'deg/h'?`
Parsed<Unit> parse_unit(std::string_view text);

/// "0.2 deg/h" in SI. Space optional; the number finite, in the C locale; dimensionless without a unit.
Parsed<Quantity> parse_quantity(std::string_view text);

/// Canonical text of a dimension's SI unit: "rad/s", "m/s^2", "rad/sqrt(s)", "1". parse_unit reads it with scale 1.
std::string si_unit(const Dimension& dimension);

/// For messages: "an angular rate (rad/s)"; a dimension without a name is "a quantity in m^3/kg".
std::string dimension_name(const Dimension& dimension);

/// "228 s", "1.5 h", "20 ms" in nanoseconds: exact for decimals, rounded to the nearest where digits go further.
Parsed<std::int64_t> parse_time(std::string_view text);

/// The nearest nanosecond, the whole seconds exactly. Throws std::out_of_range beyond int64 (292 years) or for NaN.
inline std::int64_t from_seconds(double seconds) {
  if (!(std::abs(seconds) < 9.2e9)) throw std::out_of_range("time does not fit into int64 nanoseconds");
  const double whole = std::floor(seconds);
  return static_cast<std::int64_t>(whole) * 1'000'000'000 + std::llround((seconds - whole) * 1e9);
}

}  // namespace binnacle
