// SPDX-License-Identifier: Apache-2.0
#include "pos_source.hpp"

#include <cmath>
#include <cstdio>

#include "binnacle/parameters.hpp"
#include "text/in_order.hpp"
#include "text/text_file.hpp"

namespace binnacle::rtklib {

namespace {

std::string time_text(Time t) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", seconds(t));
  return text;
}

bool is_comment(std::string_view line) { return line.starts_with('%') || line.starts_with('#'); }

bool is_blank(std::string_view line) { return line.find_first_not_of(" \t\r") == line.npos; }

}  // namespace

ComponentSpec PosSource::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "rtklib_pos";
  spec.summary = "positions and velocities from solution files of RTKLIB (.pos), in any format";
  spec.source = "RTKLIB ver. 2.4.2 manual, appendix B.1";
  spec.parameters = {path("path").about("complete solution file, plain or gzipped; alternative to 'from'"),
                     choice("coordinates", {"degrees", "dms", "ecef", "baseline"})
                         .about("coordinates of a file without a header: latitude, longitude, height in degrees, or in "
                                "degrees, minutes and seconds; x, y, z; or east, north, up from the base station"),
                     choice("time_system", {"gpst", "utc", "jst"}).about("time scale of a file without a header"),
                     boolean("velocity")
                         .defaults("false")
                         .about("whether a file without a header, or live input, has velocity columns"),
                     object("reference",
                            {parameter::number("lat", "rad").required().about("geodetic latitude"),
                             parameter::number("lon", "rad").required().about("longitude, east positive"),
                             parameter::number("height", "m").required().about("height above the ellipsoid")})
                         .about("position of the base station, if the header of a file of baselines does not give it"),
                     parameter::number("geoid_separation", "m")
                         .about("height of the geoid above the ellipsoid, for heights above sea level")};
  for (ParameterSpec& each : line_input::Lines::parameters()) spec.parameters.push_back(std::move(each));
  for (ParameterSpec& each : civil_time::UtcClock::parameters()) spec.parameters.push_back(std::move(each));
  spec.example = R"json({"path": "track.pos", "week": 2381})json";
  spec.surroundings =
      R"json({"files": {"track.pos": "%  GPST latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio\n2025/08/28 17:30:40.000 40.096691600 -105.147166500 1601.4350 1 25 0.0099 0.0099 0.0100 0.0010 -0.0020 0.0000 0.00 3.0\n2025/08/28 17:30:41.000 40.096691700 -105.147166400 1601.4400 1 25 0.0099 0.0099 0.0100 0.0010 -0.0020 0.0000 0.00 3.0\n"}})json";
  return spec;
}

PosSource::PosSource(const Binding& binding) : clock_(binding.parameters()) {
  const Parameters& p = binding.parameters();
  read_parameters(p);
  declaration_.live = line_input::is_live(p);
  if (declaration_.live) {
    live_ = std::make_unique<Live>(p);
    layout_ = stated_.value_or(Layout{});
    layout_.columns = standard_columns(p.boolean("velocity"));
  } else {
    path_ = p.text("path");
    peek();
  }
  declare_channel();
}

void PosSource::read_parameters(const Parameters& p) {
  if (p.text("on_error") == "stop") on_invalid_ = text_file::OnInvalid::error;
  if (p.has("geoid_separation")) place_.geoid_separation = p.number("geoid_separation");
  if (p.has("reference")) {
    const Parameters r = p.object("reference");
    place_.reference = Eigen::Vector3d(r.number("lat"), r.number("lon"), r.number("height"));
  }
  if (p.has("coordinates") != p.has("time_system"))
    throw ComponentError("of a file without a header both 'coordinates' and 'time_system' are needed",
                         p.has("coordinates") ? "/coordinates" : "/time_system");
  if (!p.has("coordinates")) return;
  const std::string &coordinates = p.text("coordinates"), &time = p.text("time_system");
  stated_.emplace();
  stated_->coordinates = coordinates == "degrees" ? Coordinates::degrees
                         : coordinates == "dms"   ? Coordinates::dms
                         : coordinates == "ecef"  ? Coordinates::ecef
                                                  : Coordinates::baseline;
  stated_->time = time == "gpst" ? TimeSystem::gpst : time == "utc" ? TimeSystem::utc : TimeSystem::jst;
  stated_->columns = standard_columns(p.boolean("velocity"));
}

