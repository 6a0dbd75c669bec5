// SPDX-License-Identifier: Apache-2.0
#include "oxts_source.hpp"

#include <cstdio>

#include "binnacle/parameters.hpp"
#include "text/in_order.hpp"
#include "text/text_file.hpp"

namespace binnacle::kitti {

namespace fs = std::filesystem;

namespace {

std::string data_name(std::size_t index) {
  char text[32];
  std::snprintf(text, sizeof text, "%010zu.txt", index);
  return text;
}

}  // namespace

ComponentSpec OxtsSource::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "oxts";
  spec.summary = "inertial and navigation data of an OXTS unit, from the text folders of KITTI's raw recordings";
  spec.source =
      "A. Geiger et al., Vision meets robotics: the KITTI dataset, IJRR 32 (2013); dataformat.txt of its oxts folders";
  spec.parameters = {
      path("path").required().about("folder oxts, with timestamps.txt and data, or its parent folder"),
      time("zone").defaults("0").about("clock of the time stamps minus UTC"),
      time("max_gap").above(0).defaults("\"1 s\"").about(
          "longest step between time stamps; after a longer step the inertial data have no interval"),
      choice("on_error", {"skip", "stop"})
          .defaults("\"skip\"")
          .about("skip: invalid time stamps or files are skipped, counted and reported; stop: they end the run")};
  for (ParameterSpec& each : civil_time::UtcClock::parameters()) spec.parameters.push_back(std::move(each));
  spec.example = R"json({"path": "oxts", "week": 1655})json";
  const std::string row =
      "49.0150 8.4340 115.0 0.01 -0.02 1.5 8.0 0.5 8.0 0.1 0.02 0.1 0.2 9.81 0.1 0.2 9.81 0.001 0.002 0.003 0.001 "
      "0.002 0.003 0.05 0.02 4 9 4 4 0\\n";
  spec.surroundings =
      R"json({"files": {"oxts/timestamps.txt": "2011-09-30 12:30:00.000000000\n2011-09-30 12:30:00.010000001\n", )json"
      R"json("oxts/data/0000000000.txt": ")json" +
      row + R"json(", "oxts/data/0000000001.txt": ")json" + row + R"json("}})json";
  return spec;
}

OxtsSource::OxtsSource(const Binding& binding)
    : folder_(binding.parameters().text("path")),
      clock_(binding.parameters()),
      zone_(binding.parameters().time("zone")),
      max_gap_(binding.parameters().time("max_gap")),
      on_invalid_(binding.parameters().text("on_error") == "stop" ? text_file::OnInvalid::error
                                                                  : text_file::OnInvalid::skip) {
  if (!fs::exists(folder_ / "timestamps.txt") && fs::exists(folder_ / "oxts" / "timestamps.txt")) folder_ /= "oxts";
  if (!fs::exists(folder_ / "timestamps.txt"))
    throw ComponentError::in_data("holds no timestamps.txt, and no oxts/timestamps.txt", folder_.string(), 0, "B060");
  if (!fs::is_directory(folder_ / "data"))
    throw ComponentError::in_data("holds no folder data", folder_.string(), 0, "B060");
  declare_channels();
}

void OxtsSource::declare_channels() {
  using field::level;
  using field::rate;
  ChannelDeclaration solution, imu("imu");
  position_ = solution.carries(level("lat", "rad").about("geodetic latitude"),
                               level("lon", "rad").about("longitude, east positive"),
                               level("height", "m").about("as the unit gives it"));
  velocity_ = solution.carries(level("vn", "m/s").about("north"), level("ve", "m/s"), level("vd", "m/s").about("down"));
  attitude_ = solution.carries(level("roll", "rad"), level("pitch", "rad").about("front up"),
                               level("yaw", "rad").about("from true north, clockwise"));
  position_sd_ =
      solution.carries(level("position_sd_n", "m"), level("position_sd_e", "m"), level("position_sd_d", "m"));
  velocity_sd_ =
      solution.carries(level("velocity_sd_n", "m/s"), level("velocity_sd_e", "m/s"), level("velocity_sd_d", "m/s"));
  state_ = solution.carries(level("navigation_status", "1"), level("satellites", "1"), level("position_mode", "1"),
                            level("velocity_mode", "1"), level("orientation_mode", "1"));
  inertial_ = imu.carries(rate("wx", "rad/s").about("forward, right, down"), rate("wy", "rad/s"), rate("wz", "rad/s"),
                          rate("fx", "m/s^2").about("specific force"), rate("fy", "m/s^2"), rate("fz", "m/s^2"));
  imu.max_interval = max_gap_;
  solution_ = declaration_.emits(std::move(solution));
  imu_ = declaration_.emits(std::move(imu));
  next_ = declaration_.keeps<std::uint64_t>();
}

