// SPDX-License-Identifier: Apache-2.0
// Sentences put together to epochs: what a receiver says of one instant.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sentence.hpp"

namespace binnacle::nmea {

/// SI; NaN where no sentence has it.
struct Epoch {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Time t = no_time;
  bool has_position = false;
  double lat = nan, lon = nan, height = nan;
  double speed = nan, course = nan;
  double yaw = nan;
  /// Of PASHR: roll, pitch [rad], heave [m], their standard deviations, quality of position and inertial data.
  struct Attitude {
    bool is_given = false;
    double roll = nan, pitch = nan, yaw = nan, heave = nan;
    double roll_sd = nan, pitch_sd = nan, yaw_sd = nan;
    double quality = nan, inertial = nan;
  } attitude;
  std::array<double, 3> position_sd{nan, nan, nan};  // north, east, down
  double quality = nan, satellites = nan, hdop = nan;
  double dimension = nan, pdop = nan, vdop = nan;  // of GSA
};

/// Sentences that carry a time of day (GGA, RMC, GST, ZDA, PASHR) belong together where it is equal; those that do not (VTG, HDT, THS, GSA)
/// belong to the one before them. An epoch is complete at the sentence which ends it: `ends_with`, or that which ended two in
/// a row, or at the first one of another time. RMC and ZDA give the date; without them the day changes at midnight.
class Decoder {
 public:
  struct Options {
    std::vector<std::string> talkers = {};  // none: all
    std::string ends_with = {};             // "RMC"; "": learned
    double geoid_separation = Epoch::nan;   // where GGA has none [m]
    std::optional<Day> date = {};           // of the first epoch
  };
  enum class Outcome { used, ignored, cut, checksum, unreadable };

  /// What is worth a report.
  struct Counts {
    std::int64_t undated = 0;        // epochs before the first date
    std::int64_t backwards = 0;      // epochs not younger than the one before
    std::int64_t after_end = 0;      // sentences of an epoch that had been taken for complete
    std::int64_t untimed = 0;        // VTG, HDT, THS, GSA before any epoch, or a second one in it
    std::int64_t two_talkers = 0;    // sentences of a type that another talker gave for the same epoch
    std::int64_t no_separation = 0;  // GGA with a height above the sea alone
  };

  Decoder(const UtcClock& clock, Options options);

  /// Epochs that this line completes are appended.
  Outcome take(std::string_view line, std::vector<Epoch>& complete);
  /// The data are over.
  void finish(std::vector<Epoch>& complete);
  const Counts& counts() const { return counts_; }
  /// Lines that are not read, and how often: "GSV", "proprietary sentences", "lines without a sentence".
  const std::map<std::string, std::int64_t>& passed_over() const { return passed_over_; }

 private:
  enum class Type { gga, rmc, gst, zda, pashr, vtg, hdt, ths, gsa };
  static constexpr std::size_t type_count = 9;
  struct Reading {
    Type type = Type::gga;
    std::string tag;  // "GPGGA"
    std::optional<Time> of_day;
    std::optional<Day> day;
    Epoch values;
  };
  struct Current {
    Time of_day = 0;
    std::optional<Day> day;
    Epoch values;
    std::array<std::string, type_count> tags;  // by type; "": not seen
    std::string last_tag;
    bool is_complete = false;
  };

  static std::optional<Type> type_of(std::string_view name);
  bool read(const Sentence& sentence, Reading& reading);
  bool read_gga(const Sentence& sentence, Reading& reading);
  bool read_rmc(const Sentence& sentence, Reading& reading) const;
  bool read_gst(const Sentence& sentence, Reading& reading) const;
  bool read_zda(const Sentence& sentence, Reading& reading) const;
  bool read_course(const Sentence& sentence, Reading& reading) const;
  bool read_heading(const Sentence& sentence, Reading& reading) const;
  bool read_gsa(const Sentence& sentence, Reading& reading) const;
  bool read_pashr(const Sentence& sentence, Reading& reading) const;
  void pass_over(std::string_view line, const Sentence& sentence);
  void add(Reading&& reading, std::vector<Epoch>& complete);
  void begin(const Reading& reading, std::vector<Epoch>& complete);
  bool add_to_current(const Reading& reading);
  void merge(const Reading& reading);
  void complete_current(std::vector<Epoch>& complete);
  bool find_day();

  UtcClock clock_;
  Options options_;
  Counts counts_;
  std::map<std::string, std::int64_t> passed_over_;
  std::optional<Current> current_;
  std::vector<Reading> early_;  // without a time, after the sentence that ends an epoch
  std::string candidate_, ender_;
  std::optional<Day> last_day_;
  std::optional<Time> last_of_day_;
  Time last_time_ = no_time;
};

}  // namespace binnacle::nmea
