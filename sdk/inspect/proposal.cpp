// SPDX-License-Identifier: Apache-2.0
// A config of the channels that were looked at, with the remedies of the findings in it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

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

/// What of a finding is in the config: "delay: /sources/gnss/time/offset = 18.000 s".
std::string note_of(const Finding& found) {
  std::string text;
  const Json changes = found.meaning.flatten();
  for (const auto& [pointer, value] : changes.items())
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", pointer,
                        value.is_string() ? value.get<std::string>() : value.dump());
  return found.kind + ": " + text;
}

/// Changes of sources only; what is said of a channel that the config does not have is left out.
void apply(const Findings& findings, Json& config, std::vector<std::string>& notes) {
  for (const Finding& found : findings) {
    if (!found.meaning.is_object() || !found.meaning.contains("sources")) continue;
    bool is_used = false;
    for (const auto& [name, patch] : found.meaning["sources"].items())
      if (config["sources"].contains(name)) {
        merge(config["sources"][name], patch);
        is_used = true;
      }
    if (is_used) notes.push_back(note_of(found));
  }
}

const Channel* first(const std::vector<Channel>& channels, bool (*is_it)(const Channel&)) {
  const auto at = std::ranges::find_if(channels, is_it);
  return at == channels.end() ? nullptr : &*at;
}