/// By line; no_time where it is none.
std::vector<Time> OxtsSource::read_stamps(text_file::Faults& faults) const {
  std::vector<Time> stamps;
  try {
    text_file::LineReader reader((folder_ / "timestamps.txt").string());
    for (std::string_view line; reader.next(line);) {
      const auto utc = read_stamp(line);
      if (!utc) faults.add("B062", reader.line(), "stamp", "'" + std::string(line.substr(0, 40)) + "' is not a time");
      stamps.push_back(utc ? clock_.time(*utc) - zone_ : no_time);
    }
  } catch (const text_file::FileFault& fault) {
    faults.add(fault.code, 0, "rest of the file", fault.what());
  }
  return stamps;
}

bool OxtsSource::read_data(std::size_t index, int line, text_file::Faults& faults, OxtsRecord& record) const {
  const fs::path file = folder_ / "data" / data_name(index);
  const std::string name = "data/" + data_name(index);
  if (!fs::exists(file)) {
    faults.add("B065", line, "stamp", "there is no " + name);
    return false;
  }
  try {
    text_file::LineReader reader(file.string());
    std::string_view text;
    const bool has_line = reader.next(text);
    const std::string flaw = has_line ? read_record(text, record) : "it is empty";
    if (!flaw.empty()) {
      faults.add("B062", line, "data file", name + ": " + flaw);
      return false;
    }
    if (reader.next(text)) {
      faults.add("B062", line, "data file", name + ": it has more than one line");
      return false;
    }
  } catch (const text_file::FileFault& fault) {
    faults.add(fault.code, line, "data file", name + ": " + fault.what());
    return false;
  }
  return true;
}

/// Files that no stamp belongs to.
void OxtsSource::report_strangers(std::size_t stamps, Reporter& reporter) const {
  std::size_t strangers = 0;
  std::string first;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator(folder_ / "data", fault)) {
    const std::string name = entry.path().filename().string();
    const bool is_numbered = name.size() == 14 && name.ends_with(".txt") && name.find_first_not_of("0123456789") == 10;
    if (is_numbered && std::stoull(name.substr(0, 10)) < stamps) continue;
    if (strangers++ == 0 || name < first) first = name;
  }
  if (strangers == 0) return;
  reporter.warn("B065", (folder_ / "data").string(), 0,
                std::to_string(strangers) + " files have no stamp and were left out, as " + first);
}

void OxtsSource::open(Reporter& reporter) {
  const std::string stamps_path = (folder_ / "timestamps.txt").string();
  text_file::Faults faults(stamps_path, on_invalid_, reporter);
  const std::vector<Time> stamps = read_stamps(faults);
  std::vector<Row> rows;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    Row row{stamps[i], static_cast<int>(i) + 1, {}};
    if (stamps[i] != no_time && read_data(i, row.line, faults, row.record)) rows.push_back(std::move(row));
  }
  rows_ = text_file::in_order(
      std::move(rows), [](const Row& row) { return row.t; },
      [&](const Row& row, const Row&) { faults.add("B063", row.line, "stamp", "it is not in order of time"); });
  faults.report();
  report_strangers(stamps.size(), reporter);
  if (rows_.empty()) throw ComponentError::in_data("no stamp has a data file that can be read", stamps_path, 0, "B066");
}

SourceStatus OxtsSource::next(const MemoryView& bytes, SourceOutput& output) const {
  std::uint64_t& next = bytes[next_];
  if (next >= 2 * rows_.size()) return SourceStatus::end;
  const auto index = static_cast<std::size_t>(next / 2);
  if (next++ % 2 == 0)
    write_imu(index, output.on(imu_));
  else
    write_solution(rows_[index], output.on(solution_));
  return SourceStatus::sample;
}

void OxtsSource::write_imu(std::size_t index, SampleWriter& out) const {
  const Row& row = rows_[index];
  out.t = row.t;
  if (index > 0 && row.t - rows_[index - 1].t <= max_gap_) out.t0 = rows_[index - 1].t;
  out[inertial_] << row.record.w_b, row.record.f_b;
}

void OxtsSource::write_solution(const Row& row, SampleWriter& out) const {
  const OxtsRecord& r = row.record;
  out.t = row.t;
  out[position_] = r.lla;
  out[velocity_] = r.v_n;
  out[attitude_] = r.attitude;
  out[position_sd_].setConstant(r.position_sd);
  out[velocity_sd_].setConstant(r.velocity_sd);
  for (std::size_t i = 0; i < r.state.size(); ++i) out[state_][static_cast<Eigen::Index>(i)] = r.state[i];
}

}  // namespace binnacle::kitti
