// SPDX-License-Identifier: Apache-2.0
// RTKLIB 2.4.2 manual, appendix B.1 "positioning solution file"; solution.c of 2.4.3 for what it leaves open.
#include "layout.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace binnacle::rtklib {

namespace {

/// "sdn(m)" is "sdn".
std::string_view name_of(std::string_view column) { return column.substr(0, column.find('(')); }

int find(const std::vector<std::string_view>& names, std::initializer_list<std::string_view> any) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::find(any.begin(), any.end(), name_of(names[i])) != any.end()) return static_cast<int>(i);
  return -1;
}

constexpr std::array<std::array<std::string_view, sd_count>, 3> sd_names{
    {{"sdn", "sde", "sdu", "sdne", "sdeu", "sdun"},
     {"sdx", "sdy", "sdz", "sdxy", "sdyz", "sdzx"},
     {"sde", "sdn", "sdu", "sden", "sdnu", "sdue"}}};
constexpr std::array<std::array<std::string_view, 3>, 3> velocity_names{
    {{"vn", "ve", "vu"}, {"vx", "vy", "vz"}, {"ve", "vn", "vu"}}};
constexpr std::array<std::array<std::string_view, sd_count>, 3> velocity_sd_names{
    {{"sdvn", "sdve", "sdvu", "sdvne", "sdveu", "sdvun"},
     {"sdvx", "sdvy", "sdvz", "sdvxy", "sdvyz", "sdvzx"},
     {"sdve", "sdvn", "sdvu", "sdven", "sdvnu", "sdvue"}}};

std::size_t axes_of(Coordinates coordinates) {
  return coordinates == Coordinates::ecef ? 1 : coordinates == Coordinates::baseline ? 2 : 0;
}

/// All of them or none.
template <std::size_t N>
bool find_all(const std::vector<std::string_view>& names, const std::array<std::string_view, N>& wanted,
              std::array<int, N>& places) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < N; ++i) {
    places[i] = find(names, {wanted[i]});
    // RTKLIB calls the last column of solutions in degrees, minutes and seconds so.
    if (places[i] < 0 && wanted[i] == "sdun") places[i] = find(names, {"sdue"});
    found += places[i] >= 0;
  }
  if (found == N) return true;
  places.fill(-1);
  return found == 0;
}

}  // namespace

bool Layout::operator==(const Layout& other) const {
  const auto places = [](const Columns& c) {
    std::vector<int> all{c.quality, c.satellites, c.age, c.ratio, c.count};
    for (const int each : c.position_sd) all.push_back(each);
    for (const int each : c.velocity) all.push_back(each);
    for (const int each : c.velocity_sd) all.push_back(each);
    return all;
  };
  return coordinates == other.coordinates && time == other.time && is_height_above_sea == other.is_height_above_sea &&
         places(columns) == places(other.columns);
}

std::vector<std::string_view> words(std::string_view line) {
  constexpr std::string_view between = " \t,;\r";
  std::vector<std::string_view> list;
  for (;;) {
    const auto begin = line.find_first_not_of(between);
    if (begin == line.npos) return list;
    line.remove_prefix(begin);
    const auto end = std::min(line.find_first_of(between), line.size());
    list.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

std::optional<double> number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || rest != word.data() + word.size() || !std::isfinite(value)) return {};
  return value;
}

std::optional<double> angle_of_dms(std::string_view degrees, std::string_view minutes, std::string_view seconds) {
  const auto d = number(degrees), m = number(minutes), s = number(seconds);
  if (!d || !m || !s || *m < 0 || *m >= 60 || *s < 0 || *s > 60) return {};
  const double magnitude = std::abs(*d) + *m / 60 + *s / 3600;
  return (degrees.starts_with('-') ? -magnitude : magnitude) * degree;
}