bool is_full_fix(const Channel& channel) {
  return !channel.is_inertial() && !channel.is_reference() &&
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

/// Of the channel's findings of this kind, 0 where there is none.
double value_of(const Inspection& inspection, const Channel& channel, std::string_view kind) {
  const auto at = std::ranges::find_if(inspection.findings, [&](const Finding& found) {
    return found.channel == channel.name && found.kind == kind;
  });
  return at == inspection.findings.end() ? 0 : at->value;
}

/// Deviations that a channel does not state: usual ones of a single receiver, or its scatter at rest where that is more.
Json fix_of(const Inspection& inspection, const Channel& gnss, std::vector<std::string>& notes) {
  Json position = {{"type", "position_fix"}, {"blocks", {{"position", "antenna"}, {"bias", "receiver_bias"}}}};
  Json velocity = {{"type", "velocity_fix"}, {"blocks", {{"velocity", "antenna_velocity"}}}};
  const bool states_position = gnss.find("position_sd_n") != nullptr,
             states_velocity = gnss.find("velocity_sd_n") != nullptr;
  if (states_position) {
    position["floor"] = "0.5 m";
  } else {
    const double seen = value_of(inspection, gnss, "position_noise"), high = value_of(inspection, gnss, "height_noise");
    const std::string level = fmt::format("{:.2g} m", std::max(3.0, seen)),
                      vertical = fmt::format("{:.2g} m", std::max(5.0, high));
    position["sigma"] = {level, level, vertical};
    notes.push_back(
        fmt::format("fixes: sigma of the position {}, of the height {}: usual of a single receiver{}; "
                    "replace them by your receiver's",
                    level, vertical, seen > 3 || high > 5 ? ", and more where they scatter so at rest" : ""));
  }
  if (states_velocity) {
    velocity["floor"] = "0.03 m/s";
  } else {
    const double seen = value_of(inspection, gnss, "velocity_noise");
    velocity["sigma"] = fmt::format("{:.2g} m/s", std::max(0.2, seen));
    notes.push_back(fmt::format("fixes: sigma of the velocity {}: {}; replace it by your receiver's",
                                velocity["sigma"].get<std::string>(),
                                seen > 0.2 ? "the scatter at rest" : "usual of a single receiver"));
  }
  notes.push_back("fixes: errors that last for a minute, 1 m, 1 m, 2 m (receiver_bias): usual of a single receiver");
  return {{"channel", gnss.name}, {"stack", {{"position", position}, {"velocity", velocity}}}, {"gate", 0.9999}};
}

/// Sigma of a receiver's errors that last: reflections, the ionosphere.
const Json lasting = {"1 m", "1 m", "2 m"};
constexpr const char* gyro_drift = "1e-5 rad/s/sqrt(s)";
constexpr const char* accel_drift = "1e-3 m/s^2/sqrt(s)";

/// Usual ones of a MEMS sensor, or what this one has at rest. While it moves there is more (vibration, scale errors): never less than a
/// tenth of the usual ones.
struct Noise {
  double gyro = 1e-3, force = 0.05;  // rad/s/sqrt(Hz), m/s^2/sqrt(Hz)

  // In the units of data sheets.
  std::string gyro_text() const { return in_data_sheet(gyro, "deg/sqrt(h)"); }
  std::string force_text() const { return in_data_sheet(force, "m/s/sqrt(h)"); }
  static std::string in_data_sheet(double density, const std::string& unit) {
    return fmt::format("{:.3g} {}", density * 60 * (unit.starts_with("deg") ? 57.29577951308232 : 1), unit);
  }
};
Noise noise_of(const Inspection& inspection, std::vector<std::string>& notes) {
  Noise noise;
  if (!inspection.start) {
    notes.push_back(
        fmt::format("noises: gyro {}, accelerometer {}, for a MEMS sensor that vibrates, as the record does not begin "
                    "with ten seconds of rest and then a drive forward",
                    noise.gyro_text(), noise.force_text()));
    return noise;
  }
  const Start& start = *inspection.start;
  const Noise at_rest{start.gyro_noise, start.force_noise}, least{0.1 * noise.gyro, 0.1 * noise.force};
  noise = {std::max(least.gyro, at_rest.gyro), std::max(least.force, at_rest.force)};
  const auto origin = [](bool is_least, const std::string& seen) {
    return is_least ? "at rest it is " + seen + "; motion adds noise, so this is the least that is written"
                    : "that at rest";
  };
  notes.push_back(fmt::format("noise of the gyro: {} ({})", noise.gyro_text(),
                              origin(noise.gyro > at_rest.gyro, at_rest.gyro_text())));
  notes.push_back(fmt::format("noise of the accelerometer: {} ({})", noise.force_text(),
                              origin(noise.force > at_rest.force, at_rest.force_text())));
  notes.push_back(fmt::format(
      "random walk of the biases: gyro {}, accelerometer {}, usual of a MEMS sensor; 'tune' can estimate them",
      gyro_drift, accel_drift));
  return noise;
}

/// Of the antenna, in the vehicle's axes: what is determined, and zero else.
Eigen::Vector3d lever_arm_of(const Inspection& inspection, std::vector<std::string>& notes) {
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  std::string known, open;
  constexpr const char* names[] = {"forward", "right", "down"};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto at = std::ranges::find_if(inspection.findings, [&](const Finding& found) {
      return found.kind == "lever_arm" && found.field == names[k] && found.severity == Severity::finding;
    });
    if (at == inspection.findings.end()) {
      open += std::string(open.empty() ? "" : ", ") + names[k];
      continue;
    }
    lever_arm[static_cast<Eigen::Index>(k)] = 0.01 * std::round(100 * at->value);
    known += fmt::format("{}{} {:.2f} +- {:.2f} m", known.empty() ? "" : ", ", names[k], at->value, at->sigma);
  }
  if (!known.empty()) notes.push_back("lever arm, by turning: " + known + "; a measured one is better");
  if (!open.empty())
    notes.push_back("lever arm " + open +
                    ": zero, for the data do not show it; measure it from the IMU to the antenna");
  return lever_arm;
}

Json lengths(const Eigen::Vector3d& meters) {
  Json all = Json::array();
  for (const double each : meters) all.push_back(each == 0 ? Json(0) : Json(fmt::format("{:.2f} m", each)));
  return all;
}

