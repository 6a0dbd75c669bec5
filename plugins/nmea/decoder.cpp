// SPDX-License-Identifier: Apache-2.0
#include "decoder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace binnacle::nmea {

namespace {

constexpr double knot = 1852.0 / 3600.0;  // [m/s]
constexpr Time half_a_day = 43200 * nanoseconds_per_second;

/// PASHR is proprietary: its talker is "PA".
constexpr std::array<std::string_view, 9> read_type_names{"GGA", "RMC", "GST", "ZDA", "SHR",
                                                          "VTG", "HDT", "THS", "GSA"};

std::size_t as_index(auto type) { return static_cast<std::size_t>(type); }

double value_or_nan(const std::optional<double>& value) { return value.value_or(Epoch::nan); }

/// Whether `tag`, "GPRMC", is what the config calls "RMC" or "GPRMC".
bool is_named(const std::string& tag, const std::string& name) {
  return name.size() == 3 ? tag.compare(2, 3, name) == 0 : tag == name;
}

}  // namespace

Decoder::Decoder(const UtcClock& clock, Options options) : clock_(clock), options_(std::move(options)) {
  last_day_ = options_.date;
  ender_ = options_.ends_with;
}

std::optional<Decoder::Type> Decoder::type_of(std::string_view name) {
  const auto found = std::find(read_type_names.begin(), read_type_names.end(), name);
  if (found == read_type_names.end()) return {};
  return static_cast<Type>(found - read_type_names.begin());
}

Decoder::Outcome Decoder::take(std::string_view line, std::vector<Epoch>& complete) {
  Sentence sentence;
  switch (parse(line, sentence)) {
    case SentenceFault::no_sentence: pass_over(line, {}); return Outcome::ignored;
    case SentenceFault::cut: return Outcome::cut;
    case SentenceFault::checksum: return Outcome::checksum;
    case SentenceFault::none: break;
  }
  const auto type = type_of(sentence.type);
  const auto& talkers = options_.talkers;
  const bool is_proprietary = sentence.talker == "PA";
  if (!talkers.empty() && !is_proprietary &&
      std::find(talkers.begin(), talkers.end(), sentence.talker) == talkers.end())
    return Outcome::ignored;  // the config does not want it
  if (!type || is_proprietary != (*type == Type::pashr)) {
    pass_over(line, sentence);
    return Outcome::ignored;
  }
  Reading reading;
  reading.type = *type;
  reading.tag = sentence.fields[0];
  if (!read(sentence, reading)) return Outcome::unreadable;
  add(std::move(reading), complete);
  return Outcome::used;
}

void Decoder::pass_over(std::string_view line, const Sentence& sentence) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  if (std::all_of(line.begin(), line.end(), is_blank)) return;
  std::string kind = "lines without a sentence";
  if (line.find('$') != line.npos) kind = "proprietary sentences and queries";
  if (!sentence.type.empty()) kind = sentence.type;
  constexpr std::size_t most_kinds = 64;
  if (passed_over_.size() >= most_kinds && passed_over_.count(kind) == 0) kind = "others";
  ++passed_over_[kind];
}

bool Decoder::read(const Sentence& sentence, Reading& reading) {
  switch (reading.type) {
    case Type::gga: return read_gga(sentence, reading);
    case Type::rmc: return read_rmc(sentence, reading);
    case Type::gst: return read_gst(sentence, reading);
    case Type::zda: return read_zda(sentence, reading);
    case Type::vtg: return read_course(sentence, reading);
    case Type::hdt:
    case Type::ths: return read_heading(sentence, reading);
    case Type::gsa: return read_gsa(sentence, reading);
    case Type::pashr: return read_pashr(sentence, reading);
  }
  return false;
}

bool Decoder::read_gga(const Sentence& s, Reading& reading) {
  std::optional<double> lat, lon, quality, satellites, hdop, height, separation;
  if (s.count < 11 || !parse_time_of_day(s[1], reading.of_day) || !parse_coordinate(s[2], s[3], lat) ||
      !parse_coordinate(s[4], s[5], lon) || !parse_number(s[6], quality) || !parse_number(s[7], satellites) ||
      !parse_number(s[8], hdop) || !parse_number(s[9], height) || !parse_number(s[11], separation))
    return false;
  Epoch& v = reading.values;
  v.quality = quality.value_or(0);
  v.satellites = value_or_nan(satellites);
  v.hdop = value_or_nan(hdop);
  v.has_position = v.quality > 0 && lat && lon;
  if (!v.has_position) return true;
  v.lat = *lat;
  v.lon = *lon;
  if (!height) return true;
  v.height = *height + separation.value_or(options_.geoid_separation);
  counts_.no_separation += std::isnan(v.height);
  return true;
}