Columns standard_columns(bool has_velocity) {
  Columns c;
  c.quality = 0;
  c.satellites = 1;
  for (std::size_t i = 0; i < sd_count; ++i) c.position_sd[i] = 2 + static_cast<int>(i);
  c.age = 8;
  c.ratio = 9;
  c.count = 10;
  if (!has_velocity) return c;
  for (std::size_t i = 0; i < 3; ++i) c.velocity[i] = 10 + static_cast<int>(i);
  for (std::size_t i = 0; i < sd_count; ++i) c.velocity_sd[i] = 13 + static_cast<int>(i);
  c.count = 19;
  return c;
}

std::string Header::take(std::string_view line) {
  line.remove_prefix(1);
  const auto list = words(line);
  if (list.empty()) return {};
  if (line.find("lat/lon/height=") != line.npos) {
    if (line.find("WGS84") == line.npos) return "its coordinates are not on WGS 84";
    is_height_above_sea_ = line.find("/geodetic") != line.npos;
    return {};
  }
  const auto colon = line.find(':');
  if (list.size() > 2 && list[0] == "ref" && list[1] == "pos" && colon != line.npos) {
    for (const auto word : words(line.substr(colon + 1))) reference_.emplace_back(word);
    return {};
  }
  if (list[0] == "GPST" || list[0] == "UTC" || list[0] == "JST") return take_columns(list);
  return {};
}

std::string Header::take_columns(const std::vector<std::string_view>& names) {
  Layout layout;
  layout.time = names[0] == "GPST" ? TimeSystem::gpst : names[0] == "UTC" ? TimeSystem::utc : TimeSystem::jst;
  if (names.size() < 4) return "it names no columns of a position";
  if (name_of(names[1]) == "latitude" && name_of(names[2]) == "longitude" && name_of(names[3]) == "height")
    layout.coordinates = names[1].find("d'") != names[1].npos ? Coordinates::dms : Coordinates::degrees;
  else if (names[1].starts_with("x-ecef") && names[2].starts_with("y-ecef") && names[3].starts_with("z-ecef"))
    layout.coordinates = Coordinates::ecef;
  else if (names[1].starts_with("e-baseline") && names[2].starts_with("n-baseline") &&
           names[3].starts_with("u-baseline"))
    layout.coordinates = Coordinates::baseline;
  else
    return "its columns of the position, '" + std::string(names[1]) + "' and so on, are not known";
  const std::vector<std::string_view> rest(names.begin() + 4, names.end());
  Columns& c = layout.columns;
  c.count = static_cast<int>(rest.size());
  c.quality = find(rest, {"Q"});
  c.satellites = find(rest, {"ns"});
  c.age = find(rest, {"age"});
  c.ratio = find(rest, {"ratio"});
  const std::size_t axes = axes_of(layout.coordinates);
  if (!find_all(rest, sd_names[axes], c.position_sd) || !find_all(rest, velocity_names[axes], c.velocity) ||
      !find_all(rest, velocity_sd_names[axes], c.velocity_sd))
    return "some of its columns of standard deviations or of velocity are missing";
  layout.is_height_above_sea = is_height_above_sea_;
  layout_ = layout;
  take_reference();
  return {};
}

/// Degrees, or degrees, minutes and seconds, or ECEF; the form is that of the solutions, of baselines either of the first.
void Header::take_reference() {
  const auto at = [&](std::size_t i) { return i < reference_.size() ? number(reference_[i]) : std::nullopt; };
  if (layout_->coordinates == Coordinates::ecef) return;
  if (reference_.size() == 3) {
    if (at(0) && at(1) && at(2)) layout_->reference = Eigen::Vector3d(*at(0) * degree, *at(1) * degree, *at(2));
  } else if (reference_.size() == 7) {
    const auto lat = angle_of_dms(reference_[0], reference_[1], reference_[2]);
    const auto lon = angle_of_dms(reference_[3], reference_[4], reference_[5]);
    if (lat && lon && at(6)) layout_->reference = Eigen::Vector3d(*lat, *lon, *at(6));
  }
}

}  // namespace binnacle::rtklib
