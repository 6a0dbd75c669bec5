// SPDX-License-Identifier: Apache-2.0
// What the columns of a solution file are, as its header says or a config does.
#pragma once

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace binnacle::rtklib {

inline constexpr double degree = std::numbers::pi / 180;  // [rad]

enum class Coordinates { degrees, dms, ecef, baseline };
enum class TimeSystem { gpst, utc, jst };

/// Standard deviations and signed cross terms in RTKLIB's order: 11 22 33 12 23 31.
inline constexpr std::size_t sd_count = 6;

/// Which of the columns behind time and position is which; −1: there is none.
struct Columns {
  int quality = -1, satellites = -1, age = -1, ratio = -1;
  std::array<int, sd_count> position_sd{-1, -1, -1, -1, -1, -1};
  std::array<int, 3> velocity{-1, -1, -1};
  std::array<int, sd_count> velocity_sd{-1, -1, -1, -1, -1, -1};
  int count = 0;

  bool has_position_sd() const { return position_sd.front() >= 0; }
  bool has_velocity() const { return velocity.front() >= 0; }
  bool has_velocity_sd() const { return velocity_sd.front() >= 0; }
};

struct Layout {
  Coordinates coordinates = Coordinates::degrees;
  TimeSystem time = TimeSystem::gpst;
  Columns columns;
  bool is_height_above_sea = false;
  std::optional<Eigen::Vector3d> reference;  // lat [rad], lon [rad], height [m] of the base station

  bool operator==(const Layout& other) const;
};

/// Words between blanks, tabs, commas and semicolons.
std::vector<std::string_view> words(std::string_view line);
/// Decimal; nothing where it is no finite number.
std::optional<double> number(std::string_view word);
/// Degrees, minutes and seconds, of which the degrees carry the sign, "-0" too [rad].
std::optional<double> angle_of_dms(std::string_view degrees, std::string_view minutes, std::string_view seconds);

/// Takes the lines that begin with '%'.
class Header {
 public:
  /// What is wrong with it; empty: nothing.
  std::string take(std::string_view line);
  /// Once a line has said what the columns are.
  const std::optional<Layout>& layout() const { return layout_; }

 private:
  std::string take_columns(const std::vector<std::string_view>& names);
  void take_reference();

  std::optional<Layout> layout_;
  std::vector<std::string> reference_;
  bool is_height_above_sea_ = false;
};

/// RTKLIB's own columns where no header says them: with or without velocity.
Columns standard_columns(bool has_velocity);

}  // namespace binnacle::rtklib