bool Decoder::read_rmc(const Sentence& s, Reading& reading) const {
  std::optional<double> lat, lon, speed, course, date;
  if (s.count < 10 || !parse_time_of_day(s[1], reading.of_day) || !parse_coordinate(s[3], s[4], lat) ||
      !parse_coordinate(s[5], s[6], lon) || !parse_number(s[7], speed) || !parse_number(s[8], course) ||
      !parse_number(s[9], date) || (s[2] != "A" && s[2] != "V"))
    return false;
  if (s[2] == "V" || s[12] == "N") return true;
  if (date) {
    if (s[9].size() != 6) return false;
    const std::string d(s[9]), y = d.substr(4, 2);
    reading.day = parse_day((y >= "80" ? "19" : "20") + y + "-" + d.substr(2, 2) + "-" + d.substr(0, 2));
    if (!reading.day) return false;
  }
  Epoch& v = reading.values;
  v.has_position = lat && lon;
  v.lat = value_or_nan(lat);
  v.lon = value_or_nan(lon);
  if (speed) v.speed = *speed * knot;
  if (course) v.course = *course * degree;
  return true;
}

bool Decoder::read_gst(const Sentence& s, Reading& reading) const {
  if (s.count < 9 || !parse_time_of_day(s[1], reading.of_day)) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::optional<double> sigma;
    if (!parse_number(s[6 + axis], sigma)) return false;
    reading.values.position_sd[axis] = value_or_nan(sigma);
  }
  return true;
}

bool Decoder::read_zda(const Sentence& s, Reading& reading) const {
  if (s.count < 5 || !parse_time_of_day(s[1], reading.of_day)) return false;
  if (s[2].empty() && s[3].empty() && s[4].empty()) return true;
  reading.day = parse_day(std::string(s[4]) + "-" + std::string(s[3]) + "-" + std::string(s[2]));
  return reading.day.has_value();
}

bool Decoder::read_course(const Sentence& s, Reading& reading) const {
  std::optional<double> course, speed;
  if (s.count < 9 || s[2] != "T" || s[6] != "N" || !parse_number(s[1], course) || !parse_number(s[5], speed))
    return false;
  if (s[9] == "N") return true;
  if (speed) reading.values.speed = *speed * knot;
  if (course) reading.values.course = *course * degree;
  return true;
}

bool Decoder::read_heading(const Sentence& s, Reading& reading) const {
  std::optional<double> heading;
  if (s.count < 3 || !parse_number(s[1], heading) || (reading.type == Type::hdt && s[2] != "T")) return false;
  const bool is_valid = reading.type == Type::hdt || s[2] == "A";
  if (heading && is_valid) reading.values.yaw = *heading * degree;
  return true;
}

bool Decoder::read_gsa(const Sentence& s, Reading& reading) const {
  std::optional<double> dimension, pdop, hdop, vdop;
  if (s.count < 18 || !parse_number(s[2], dimension) || !parse_number(s[15], pdop) || !parse_number(s[16], hdop) ||
      !parse_number(s[17], vdop))
    return false;
  reading.values.dimension = value_or_nan(dimension);
  reading.values.pdop = value_or_nan(pdop);
  reading.values.hdop = value_or_nan(hdop);
  reading.values.vdop = value_or_nan(vdop);
  return true;
}

/// hhmmss.sss, heading, T, roll, pitch, heave, standard deviations of roll, pitch and heading, quality of the position, and
/// of the inertial data. Roll: right side down; pitch: bow up.
bool Decoder::read_pashr(const Sentence& s, Reading& reading) const {
  std::array<std::optional<double>, 9> v;
  constexpr std::array<std::size_t, 9> places{2, 4, 5, 6, 7, 8, 9, 10, 11};
  if (s.count < 10 || !parse_time_of_day(s[1], reading.of_day) || s[3] != "T") return false;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (!parse_signed(s[places[i]], v[i])) return false;
  const auto angle = [&](std::size_t i) { return value_or_nan(v[i]) * degree; };
  Epoch::Attitude& a = reading.values.attitude;
  a.yaw = angle(0), a.roll = angle(1), a.pitch = angle(2);
  a.heave = value_or_nan(v[3]);
  a.roll_sd = angle(4), a.pitch_sd = angle(5), a.yaw_sd = angle(6);
  a.quality = value_or_nan(v[7]);
  a.inertial = value_or_nan(v[8]);
  a.is_given = std::isfinite(a.yaw) || std::isfinite(a.roll);
  return true;
}

