// SPDX-License-Identifier: Apache-2.0
#include "inspect_lever_arms.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include <Eigen/Geometry>

#include "binnacle/unit.hpp"

namespace binnacle::command {

namespace {

using inspect::Json;
using inspect::StatedLeverArm;

/// A number, or text with a unit, in SI.
std::optional<double> value_of(const Json& value) {
  if (value.is_number()) return value.get<double>();
  if (!value.is_string()) return std::nullopt;
  const auto quantity = parse_quantity(value.get<std::string>());
  return quantity ? std::optional(quantity->value) : std::nullopt;
}

bool is_type(const Json& component, const std::string& name) {
  const std::string type = component.at("type");
  return type == name || type.ends_with("/" + name);
}

/// What rotate_axes turns by, given as angles.
std::optional<Eigen::Matrix3d> rotation_of(const Json& transform) {
  for (const char* key : {"euler", "quaternion", "matrix"})
    if (transform.contains(key)) return std::nullopt;
  double angles[3] = {0, 0, 0};
  constexpr const char* names[] = {"roll", "pitch", "yaw"};
  for (int k = 0; k < 3; ++k) {
    const auto angle = value_of(transform.value(names[k], Json(0)));
    if (!angle) return std::nullopt;
    angles[k] = *angle;
  }
  Eigen::Matrix3d M =
      (Eigen::AngleAxisd(angles[2], Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(angles[1], Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(angles[0], Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  if (transform.value("flip", "none") == "flu_to_frd") M = Eigen::Vector3d(1, -1, -1).asDiagonal() * M;
  return transform.value("inverse", false) ? Eigen::Matrix3d(M.transpose()) : M;
}

/// The source's channel behind a filter's inertial input, and the rotation from its axes to the filter's.
struct Axes {
  std::string channel;
  Eigen::Matrix3d C = Eigen::Matrix3d::Identity();
};
std::optional<Axes> axes_of(const Json& config, const std::string& input) {
  Axes axes{input};
  const Json transforms = config.value("transforms", Json::object());
  std::set<std::string> seen;
  for (auto at = transforms.find(axes.channel); at != transforms.end(); at = transforms.find(axes.channel)) {
    if (!is_type(*at, "rotate_axes") || !seen.insert(axes.channel).second) return std::nullopt;
    const auto turned = rotation_of(*at);
    const std::string before = at->contains("input") ? at->value("input", "") : "";
    if (!turned || before.empty()) return std::nullopt;
    axes.C = axes.C * *turned;
    axes.channel = before;
  }
  return axes;
}

/// Names of blocks that a measurement, or what it stacks, is bound to.
void bound_blocks(const Json& measurement, std::set<std::string>& names) {
  for (const Json& block : measurement.value("blocks", Json::object()))
    if (block.is_string()) names.insert(block.get<std::string>());
  for (const Json& each : measurement.value("stack", Json::object())) bound_blocks(each, names);
}

/// Of one filter, the same lever arm once.
void add_of_filter(const Json& filter, const std::string& pointer, const Axes& axes, std::vector<StatedLeverArm>& all) {
  const Json derived = filter.value("derived", Json::object());
  for (const Json& measurement : filter.value("measurements", Json::object())) {
    std::set<std::string> names;
    bound_blocks(measurement, names);
    for (const auto& name : names) {
      const auto block = derived.find(name);
      if (block == derived.end() || !(is_type(*block, "lever_arm") || is_type(*block, "lever_arm_velocity"))) continue;
      const Json blocks = block->value("blocks", Json::object());
      const Json given = block->value("lever_arm", Json());
      if (blocks.contains("lever_arm") || !given.is_array() || given.size() != 3) continue;  // estimated, or in a state
      StatedLeverArm stated{join_pointer(pointer + "/derived", name), axes.channel, measurement.value("channel", ""),
                            Eigen::Vector3d::Zero(), axes.C};
      bool is_read = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto value = value_of(given[k]);
        is_read &= value.has_value();
        stated.value[static_cast<Eigen::Index>(k)] = value.value_or(0);
      }
      const bool is_known = std::ranges::any_of(all, [&](const StatedLeverArm& each) {
        return each.imu == stated.imu && each.gnss == stated.gnss && each.value == stated.value &&
               each.C_bs == stated.C_bs;
      });
      if (is_read && !is_known) all.push_back(std::move(stated));
    }
  }
}

}  // namespace

std::vector<StatedLeverArm> stated_lever_arms(const std::string& path, const LoadOptions& options) try {
  const Json config = Json::parse(Config::load(path, options).text());
  std::vector<StatedLeverArm> all;
  const Json filters = config.value("filters", Json::object());
  for (const auto& [name, filter] : filters.items())
    for (const Json& process : filter.value("process", Json::object())) {
      if (!process.contains("input")) continue;
      if (const auto axes = axes_of(config, process.at("input").get<std::string>()))
        add_of_filter(filter, join_pointer("/filters", name), *axes, all);
      break;
    }
  return all;
} catch (const Json::exception&) {
  return {};  // filters are not composed here: what is wrong with one, `check` reports
}

}  // namespace binnacle::command
