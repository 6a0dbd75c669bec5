// SPDX-License-Identifier: Apache-2.0
// Anchors: points that are known by a number, from the config or from each row of a sample.
#include "anchors.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string>

namespace binnacle::aiding {

namespace {

using strapdown::PlaceKind;

std::string field_name(const char* coordinate) { return std::string("anchor_") + coordinate; }

/// A number of an anchor as a field carries it; none of what is no whole number.
std::optional<std::int64_t> whole(double number) {
  if (!(std::abs(number) < 9e15) || number != std::floor(number)) return std::nullopt;
  return static_cast<std::int64_t>(number);
}

std::int64_t key_of(const std::string& text) {
  std::int64_t key = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), key);
  if (error != std::errc() || end != text.data() + text.size())
    throw ComponentError("an anchor is listed by its whole number, as in the channel's field: \"105\"",
                         "/anchors/" + text);
  return key;
}

}  // namespace

ParameterSpec Anchors::parameter() {
  using parameter::number;
  std::vector<ParameterSpec> members = point_parameters();
  members.push_back(number("bias", "m")
                        .defaults("0")
                        .plausible(0, 1e4)
                        .about("known bias of the anchor's ranges, positive if they are too long"));
  members.push_back(number("sigma", "m")
                        .above(0)
                        .plausible(1e-4, 1e4)
                        .about("standard deviation for this anchor, instead of the model's 'sigma'"));
  return parameter::map("anchors", parameter::object("anchor", std::move(members)))
      .about(
          "anchors by their number in the channel, with their positions unless the channel carries these (anchor_x …)");
}

std::vector<FieldSpec> Anchors::place_fields() {
  std::vector<FieldSpec> fields;
  for (const auto& [kind, text] : {std::pair(PlaceKind::geodetic, "position of the anchor, geodetic"),
                                   std::pair(PlaceKind::ecef, "position of the anchor, ECEF"),
                                   std::pair(PlaceKind::local, "position of the anchor, local")}) {
    const auto& names = coordinate_names(kind);
    for (int i = 0; i < 3; ++i) {
      const bool is_angle = kind == PlaceKind::geodetic && i < 2;
      fields.push_back(field::level(field_name(names[static_cast<std::size_t>(i)]), is_angle ? "rad" : "m")
                           .per_row()
                           .optional()
                           .about(text));
    }
  }
  return fields;
}

Anchors::Anchors(const Binding& binding, const SensorPlace& sensor, From from) : sensor_(sensor) {
  if (from == From::rows) find_row_place(binding);
  read_listed(binding);
  if (listed_.empty() && from == From::config) throw ComponentError("no anchor is listed", "/anchors");
  if (listed_.empty() && !row_place_)
    throw ComponentError(
        "the positions of the anchors are missing: list them as \"anchors\": {\"1\": {\"lat\": …, \"lon\": …, "
        "\"height\": …}}, or let the channel carry anchor_lat, anchor_lon, anchor_height (or anchor_x …, anchor_north "
        "…) per row",
        "/anchors");
}

void Anchors::find_row_place(const Binding& binding) {
  for (const PlaceKind kind : {PlaceKind::geodetic, PlaceKind::ecef, PlaceKind::local}) {
    const auto& names = coordinate_names(kind);
    RowPlace place{kind, {}};
    const bool is_planar = kind == PlaceKind::local && sensor_.port().dof() == 2;
    int count = 0;
    std::string missing;
    for (std::size_t i = 0; i < 3; ++i) {
      place.fields[i] = binding.row_field(field_name(names[i]));
      if (place.fields[i].is_bound())
        ++count;
      else if (missing.empty() && !(is_planar && i == 2))
        missing = field_name(names[i]);
    }
    if (count == 0) continue;
    if (!missing.empty())
      throw ComponentError("the channel carries only part of the anchors' positions, without a field for '" + missing +
                               "'",
                           "/fields");
    if (row_place_)
      throw ComponentError("the channel carries the anchors' positions in two kinds of coordinates", "/fields");
    sensor_.demand(kind, "/fields");
    row_place_ = place;
  }
}

void Anchors::read_listed(const Binding& binding) {
  if (!binding.parameters().has("anchors")) return;
  for (const auto& [name, value] : binding.parameters().members("anchors")) {
    const std::string pointer = "/anchors/" + name;
    const Parameters object(value);
    const std::optional<Point> point = sensor_.read(object, pointer);
    if (point && row_place_)
      throw ComponentError("the channel carries the anchors' positions: remove them here, or there", pointer);
    if (!point && !row_place_)
      throw ComponentError("the anchor has no position: give lat, lon, height or x, y, z or north, east, down",
                           pointer);
    AnchorSight anchor{key_of(name), count(), Eigen::Vector3d::Zero(), object.number("bias"), 0};
    if (point) anchor.r = sensor_.bring(*point);
    if (object.has("sigma")) anchor.variance = object.number("sigma") * object.number("sigma");
    for (const AnchorSight& other : listed_)
      if (other.key == anchor.key) throw ComponentError("the anchor is listed twice", pointer);
    listed_.push_back(anchor);
  }
}

bool Anchors::have_variance() const noexcept {
  return !listed_.empty() && std::all_of(listed_.begin(), listed_.end(), [](const auto& a) { return a.variance > 0; });
}

std::int64_t Anchors::listed_key(std::int64_t key, const char* pointer) const {
  for (const AnchorSight& anchor : listed_)
    if (anchor.key == key) return key;
  throw ComponentError("anchor " + std::to_string(key) + " is none of 'anchors'", pointer);
}

std::optional<AnchorSight> Anchors::sight(const Notes& notes, std::int64_t key) const {
  for (const AnchorSight& anchor : listed_)
    if (anchor.key == key) return anchor;
  char text[96];
  std::snprintf(text, sizeof text, "rows of anchor %lld are left out: it is none of 'anchors'",
                static_cast<long long>(key));
  notes.leave(text);
  return std::nullopt;
}

std::optional<AnchorSight> Anchors::sight(const MeasurementInput& in, int row, RowField key_field) const {
  std::optional<std::int64_t> key;
  if (key_field.is_bound()) {
    key = whole(in.sample(row, key_field));
    if (!key) {
      in.notes.leave("a row is left out: the number of its anchor is not a whole number");
      return std::nullopt;
    }
  }
  AnchorSight anchor{key ? *key : row, -1, Eigen::Vector3d::Zero(), 0, 0};
  if (!listed_.empty()) {
    const auto listed = sight(in.notes, key ? *key : listed_.front().key);
    if (!listed) return std::nullopt;
    anchor = *listed;
  }
  if (!row_place_) return anchor;
  Point point{row_place_->kind, Eigen::Vector3d::Zero()};
  for (int i = 0; i < 3; ++i)
    if (const RowField f = row_place_->fields[static_cast<std::size_t>(i)]; f.is_bound())
      point.coordinates[i] = in.sample(row, f);
  if (!point.coordinates.allFinite()) {
    in.notes.leave("a row is left out: its anchor has no position");
    return std::nullopt;
  }
  anchor.r = sensor_.bring(point);
  return anchor;
}

void Anchors::check_bias(Port bias) const {
  if (!bias.is_bound() || bias.dof() == 1 || bias.dof() == count()) return;
  throw ComponentError("its block has " + std::to_string(bias.dof()) + " components where 'anchors' lists " +
                           std::to_string(count()) + "; one for each, or one for all",
                       "/blocks/bias");
}

}  // namespace binnacle::aiding
