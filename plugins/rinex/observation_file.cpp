// SPDX-License-Identifier: Apache-2.0
// Epochs of a RINEX observation file.
#include "observation_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "binnacle/parameters.hpp"
#include "columns.hpp"
#include "gnss/gps_time.hpp"
#include "gnss/orbit.hpp"
#include "header.hpp"
#include "text/in_order.hpp"

namespace binnacle::rinex {

namespace {

constexpr std::size_t cell_width = 16;  // F14.3, I1, I1
constexpr std::size_t observation_width = 14;

/// Which observation of a line is which; −1: none.
struct Places {
  int pseudorange = -1, doppler = -1, cn0 = -1, phase = -1;
  int count = 0;  // observations of a satellite
};

std::string time_text(Time t) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", seconds(t));
  return text;
}

/// The F14.3 of a cell. NaN where it is blank; false where it is neither blank nor a number of that form, as when a
/// line is cut in the middle of one.
bool read_cell(std::string_view line, int index, double& value) {
  value = std::numeric_limits<double>::quiet_NaN();
  if (index < 0) return true;
  const auto text = columns(line, static_cast<std::size_t>(index) * cell_width, observation_width);
  if (trimmed(text).empty()) return true;
  const auto read = number(text);
  if (!read || text.size() != observation_width || text[observation_width - 4] != '.') return false;
  if (*read != 0) value = *read;  // 0.000 stands for "missing" too
  return true;
}

class ObservationReader {
 public:
  ObservationReader(const std::string& path, int origin_week, const Signals& signals, Faults& faults)
      : path_(path), origin_week_(origin_week), signals_(signals), faults_(faults) {}

  std::vector<Epoch> read() {
    try {
      text_file::LineReader reader(path_);
      reader_ = &reader;
      version_ = read_version(reader, path_, FileType::observation);
      if (read_header()) read_epochs();
    } catch (const text_file::FileFault& fault) {
      faults_.add(fault.code, 0, "rest of the file", fault.what());
    }
    if (glonass_ > 0)
      faults_.note("B065", first_glonass_,
                   std::to_string(glonass_) + (glonass_ == 1 ? " observation" : " observations") +
                       " of GLONASS left out: it is not read");
    return in_order(std::move(epochs_));
  }

 private:
  bool is_old() const { return version_.major() == 2; }

  bool next() {
    has_line_ = reader_->next(line_);
    return has_line_;
  }
  int line() const { return reader_->line(); }

  bool read_header() {
    while (next()) {
      if (label(line_) == "END OF HEADER") {
        find_places();
        return true;
      }
      take_header_line();
    }
    faults_.add("B061", line(), "header", "the file ends inside its header");
    return false;
  }

  void take_header_line() {
    const auto name = label(line_);
    if (name == "# / TYPES OF OBSERV") {
      if (const auto count = integer(columns(line_, 0, 6))) {
        old_types_.clear();
        old_count_ = *count;
      }
      for (std::size_t i = 0; i < 9; ++i) {
        const auto type = trimmed(columns(line_, 6 + 6 * i, 6));
        if (!type.empty()) old_types_.emplace_back(type);
      }
    } else if (name == "SYS / # / OBS TYPES") {
      if (line_.front() != ' ') {
        system_ = line_.front();
        new_types_[system_].clear();
      }
      for (std::size_t i = 0; i < 13; ++i) {
        const auto type = trimmed(columns(line_, 7 + 4 * i, 3));
        if (!type.empty()) new_types_[system_].emplace_back(type);
      }
    } else if (name == "SYS / SCALE FACTOR") {
      faults_.add("B062", line(), "header line", "scale factors of observations are not applied");
    } else if (name == "TIME OF FIRST OBS") {
      const auto scale = trimmed(columns(line_, 48, 3));
      to_gps_ = scale == "BDT" ? nanoseconds(gnss::gps_minus_beidou) : 0;
      if (!scale.empty() && scale != "GPS" && scale != "GAL" && scale != "QZS" && scale != "BDT")
        faults_.add("B062", line(), "header line",
                    "times are on the clock of " + std::string(scale) + "; taken as GPS time");
    }
  }

