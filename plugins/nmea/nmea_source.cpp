// SPDX-License-Identifier: Apache-2.0
// The nmea source: what a receiver says in sentences of NMEA 0183, recorded or live.
#include "nmea_source.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "reports.hpp"
#include "text/text_file.hpp"

namespace binnacle::nmea {

namespace {

using Outcome = Decoder::Outcome;

/// As much of a line as belongs into a message.
std::string excerpt(std::string_view line) {
  constexpr std::size_t most = 90;
  std::string text;
  for (const char c : line.substr(0, most)) text += c >= ' ' && c <= '~' ? c : '?';
  return "'" + text + (line.size() > most ? "…'" : "'");
}

std::string sentences(std::int64_t count) { return std::to_string(count) + (count == 1 ? " sentence" : " sentences"); }

/// Lines that were of no use, by what was wrong with them.
class Faults {
 public:
  explicit Faults(std::string path) : path_(std::move(path)) {}

  void add(Outcome outcome, std::string_view line, int number) {
    auto& fault = faults_[outcome];
    if (fault.count++ == 0) fault = {1, number, excerpt(line)};
  }
  void report(Reporter& reporter) const {
    for (const auto& [outcome, fault] : faults_)
      reporter.warn(code_of(outcome), path_, fault.line,
                    sentences(fault.count) + " " + words_of(outcome) + "; the first: " + fault.text);
  }

 private:
  struct Fault {
    std::int64_t count = 0;
    int line = 0;
    std::string text;
  };
  std::string path_;
  std::map<Outcome, Fault> faults_;
};

void report(const Decoder::Counts& counts, const std::string& path, Reporter& reporter) {
  for_each_note([&](const char* code, std::int64_t Decoder::Counts::*count, const std::string& what) {
    if (counts.*count > 0) reporter.warn(code, path, 0, std::to_string(counts.*count) + " " + what);
  });
}

}  // namespace

ComponentSpec NmeaSource::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "nmea";
  spec.summary =
      "position, velocity and heading from sentences of NMEA 0183: GGA, RMC, VTG, GSA, GST, HDT, THS, ZDA, "
      "PASHR";
  spec.source = "NMEA 0183 version 4.11; IEC 61162-1";
  spec.parameters = {
      path("path").about("complete file of sentences, plain or gzipped; alternative to 'from'"),
      list("talkers", text("talker")).about("first two letters of the sentences to be read; default: all"),
      text("ends_with")
          .about("last sentence of an instant, for example \"RMC\" or \"GPRMC\"; default: found from the last two "
                 "instants"),
      text("date").about(
          "date of the first sentence, for example \"2026-11-23\", if no sentence gives it (RMC and ZDA do)"),
      number("geoid_separation", "m").about("height of the geoid above the ellipsoid, for GGA without it"),
      boolean("gst").defaults("false").about(
          "true: the channel has position_sd_n, position_sd_e and position_sd_d, from GST")};
  for (ParameterSpec& each : line_input::Lines::parameters()) spec.parameters.push_back(std::move(each));
  for (ParameterSpec& each : UtcClock::parameters()) spec.parameters.push_back(std::move(each));
  spec.example = R"json({"path": "log.nmea", "week": 2185})json";
  spec.surroundings =
      R"json({"files": {"log.nmea": "$GPGGA,120000.00,4807.0380,N,01131.0000,E,1,08,0.9,545.4,M,46.9,M,,*67\r\n$GPRMC,120000.00,A,4807.0380,N,01131.0000,E,022.4,084.4,231121,,,A*51\r\n$GPGGA,120001.00,4807.0381,N,01131.0160,E,1,08,0.9,545.4,M,46.9,M,,*60\r\n$GPRMC,120001.00,A,4807.0381,N,01131.0160,E,022.4,084.4,231121,,,A*56\r\n"}})json";
  return spec;
}

NmeaSource::NmeaSource(const Binding& binding)
    : clock_(binding.parameters()),
      stops_on_error_(binding.parameters().text("on_error") == "stop"),
      has_sigmas_(binding.parameters().boolean("gst")) {
  const Parameters& p = binding.parameters();
  if (p.has("talkers"))
    for (const auto& talker : p.list("talkers")) options_.talkers.push_back(talker.text);
  if (p.has("ends_with")) {
    options_.ends_with = p.text("ends_with");
    if (options_.ends_with.size() != 3 && options_.ends_with.size() != 5)
      throw ComponentError("'" + options_.ends_with + "' is not a sentence; expected \"RMC\" or \"GPRMC\"",
                           "/ends_with");
  }
  if (p.has("geoid_separation")) options_.geoid_separation = p.number("geoid_separation");
  if (p.has("date")) {
    options_.date = parse_day(p.text("date"));
    if (!options_.date) throw ComponentError("'" + p.text("date") + "' is not a day; expected \"2026-11-23\"", "/date");
  }
  declare_channels(has_sigmas_);
  declaration_.live = line_input::is_live(p);
  if (declaration_.live)
    live_ = std::make_unique<LiveEpochs>(p, clock_, options_);
  else
    path_ = line_input::existing_path(p);
}