void Decoder::add(Reading&& reading, std::vector<Epoch>& complete) {
  const bool carries_time = reading.type <= Type::pashr;
  if (carries_time && !reading.of_day) return;  // the receiver does not know it yet
  if (reading.of_day && (!current_ || current_->of_day != *reading.of_day)) begin(reading, complete);
  const bool is_early = !carries_time && current_ && current_->is_complete && !options_.ends_with.empty();
  if (is_early) {
    early_.push_back(std::move(reading));
    return;
  }
  if (!current_) {
    ++counts_.untimed;
    return;
  }
  const bool is_last = add_to_current(reading) && !ender_.empty() && is_named(reading.tag, ender_);
  const bool has_day = current_->day || last_day_;  // else a sentence may follow that has it
  if (is_last && (has_day || !options_.ends_with.empty())) complete_current(complete);
}

/// A sentence of another time.
void Decoder::begin(const Reading& reading, std::vector<Epoch>& complete) {
  if (current_ && !current_->is_complete) {
    if (options_.ends_with.empty()) {
      ender_ = current_->last_tag == candidate_ ? candidate_ : "";
      candidate_ = current_->last_tag;
    }
    complete_current(complete);
  }
  current_ = Current{};  // emplace(): clang before 16 knows no default constructor of a nested struct with initializers
  current_->of_day = *reading.of_day;
  for (const Reading& early : std::exchange(early_, {})) add_to_current(early);
}

/// False: it is left out.
bool Decoder::add_to_current(const Reading& reading) {
  std::string& tag = current_->tags[as_index(reading.type)];
  const bool is_again = !tag.empty() && reading.type != Type::gsa;  // of which there is one for each constellation
  if (current_->is_complete) {
    if (reading.type == Type::gsa && !tag.empty()) return false;
    if (reading.day) last_day_ = reading.day;
    if (is_again && !reading.of_day) {
      ++counts_.untimed;
    } else {
      ++counts_.after_end;
      if (options_.ends_with.empty()) ender_.clear(), candidate_.clear();
    }
    return false;
  }
  current_->last_tag = reading.tag;
  if (is_again && !reading.of_day) {
    ++counts_.untimed;
    return false;
  }
  counts_.two_talkers += is_again && tag != reading.tag;
  tag = reading.tag;
  merge(reading);
  return true;
}

/// GGA's position counts before RMC's, and RMC's velocity, which has a time, before VTG's.
void Decoder::merge(const Reading& reading) {
  Epoch& all = current_->values;
  const Epoch& v = reading.values;
  const auto has = [&](Type type) { return !current_->tags[as_index(type)].empty(); };
  if (reading.day) current_->day = reading.day;
  if (v.has_position && (reading.type == Type::gga || !(has(Type::gga) && all.has_position))) {
    all.has_position = true;
    all.lat = v.lat;
    all.lon = v.lon;
    all.height = v.height;
  }
  if (reading.type == Type::rmc || (reading.type == Type::vtg && !(has(Type::rmc) && std::isfinite(all.speed)))) {
    all.speed = v.speed;
    all.course = v.course;
  }
  if (reading.type == Type::gst) all.position_sd = v.position_sd;
  if (reading.type == Type::hdt || reading.type == Type::ths) all.yaw = v.yaw;
  if (reading.type == Type::pashr) all.attitude = v.attitude;
  if (reading.type == Type::gsa) {
    all.dimension = v.dimension;
    all.pdop = v.pdop;
    all.vdop = v.vdop;
    if (std::isnan(all.hdop)) all.hdop = v.hdop;
  }
  if (reading.type != Type::gga) return;
  all.quality = v.quality;
  all.satellites = v.satellites;
  if (std::isfinite(v.hdop)) all.hdop = v.hdop;
}

void Decoder::complete_current(std::vector<Epoch>& complete) {
  current_->is_complete = true;
  if (!find_day()) {
    ++counts_.undated;
    return;
  }
  Epoch& epoch = current_->values;
  epoch.t = clock_.time({*last_day_, current_->of_day});
  if (epoch.t <= last_time_) {
    ++counts_.backwards;
    return;
  }
  last_time_ = epoch.t;
  complete.push_back(epoch);
}

/// Of the current epoch. Of two times of day that are more than half a day apart the smaller one is of the day after.
bool Decoder::find_day() {
  if (current_->day) {
    last_day_ = current_->day;
  } else if (last_day_ && last_of_day_) {
    const Time step = current_->of_day - *last_of_day_;
    if (step < -half_a_day) *last_day_ += std::chrono::days(1);
    if (step > half_a_day) *last_day_ -= std::chrono::days(1);
  }
  if (last_day_) last_of_day_ = current_->of_day;
  return last_day_.has_value();
}

void Decoder::finish(std::vector<Epoch>& complete) {
  if (current_ && !current_->is_complete) complete_current(complete);
}

}  // namespace binnacle::nmea