  void find_places() {
    bool has_pseudoranges = false;
    for (const auto constellation : gnss::constellations()) {
      const bool is_beidou = constellation == gnss::Constellation::beidou;
      std::string code = signals_.of(constellation);
      if (is_old()) code = is_beidou ? "" : code.substr(0, 1);  // version 2 has no BeiDou: its C2 is L2C
      const auto index = static_cast<std::size_t>(constellation);
      const auto& types = is_old() ? old_types_ : new_types_["?GEC"[index]];
      Places& places = places_[index];
      places = Places{};
      places.count = static_cast<int>(types.size());
      const auto find = [&](char kind) {
        const auto found = std::find(types.begin(), types.end(), kind + code);
        return code.empty() || found == types.end() ? -1 : static_cast<int>(found - types.begin());
      };
      places.pseudorange = find('C');
      places.doppler = find('D');
      places.cn0 = find('S');
      places.phase = find('L');
      has_pseudoranges = has_pseudoranges || places.pseudorange >= 0;
    }
    if (is_old() && old_count_ != static_cast<int>(old_types_.size()))
      faults_.add("B062", line(), "header line", "the number of observation types is not that of the types listed");
    if (!has_pseudoranges)
      throw ComponentError::in_data("contains no pseudoranges of the requested signals", path_, line(), "B066");
  }

  void read_epochs() {
    next();
    while (has_line_) {
      if (trimmed(line_).empty() || !take_epoch()) skip_to_epoch();
    }
  }

  /// The line itself may be one: called after a line was refused or read.
  void skip_to_epoch() {
    if (!must_advance_ && has_line_ && looks_like_epoch()) return;
    must_advance_ = false;
    while (next())
      if (looks_like_epoch()) return;
  }

  bool looks_like_epoch() const {
    if (!is_old()) return !line_.empty() && line_.front() == '>';
    // 2.x has no mark: numbers where an epoch has them, and none where an observation has its decimals. An event may
    // have no time.
    const auto flag = integer(columns(line_, 28, 1));
    if (trimmed(columns(line_, 0, 28)).empty() && columns(line_, 28, 1) != " " && flag && *flag >= 2 && *flag <= 5 &&
        line_.size() <= 32 && integer(columns(line_, 29, 3)))
      return true;
    return integer(columns(line_, 1, 2)) && integer(columns(line_, 4, 2)) && integer(columns(line_, 7, 2)) &&
           integer(columns(line_, 10, 2)) && integer(columns(line_, 13, 2)) && number(columns(line_, 15, 11)) &&
           integer(columns(line_, 28, 1)) && integer(columns(line_, 29, 3)) && columns(line_, 3, 1) == " " &&
           columns(line_, 6, 1) == " ";
  }

  /// True: the epoch is done with, and line_ is the one after it.
  bool take_epoch() {
    const std::string head(line_);
    const int head_line = line();
    if (!looks_like_epoch()) {
      faults_.add("B062", head_line, "line", "'" + head.substr(0, 30) + "' is not an epoch");
      must_advance_ = true;
      return false;
    }
    const std::size_t flag_at = is_old() ? 28 : 31;
    const auto flag = integer(columns(head, flag_at, 1));
    const auto count = integer(columns(head, flag_at + 1, 3));
    if (!flag || !count || *flag < 0 || *flag > 6 || *count < 0) {
      faults_.add("B062", head_line, "epoch", "its flag or its number of satellites is none");
      must_advance_ = true;
      return false;
    }
    if (*flag >= 2 && *flag <= 5) return skip_event(*count);
    const auto t = is_old() ? gps_time(columns(head, 0, 3), columns(head, 3, 3), columns(head, 6, 3),
                                       columns(head, 9, 3), columns(head, 12, 3), columns(head, 15, 11), origin_week_)
                            : gps_time(columns(head, 2, 4), columns(head, 6, 3), columns(head, 9, 3),
                                       columns(head, 12, 3), columns(head, 15, 3), columns(head, 18, 11), origin_week_);
    if (!t) {
      faults_.add("B062", head_line, "epoch", "'" + head.substr(0, 29) + "' is not a time");
      must_advance_ = true;
      return false;
    }
    Epoch epoch;
    epoch.t = *t + to_gps_;
    epoch.line = head_line;
    epoch.event = *flag == 1 ? 1 : 0;
    if (const auto offset = number(is_old() ? columns(head, 68, 12) : columns(head, 41, 15)))
      epoch.clock_offset = *offset;
    const bool is_complete = is_old() ? take_old_rows(head, *count, epoch) : take_new_rows(*count, epoch);
    if (!is_complete) return false;
    if (*flag != 6) epochs_.push_back(std::move(epoch));  // 6: cycle slips, in the form of observations
    return true;
  }

  /// Lines of comments or of a new header follow.
  bool skip_event(int count) {
    for (int i = 0; i < count; ++i) {
      if (!next()) return true;
      take_header_line();
    }
    find_places();
    next();
    return true;
  }

  bool is_cut_off(const Epoch& epoch) {
    faults_.add("B061", line(), "epoch", "the file ends inside the epoch at " + time_text(epoch.t));
    return false;
  }