/// An inertial navigation filter with position and velocity of the receiver's antenna.
Json filter_of(const std::string& imu, const Channel& gnss, const Noise& noise, const Eigen::Vector3d& to_antenna,
               const Json& fix) {
  const Json lever_arm = lengths(to_antenna);
  // The position starts at the antenna's.
  const std::string level = fmt::format("{:.2g} m", std::hypot(3, to_antenna.norm())),
                    vertical = fmt::format("{:.2g} m", std::hypot(5, to_antenna.norm()));
  Json blocks = {{"position",
                  {{"type", "position"},
                   {"init", {{"channel", gnss.name}, {"max_age", "1 s"}}},
                   {"sigma", {level, level, vertical}}}},
                 {"velocity",
                  {{"type", "velocity"}, {"init", {{"channel", gnss.name}, {"max_age", "1 s"}}}, {"sigma", "0.3 m/s"}}},
                 {"attitude", {{"type", "attitude"}, {"init", {{"channel", "alignment"}, {"max_age", "2 s"}}}}},
                 {"gyro_bias",
                  {{"type", "vector"}, {"size", 3}, {"unit", "rad/s"}, {"init", {{"channel", "alignment.gyro_bias"}}}}},
                 {"accel_bias", {{"type", "vector"}, {"size", 3}, {"unit", "m/s^2"}, {"sigma", "0.2 m/s^2"}}},
                 {"receiver_bias",
                  {{"type", "vector"},
                   {"size", 3},
                   {"unit", "m"},
                   {"components", {"north", "east", "down"}},
                   {"sigma", lasting}}}};
  Json derived = {{"antenna",
                   {{"type", "lever_arm"},
                    {"blocks", {{"position", "position"}, {"attitude", "attitude"}}},
                    {"lever_arm", lever_arm}}},
                  {"antenna_velocity",
                   {{"type", "lever_arm_velocity"},
                    {"blocks", {{"velocity", "velocity"}, {"attitude", "attitude"}, {"gyro_bias", "gyro_bias"}}},
                    {"lever_arm", lever_arm}}}};
  Json strapdown = {{"type", "phi_error"},
                    {"input", imu},
                    {"blocks",
                     {{"position", "position"},
                      {"velocity", "velocity"},
                      {"attitude", "attitude"},
                      {"gyro_bias", "gyro_bias"},
                      {"accel_bias", "accel_bias"}}},
                    {"gyro_noise", noise.gyro_text()},
                    {"accel_noise", noise.force_text()}};
  return {{"blocks", blocks},
          {"derived", derived},
          {"process",
           {{"strapdown", strapdown},
            {"gyro_drift", {{"type", "random_walk"}, {"blocks", {{"x", "gyro_bias"}}}, {"q", gyro_drift}}},
            {"accel_drift", {{"type", "random_walk"}, {"blocks", {{"x", "accel_bias"}}}, {"q", accel_drift}}},
            {"receiver_drift",
             {{"type", "gauss_markov"}, {"blocks", {{"x", "receiver_bias"}}}, {"tau", "60 s"}, {"sigma", lasting}}}}},
          {"measurements", {{"fix", fix}}}};
}

/// By rest and the course where the record begins so; else by motion alone. `mounting_error`: of the axes [deg].
Json alignment_of(const Inspection& inspection, const std::string& input, const Channel& gnss, double mounting_error,
                  std::vector<std::string>& notes) {
  const Json inputs = {{"imu", input}, {"gnss", gnss.name}};
  if (!inspection.start || !std::isfinite(mounting_error)) {
    notes.push_back("alignment: in motion, from velocities alone");
    return {{"type", "in_motion_alignment"}, {"inputs", inputs}};
  }
  const Start& start = *inspection.start;
  notes.push_back(fmt::format(
      "alignment: roll and pitch from {:.0f} s of rest, yaw from the course once it drives; estimates begin there",
      start.seconds));
  Json alignment = {{"type", "coarse_alignment"},
                    {"inputs", inputs},
                    {"heading", "course"},
                    {"accelerometer_bias", "20 mg"}};
  // Its limits for rest, where a sensor at rest would be beyond them.
  if (3 * start.force_scatter > 0.15)
    alignment["max_specific_force_sd"] = fmt::format("{:.2g} m/s^2", 3 * start.force_scatter);
  if (3 * start.gyro_scatter > 0.0087) alignment["max_rate_sd"] = fmt::format("{:.2g} rad/s", 3 * start.gyro_scatter);
  alignment["sigma_heading"] = fmt::format("{:.2g} deg", std::max(1.0, 2 * mounting_error));
  return alignment;
}

