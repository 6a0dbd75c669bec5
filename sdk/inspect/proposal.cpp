// SPDX-License-Identifier: Apache-2.0
// A config of the channels that were looked at, with the remedies of the findings in it.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "inspect/inspect.hpp"

namespace binnacle::inspect {

namespace {

const std::vector<std::string> inertial_fields{"wx", "wy", "wz", "fx", "fy", "fz"};
const std::vector<std::string> fix_fields{"lat", "lon", "height", "vn", "ve", "vd"};

std::string relative(const std::string& path, const std::string& folder) {
  std::error_code error;
  const auto whole = std::filesystem::absolute(path);
  const auto from_folder = std::filesystem::proximate(whole, folder, error);
  return error || from_folder.empty() ? whole.string() : from_folder.string();
}

const char* kind_of(FieldKind kind) {
  return kind == FieldKind::rate ? "rate" : kind == FieldKind::increment ? "increment" : "level";
}

/// A text file as the `csv` source reads it: fields with a known name and unit.
Json text_source(const Channel& channel, const std::string& folder) {
  Json source = {{"type", "csv"}, {"path", relative(channel.path, folder)}};
  if (channel.delimiter != ',') source["delimiter"] = std::string(1, channel.delimiter);
  if (channel.has_decimal_commas) source["decimal"] = ",";
  if (channel.comment != "#") source["comment"] = channel.comment;
  if (!channel.has_header) source["header"] = false;
  source["time"] = {{"column", channel.time_column}};
  if (channel.has_dates)
    source["time"]["format"] = "iso8601";
  else
    source["time"]["unit"] = channel.time_unit;
  for (const Field& field : channel.fields) {
    if (field.unit.empty()) continue;
    source["columns"][field.name] = {{"column", field.column}, {"unit", field.unit}, {"kind", kind_of(field.kind)}};
  }
  return source;
}

/// "walk" of the receiver's channel "walk.imu"; a source with one channel has its name.
std::string source_name(const Channel& channel) {
  const std::string_view sources = "/sources/";
  if (channel.pointer.starts_with(sources)) return channel.pointer.substr(sources.size());
  return channel.name.substr(0, channel.name.find('.'));
}

Json source_of(const Channel& channel, const std::string& folder) {
  if (channel.type == "csv") return text_source(channel, folder);
  // Receivers count from 1980-01-06 unless the config says otherwise. Stated, so that `export` finds it.
  return {{"type", channel.type}, {"path", relative(channel.path, folder)}, {"week", 0}};
}

/// As RFC 7386 merges, but factors of one column multiply: a sign and a unit may both be wrong.
void merge(Json& target, const Json& patch) {
  for (const auto& [key, value] : patch.items()) {
    if (key == "scale" && target.contains("scale") && target["scale"].is_number() && value.is_number())
      target["scale"] = target["scale"].get<double>() * value.get<double>();
    else if (value.is_object() && target.contains(key) && target[key].is_object())
      merge(target[key], value);
    else
      target[key] = value;
  }
}

/// Changes of sources only; what is said of a channel that the config does not have is left out.
void apply(const Findings& findings, Json& config) {
  for (const Finding& found : findings) {
    if (!found.meaning.is_object() || !found.meaning.contains("sources")) continue;
    for (const auto& [name, patch] : found.meaning["sources"].items())
      if (config["sources"].contains(name)) merge(config["sources"][name], patch);
  }
}

const Channel* first(const std::vector<Channel>& channels, bool (*is_it)(const Channel&)) {
  const auto at = std::ranges::find_if(channels, is_it);
  return at == channels.end() ? nullptr : &*at;
}

bool is_full_fix(const Channel& channel) {
  return !channel.is_inertial() &&
         std::ranges::all_of(fix_fields, [&](const auto& name) { return channel.find(name); });
}

/// Which of the fields no channel has together, and which of them the best one lacks.
std::string lacking(const std::vector<Channel>& channels, const std::vector<std::string>& wanted) {
  std::string reason = "no channel has";
  for (const auto& field : wanted) reason += " " + field;
  std::size_t most = 0;
  std::string best;
  for (const Channel& channel : channels) {
    std::string missing;
    std::size_t there = 0;
    for (const auto& field : wanted) {
      if (channel.find(field))
        ++there;
      else
        missing += " " + field;
    }
    if (there <= most || missing.empty()) continue;
    most = there;
    best = fmt::format("; '{}' lacks{}", channel.name, missing);
  }
  return reason + best;
}

/// Deviations that a channel does not state: usual ones of a single receiver.
Json fix_of(const Channel& gnss) {
  Json position = {{"type", "position_fix"}, {"blocks", {{"position", "position"}}}};
  Json velocity = {{"type", "velocity_fix"}, {"blocks", {{"velocity", "velocity"}}}};
  if (!gnss.find("position_sd_n"))
    position["sigma"] = {"3 m", "3 m", "5 m"};
  else
    position["floor"] = "0.5 m";
  if (!gnss.find("velocity_sd_n"))
    velocity["sigma"] = "0.2 m/s";
  else
    velocity["floor"] = "0.03 m/s";
  return {{"channel", gnss.name}, {"stack", {{"position", position}, {"velocity", velocity}}}};
}

/// An inertial navigation filter with position and velocity of the receiver. Noises are usual ones of a MEMS sensor: these
/// data do not show them, `allan` does.
Json filter_of(const std::string& imu, const Channel& gnss) {
  Json blocks = {{"position",
                  {{"type", "position"},
                   {"init", {{"channel", gnss.name}, {"max_age", "1 s"}}},
                   {"sigma", {"3 m", "3 m", "5 m"}}}},
                 {"velocity",
                  {{"type", "velocity"}, {"init", {{"channel", gnss.name}, {"max_age", "1 s"}}}, {"sigma", "0.3 m/s"}}},
                 {"attitude", {{"type", "attitude"}, {"init", {{"channel", "alignment"}, {"max_age", "2 s"}}}}},
                 {"gyro_bias",
                  {{"type", "vector"}, {"size", 3}, {"unit", "rad/s"}, {"init", {{"channel", "alignment.gyro_bias"}}}}},
                 {"accel_bias", {{"type", "vector"}, {"size", 3}, {"unit", "m/s^2"}, {"sigma", "0.2 m/s^2"}}}};
  Json strapdown = {{"type", "phi_error"},
                    {"input", imu},
                    {"blocks",
                     {{"position", "position"},
                      {"velocity", "velocity"},
                      {"attitude", "attitude"},
                      {"gyro_bias", "gyro_bias"},
                      {"accel_bias", "accel_bias"}}},
                    {"gyro_noise", "1e-3 rad/s/sqrt(Hz)"},
                    {"accel_noise", "0.05 m/s^2/sqrt(Hz)"}};
  return {{"blocks", blocks},
          {"process",
           {{"strapdown", strapdown},
            {"gyro_drift", {{"type", "random_walk"}, {"blocks", {{"x", "gyro_bias"}}}, {"q", "1e-5 rad/s/sqrt(s)"}}},
            {"accel_drift",
             {{"type", "random_walk"}, {"blocks", {{"x", "accel_bias"}}}, {"q", "1e-3 m/s^2/sqrt(s)"}}}}},
          {"measurements", {{"fix", fix_of(gnss)}}}};
}

Json whole_config(const Inspection& inspection, const Channel& imu, const Channel& gnss, const std::string& folder) {
  Json config = {{"binnacle", 1},
                 {"title", "Proposed by binnacle inspect; noises are those of a typical MEMS sensor, not measured"}};
  for (const Channel* channel : {&imu, &gnss}) config["sources"][source_name(*channel)] = source_of(*channel, folder);
  apply(inspection.findings, config);
  std::string input = imu.name;
  for (const Finding& found : inspection.findings)
    if (found.kind == "mounting" && found.channel == imu.name && found.meaning.is_object()) {
      merge(config, found.meaning);
      input = found.meaning["transforms"].begin().key();
    }
  config["transforms"]["alignment"] = {{"type", "in_motion_alignment"},
                                       {"inputs", {{"imu", input}, {"gnss", gnss.name}}}};
  config["filters"] = {{"ins", filter_of(input, gnss)}};
  config["record"] = {{"every", "0.5 s"}};
  return config;
}

}  // namespace

Proposal propose(const Inspection& inspection, const std::string& folder, const std::string& base) {
  if (!base.empty()) {
    Json config = {{"extends", relative(base, folder)}};
    for (const Channel& channel : inspection.channels) config["sources"][source_name(channel)] = Json::object();
    apply(inspection.findings, config);
    return {config, ""};
  }
  const Channel* const imu = first(inspection.channels, [](const Channel& each) { return each.is_inertial(); });
  const Channel* const gnss = first(inspection.channels, is_full_fix);
  if (!imu) return {nullptr, lacking(inspection.channels, inertial_fields)};
  if (!gnss) return {nullptr, lacking(inspection.channels, fix_fields)};
  return {whole_config(inspection, *imu, *gnss, folder), ""};
}

}  // namespace binnacle::inspect