  bool take_old_rows(const std::string& head, int count, Epoch& epoch) {
    std::vector<std::string> names;
    std::string list = head;
    for (int i = 0; i < count; ++i) {
      if (i > 0 && i % 12 == 0) {
        if (!next()) return is_cut_off(epoch);
        list = line_;
      }
      names.emplace_back(columns(list, 32 + 3 * static_cast<std::size_t>(i % 12), 3));
    }
    const std::size_t lines = (old_types_.size() + 4) / 5;
    for (const auto& name : names) {
      std::string row;
      for (std::size_t i = 0; i < lines; ++i) {
        if (!next()) return is_cut_off(epoch);
        if (looks_like_epoch()) {
          faults_.add("B062", line(), "epoch", "the next one begins before all satellites of " + time_text(epoch.t));
          return false;
        }
        row += std::string(line_.substr(0, 5 * cell_width));
        if (i + 1 < lines) row.resize((i + 1) * 5 * cell_width, ' ');
      }
      take_row(name, row, epoch);
    }
    next();
    return true;
  }

  bool take_new_rows(int count, Epoch& epoch) {
    for (int i = 0; i < count; ++i) {
      if (!next()) return is_cut_off(epoch);
      if (looks_like_epoch()) {
        faults_.add("B062", line(), "epoch", "the next one begins before all satellites of " + time_text(epoch.t));
        return false;
      }
      take_row(std::string(columns(line_, 0, 3)), std::string(columns(line_, 3, line_.size())), epoch);
    }
    next();
    return true;
  }

  void take_row(const std::string& name, const std::string& row, Epoch& epoch) {
    const auto satellite = gnss::parse_satellite(name);
    if (!satellite) {
      // GLONASS is counted; SBAS, QZSS, NavIC are passed over.
      if (!name.empty() && name.front() == 'R' && ++glonass_ == 1) first_glonass_ = line();
      if (name.empty() || std::string_view("RSJI").find(name.front()) == std::string_view::npos)
        faults_.add("B062", line(), "observation", "'" + name + "' is not a satellite");
      return;
    }
    const Places& places = places_[static_cast<std::size_t>(gnss::constellation_of(*satellite))];
    if (places.pseudorange < 0) return;
    Observation observation;
    observation.satellite = *satellite;
    double doppler = 0;
    if (!read_cell(row, places.pseudorange, observation.pseudorange) || !read_cell(row, places.doppler, doppler) ||
        !read_cell(row, places.cn0, observation.cn0) || !read_cell(row, places.phase, observation.phase)) {
      faults_.add("B062", line(), "observation", "'" + row.substr(0, 40) + "' of " + name + " are no numbers");
      return;
    }
    if (std::isnan(observation.pseudorange)) return;
    for (const auto& other : epoch.satellites)
      if (other.satellite == *satellite)
        return faults_.add("B062", line(), "observation", name + " appears in its epoch twice");
    const double wavelength = gnss::speed_of_light / gnss::carrier_frequency(*satellite);
    observation.range_rate = -wavelength * doppler;  // a satellite that comes nearer has a positive Doppler shift
    observation.phase *= wavelength;
    epoch.satellites.push_back(observation);
  }

  std::vector<Epoch> in_order(std::vector<Epoch> all) {
    return text_file::in_order(
        std::move(all), [](const Epoch& epoch) { return epoch.t; },
        [&](const Epoch& epoch, const Epoch& other) {
          faults_.add("B063", epoch.line, "epoch",
                      "out of order: " + time_text(epoch.t) + " beside " + time_text(other.t));
        });
  }

  const std::string& path_;
  int origin_week_;
  const Signals& signals_;
  Faults& faults_;
  text_file::LineReader* reader_ = nullptr;
  std::string_view line_;
  bool has_line_ = false;
  bool must_advance_ = false;
  Version version_;
  int old_count_ = 0;
  char system_ = ' ';
  std::vector<std::string> old_types_;
  std::map<char, std::vector<std::string>> new_types_;
  std::size_t glonass_ = 0;  // observations
  int first_glonass_ = 0;    // line
  std::array<Places, 1 + gnss::constellations().size()> places_;
  Time to_gps_ = 0;  // what is added to the times of epochs
  std::vector<Epoch> epochs_;
};

}  // namespace

std::vector<Epoch> read_observations(const std::string& path, int origin_week, const Signals& signals, Faults& faults) {
  auto epochs = ObservationReader(path, origin_week, signals, faults).read();
  const auto jumps = gnss::find_clock_jumps(epochs);
  if (!jumps.text.empty()) faults.note("B065", jumps.first_line, jumps.text);
  return epochs;
}

}  // namespace binnacle::rinex