/// A text file that calls itself truth or reference, with positions: the filter's errors are against it.
void add_reference(const Inspection& inspection, const std::string& folder, Json& config,
                   std::vector<std::string>& notes) {
  struct Block {
    const char* name;
    std::vector<std::string> fields;
  };
  const Block known[] = {{"ins/position", {"lat", "lon", "height"}},
                         {"ins/velocity", {"vn", "ve", "vd"}},
                         {"ins/attitude", {"roll", "pitch", "yaw"}}};
  for (const Channel& channel : inspection.channels) {
    if (!channel.is_reference() || channel.type != "csv") continue;
    Json blocks = Json::object();
    for (const Block& block : known)
      if (std::ranges::all_of(block.fields, [&](const auto& field) {
            const Field* const there = channel.find(field);
            // An angle without a unit may be either: it is no reference.
            return there && !there->unit.empty() && !(there->is_guessed && block.fields.front() == "roll");
          }))
        blocks[block.name] = block.fields;
    if (!blocks.contains("ins/position")) continue;
    config["sources"][source_name(channel)] = source_of(channel, folder);
    config["reference"] = Json::array({{{"channel", channel.name}, {"blocks", blocks}}});
    notes.push_back("reference: " + channel.name + ", by its name");
    return;
  }
}

Json whole_config(const Inspection& inspection, const Channel& imu, const Channel& gnss, const std::string& folder,
                  std::vector<std::string>& notes) {
  Json config = {{"binnacle", 1},
                 {"title", inspection.start
                               ? "Proposed by binnacle inspect; noises of the inertial sensor by its rest at the begin"
                               : "Proposed by binnacle inspect; noises for a MEMS sensor that vibrates, not measured"}};
  for (const Channel* channel : {&imu, &gnss}) config["sources"][source_name(*channel)] = source_of(*channel, folder);
  apply(inspection.findings, config, notes);
  std::string input = imu.name;
  double mounting_error = std::numeric_limits<double>::quiet_NaN();
  for (const Finding& found : inspection.findings)
    if (found.kind == "mounting" && found.channel == imu.name && found.meaning.is_object()) {
      merge(config, found.meaning);
      notes.push_back(note_of(found));
      input = found.meaning["transforms"].begin().key();
      mounting_error = found.value;
    }
  const Noise noise = noise_of(inspection, notes);
  config["transforms"]["alignment"] = alignment_of(inspection, input, gnss, mounting_error, notes);
  const Eigen::Vector3d lever_arm = lever_arm_of(inspection, notes);
  config["filters"] = {{"ins", filter_of(input, gnss, noise, lever_arm, fix_of(inspection, gnss, notes))}};
  notes.push_back("initial position: sigma of a fix and the lever arm together, for it starts at the antenna");
  notes.push_back("gate: 0.9999, as in the configs of the manual");
  add_reference(inspection, folder, config, notes);
  config["record"] = {{"every", "0.5 s"}};
  return config;
}

}  // namespace

Proposal propose(const Inspection& inspection, const std::string& folder, const std::string& base) {
  if (!base.empty()) {
    Json config = {{"extends", relative(base, folder)}};
    for (const Channel& channel : inspection.channels) config["sources"][source_name(channel)] = Json::object();
    Proposal proposal;
    apply(inspection.findings, config, proposal.notes);
    proposal.config = std::move(config);
    return proposal;
  }
  const Channel* const imu = first(inspection.channels, [](const Channel& each) { return each.is_inertial(); });
  const Channel* const gnss = first(inspection.channels, is_full_fix);
  if (!imu) return {nullptr, lacking(inspection.channels, inertial_fields), {}};
  if (!gnss) return {nullptr, lacking(inspection.channels, fix_fields), {}};
  Proposal proposal;
  proposal.config = whole_config(inspection, *imu, *gnss, folder, proposal.notes);
  return proposal;
}

}  // namespace binnacle::inspect