void NmeaSource::declare_channels(bool has_sigmas) {
  using field::level;
  ChannelDeclaration fix, heading("heading");
  position_ =
      fix.carries(level("lat", "rad").about("geodetic latitude"), level("lon", "rad").about("longitude, east positive"),
                  level("height", "m").about("height above the ellipsoid"));
  velocity_ = fix.carries(level("vn", "m/s").about("velocity over ground, north"), level("ve", "m/s").about("east"),
                          level("speed", "m/s").about("over ground"), level("course", "rad").about("over ground"));
  quality_ =
      fix.carries(level("quality", "1").about("of GGA: 1 autonomous, 2 differential, 4 RTK, 5 float, 6 estimated"),
                  level("satellites", "1").about("used"), level("hdop", "1"),
                  level("dimension", "1").about("of GSA: 2 without height, 3"), level("pdop", "1"), level("vdop", "1"));
  if (has_sigmas)
    position_sd_ = fix.carries(level("position_sd_n", "m").about("of GST"), level("position_sd_e", "m"),
                               level("position_sd_d", "m"));
  yaw_ = heading.carries(level("yaw", "rad").about("of HDT or THS, from true north"));
  fix_ = declaration_.emits(std::move(fix));
  heading_ = declaration_.emits(std::move(heading));
  ChannelDeclaration attitude("attitude");
  attitude_fields_ =
      attitude.carries(level("roll", "rad").about("of PASHR: right side down"), level("pitch", "rad").about("bow up"),
                       level("yaw", "rad").about("from true north"), level("heave", "m").about("up"),
                       level("roll_sd", "rad"), level("pitch_sd", "rad"), level("yaw_sd", "rad"),
                       level("quality", "1").about("of the position: 0 none, 1, 2 RTK"),
                       level("inertial", "1").about("state of the inertial data, as the unit gives it"));
  attitude_ = declaration_.emits(std::move(attitude));
  next_ = declaration_.keeps<std::uint64_t>();
}

void NmeaSource::open(Reporter& reporter) {
  if (live_) return live_->open(reporter);
  try {
    read_file(reporter);
  } catch (const text_file::FileFault& fault) {
    throw ComponentError::in_data(fault.what(), path_, 0, fault.code);
  }
  events_ = events_of(epochs_);
  if (events_.empty())
    throw ComponentError::in_data("no sentence gives a position or a heading with a date", path_, 0, "B066");
}

std::vector<NmeaSource::Event> NmeaSource::events_of(const std::vector<Epoch>& epochs) {
  std::vector<Event> events;
  for (std::uint64_t i = 0; i < epochs.size(); ++i) {
    const Epoch& epoch = epochs[static_cast<std::size_t>(i)];
    if (epoch.has_position) events.push_back({i, Part::fix});
    if (std::isfinite(epoch.yaw)) events.push_back({i, Part::heading});
    if (epoch.attitude.is_given) events.push_back({i, Part::attitude});
  }
  return events;
}

void NmeaSource::read_file(Reporter& reporter) {
  Decoder decoder(clock_, options_);
  Faults faults(path_);
  text_file::LineReader reader(path_);
  for (std::string_view line; reader.next_filled(line);) {
    const Outcome outcome = decoder.take(line, epochs_);
    if (outcome == Outcome::used || outcome == Outcome::ignored) continue;
    if (stops_on_error_)
      throw ComponentError::in_data("a sentence " + std::string(words_of(outcome)) + ": " + excerpt(line), path_,
                                    reader.line(), code_of(outcome));
    faults.add(outcome, line, reader.line());
  }
  decoder.finish(epochs_);
  faults.report(reporter);
  report(decoder.counts(), path_, reporter);
  if (const std::string text = text_of(decoder.passed_over()); !text.empty()) reporter.warn("B065", path_, 0, text);
}

SourceStatus NmeaSource::next(const MemoryView& bytes, SourceOutput& output) const {
  if (live_) return next_of_live(output);
  std::uint64_t& next = bytes[next_];
  if (next >= events_.size()) return SourceStatus::end;
  const Event event = events_[static_cast<std::size_t>(next++)];
  write(epochs_[static_cast<std::size_t>(event.epoch)], event.part, output);
  return SourceStatus::sample;
}

SourceStatus NmeaSource::next_of_live(SourceOutput& output) const {
  Waiting& waiting = *waiting_;
  while (waiting.next == waiting.events.size()) {
    waiting = {};
    const SourceStatus status = live_->next(waiting.epochs);
    if (status != SourceStatus::sample) return status;
    waiting.events = events_of(waiting.epochs);
  }
  const Event event = waiting.events[waiting.next++];
  write(waiting.epochs[static_cast<std::size_t>(event.epoch)], event.part, output);
  return SourceStatus::sample;
}

void NmeaSource::write(const Epoch& epoch, Part part, SourceOutput& output) const {
  SampleWriter& out = output.on(part == Part::fix ? fix_ : part == Part::heading ? heading_ : attitude_);
  out.t = epoch.t;
  if (part == Part::fix) return write_fix(epoch, out);
  if (part == Part::heading) {
    out[yaw_] = epoch.yaw;
    return;
  }
  const Epoch::Attitude& a = epoch.attitude;
  out[attitude_fields_] << a.roll, a.pitch, a.yaw, a.heave, a.roll_sd, a.pitch_sd, a.yaw_sd, a.quality, a.inertial;
}

void NmeaSource::write_fix(const Epoch& epoch, SampleWriter& out) const {
  out[position_] << epoch.lat, epoch.lon, epoch.height;
  // Receivers leave the course out where they stand.
  const double course = epoch.speed == 0 && std::isnan(epoch.course) ? 0 : epoch.course;
  out[velocity_] << epoch.speed * std::cos(course), epoch.speed * std::sin(course), epoch.speed, epoch.course;
  out[quality_] << epoch.quality, epoch.satellites, epoch.hdop, epoch.dimension, epoch.pdop, epoch.vdop;
  if (has_sigmas_) out[position_sd_] << epoch.position_sd[0], epoch.position_sd[1], epoch.position_sd[2];
}

}  // namespace binnacle::nmea