/// As far as the first solution, to know which fields there are.
void PosSource::peek() {
  try {
    text_file::LineReader reader(path_);
    Header header;
    for (std::string_view line; reader.next_filled(line);) {
      if (is_blank(line)) continue;
      if (!is_comment(line)) {
        if (!header.layout() && !stated_)
          throw ComponentError::in_data(line.starts_with('$')
                                            ? "holds sentences of NMEA: the source 'nmea' reads them"
                                            : "no header gives the columns: is it a solution file? Without a header, "
                                              "give 'coordinates' and 'time_system'",
                                        path_, reader.line(), "B062");
        break;
      }
      if (const std::string flaw = header.take(line); !flaw.empty())
        throw ComponentError::in_data("the header cannot be used: " + flaw, path_, reader.line(), "B062");
    }
    layout_ = header.layout() ? *header.layout() : stated_.value_or(Layout{});
  } catch (const text_file::FileFault& fault) {
    throw ComponentError::in_data(fault.what(), path_, 0, fault.code);
  }
}

void PosSource::declare_channel() {
  using field::level;
  ChannelDeclaration channel;
  has_relative_ = layout_.coordinates == Coordinates::baseline;
  has_position_ = !has_relative_ || place_.reference || layout_.reference;
  if (has_position_)
    position_ = channel.carries(level("lat", "rad").about("geodetic latitude"),
                                level("lon", "rad").about("longitude, east positive"),
                                level("height", "m").about("height above the ellipsoid"));
  if (has_relative_)
    relative_ = channel.carries(level("relative_n", "m").about("from the base station, north"),
                                level("relative_e", "m"), level("relative_d", "m"));
  const Columns& c = layout_.columns;
  if (c.has_position_sd()) {
    position_sd_ =
        channel.carries(level("position_sd_n", "m"), level("position_sd_e", "m"), level("position_sd_d", "m"));
    for (const char* name : {"position.n", "position.e", "position.d"}) channel.covariance.push_back({name, "m"});
  }
  if (c.has_velocity())
    velocity_ = channel.carries(level("vn", "m/s"), level("ve", "m/s"), level("vd", "m/s").about("down"));
  if (c.has_velocity_sd()) {
    velocity_sd_ =
        channel.carries(level("velocity_sd_n", "m/s"), level("velocity_sd_e", "m/s"), level("velocity_sd_d", "m/s"));
    if (c.has_position_sd())
      for (const char* name : {"velocity.n", "velocity.e", "velocity.d"}) channel.covariance.push_back({name, "m/s"});
  }
  figures_ = channel.carries(level("quality", "1").about("1 fix, 2 float, 3 SBAS, 4 DGPS, 5 single, 6 PPP"),
                             level("satellites", "1"), level("age", "s").about("of corrections"),
                             level("ratio", "1").about("of the ambiguities' validation"));
  channel_ = declaration_.emits(std::move(channel));
  next_ = declaration_.keeps<std::uint64_t>();
}

const Layout& PosSource::layout_for(const Header& header) const {
  if (!header.layout()) {
    if (!stated_) throw BadLine{"no header has given the columns; give 'coordinates' and 'time_system'"};
    return *stated_;
  }
  const Layout& layout = *header.layout();
  // The channel has the fields of the first header: another one may only differ in form.
  const bool has_same_fields = layout.columns.has_velocity() == layout_.columns.has_velocity() &&
                               layout.columns.has_position_sd() == layout_.columns.has_position_sd() &&
                               layout.columns.has_velocity_sd() == layout_.columns.has_velocity_sd() &&
                               (layout.coordinates == Coordinates::baseline) == has_relative_;
  if (!has_same_fields) throw BadLine{"the header above it names other columns than the channel has"};
  return layout;
}

std::optional<Solution> PosSource::take(std::string_view line, Header& header) const {
  if (is_blank(line)) return {};
  if (is_comment(line)) {
    if (const std::string flaw = header.take(line); !flaw.empty())
      throw BadLine{"as a header it cannot be used: " + flaw};
    return {};
  }
  return read_solution(line, layout_for(header), place_, clock_);
}

void PosSource::open(Reporter& reporter) {
  if (live_) {
    live_->header = {};
    live_->newest = no_time;
    return live_->lines.open(reporter);
  }
  text_file::Faults faults(path_, on_invalid_, reporter);
  read_file(faults, reporter);
  faults.report();
  if (rows_.empty()) throw ComponentError::in_data("no line is a solution", path_, 0, "B066");
}

void PosSource::read_file(text_file::Faults& faults, Reporter& reporter) {
  std::vector<Row> rows;
  std::int64_t none = 0;
  try {
    text_file::LineReader reader(path_);
    Header header;
    for (std::string_view line; reader.next_filled(line);) try {
        auto solution = take(line, header);
        if (!solution) continue;
        if (solution->quality == 0) {
          ++none;
          continue;
        }
        rows.push_back({std::move(*solution), reader.line()});
      } catch (const BadLine& bad) {
        faults.add("B062", reader.line(), "line", bad.why);
      }
  } catch (const text_file::FileFault& fault) {
    faults.add(fault.code, 0, "rest of the file", fault.what());
  }
  rows_ = text_file::in_order(
      std::move(rows), [](const Row& row) { return row.solution.t; },
      [&](const Row& row, const Row& other) {
        faults.add("B063", row.line, "solution",
                   "out of order: " + time_text(row.solution.t) + " beside " + time_text(other.solution.t));
      });
  if (none > 0)
    reporter.warn("B065", path_, 0, std::to_string(none) + " lines with Q = 0 are not solutions and were left out");
  if (layout_.is_height_above_sea && std::isnan(place_.geoid_separation))
    reporter.warn("B064", path_, 0,
                  "heights are above sea level, so there is no height above the ellipsoid; 'geoid_separation' gives "
                  "the difference");
  if (!layout_.is_height_above_sea && !std::isnan(place_.geoid_separation))
    reporter.warn("B032", path_, 0,
                  "'geoid_separation' has no effect: no header declares heights above sea level (\"geodetic\"), so "
                  "they are read as above the ellipsoid");
}

SourceStatus PosSource::next(const MemoryView& bytes, SourceOutput& output) const {
  if (live_) return next_of_live(output);
  std::uint64_t& next = bytes[next_];
  if (next >= rows_.size()) return SourceStatus::end;
  write(rows_[static_cast<std::size_t>(next++)].solution, output);
  return SourceStatus::sample;
}

SourceStatus PosSource::next_of_live(SourceOutput& output) const {
  constexpr int most_lines = 1000;  // that are no solutions, before the others are asked again
  Live& live = *live_;
  for (int lines = 0; lines < most_lines; ++lines) {
    std::string_view line;
    switch (live.lines.next(line)) {
      case line_input::Lines::Got::nothing: return SourceStatus::wait;
      case line_input::Lines::Got::end: return SourceStatus::end;
      case line_input::Lines::Got::anew: continue;
      case line_input::Lines::Got::line: break;
    }
    try {
      auto solution = take(line, live.header);
      if (!solution) continue;
      if (solution->quality == 0) {
        live.lines.note("a line with Q = 0 is not a solution and was left out", "B065");
        continue;
      }
      if (!live.lines.accepts(solution->t)) continue;
      if (live.lines.is_anew()) live.newest = no_time;
      if (live.newest != no_time && solution->t <= live.newest) {
        live.lines.complain("it is not younger than the one before", "B063");
        continue;
      }
      live.newest = solution->t;
      if (live.lines.stamps_arrival()) solution->t = line_input::monotonic_now();
      write(*solution, output);
      return SourceStatus::sample;
    } catch (const BadLine& bad) {
      live.lines.complain(bad.why);
    }
  }
  return SourceStatus::wait;
}

void PosSource::write(const Solution& s, SourceOutput& output) const {
  SampleWriter& out = output.on(channel_);
  out.t = s.t;
  if (has_position_) out[position_] = s.lla;
  if (has_relative_) out[relative_] = s.relative;
  const Columns& c = layout_.columns;
  if (c.has_position_sd()) out[position_sd_] = s.position_covariance.diagonal().cwiseSqrt();
  if (c.has_velocity()) out[velocity_] = s.velocity;
  if (c.has_velocity_sd()) out[velocity_sd_] = s.velocity_covariance.diagonal().cwiseSqrt();
  out[figures_] << s.quality, s.satellites, s.age, s.ratio;
  if (!c.has_position_sd()) return;
  const MatrixView P = out.attach_covariance();
  P.as().setZero();
  P.block(0, 0, 3, 3).as() = s.position_covariance;
  if (c.has_velocity_sd()) P.block(3, 3, 3, 3).as() = s.velocity_covariance;
}

}  // namespace binnacle::rtklib
