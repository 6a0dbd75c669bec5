// SPDX-License-Identifier: Apache-2.0
// From messages to samples on GPS time.
#pragma once

#include <bitset>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "broadcast.hpp"
#include "civil_time/utc_clock.hpp"
#include "framer.hpp"
#include "gnss/observation_channels.hpp"
#include "kinds.hpp"
#include "sensors.hpp"

namespace binnacle::ublox {

/// What came out of messages. Times are GPS time since 1980-01-06.
struct Item {
  Kind kind = Kind::pvt;
  Time t = no_time, t0 = no_time;
  std::uint64_t at = 0;  // of the message in the stream
  std::vector<double> values;
  gnss::ObservationEpoch epoch;
  Broadcast broadcast;  // of Kind::subframe
};

/// Takes what is wrong. `at`: byte of the stream.
class Complaints {
 public:
  virtual ~Complaints() = default;
  /// `why`: "NAV-PVT of unknown length or version": what was left out, and why. It is damage: "on_error": "stop" ends the run.
  virtual void damage(const char* code, const std::string& why, std::uint64_t at) = 0;
  /// The same of what is no damage.
  virtual void note(const char* code, const std::string& why, std::uint64_t at) = 0;
};

class Decoder {
 public:
  struct Options {
    std::bitset<0x10000> wanted;  // types of messages
    gnss::Signals signals;
    civil_time::UtcClock clock;
    Time raw_tick = 39'062;  // of ESF-RAW [ns]
    Time sensor_shift = 0;   // added to times of sensors
  };
  explicit Decoder(const Options& options)
      : options_(options), sensors_(1'000'000), raw_sensors_(options.raw_tick), now_(no_time) {}

  /// The instant that a message gives whole, if it does: week and time of week, or date and time.
  std::optional<Time> instant_of(const Frame& frame) const;
  /// An instant near the first message, so that what comes before the first one that has a week can be read.
  void start_near(Time gps) { now_ = gps; }

  void take(const Frame& frame, std::vector<Item>& items, Complaints& complaints);
  void finish(std::vector<Item>& items);

  /// Messages that are not read, by type.
  const std::map<int, std::uint64_t>& passed_over() const { return passed_over_; }
  /// GPS − UTC [s] as the data give it.
  std::optional<int> leap_seconds() const { return leap_; }
  Time leap() const { return Time{leap_.value_or(0)} * nanoseconds_per_second; }
  const SensorClock& sensor_clock() const { return sensors_.clock(); }
  const SensorClock& raw_sensor_clock() const { return raw_sensors_.clock(); }

 private:
  std::optional<Time> pvt_instant(const Payload& p) const;
  std::optional<Time> rawx_instant(const Payload& p) const;
  Time time_of_week(std::uint32_t milliseconds) const;
  void see_epoch(Time gps);
  void take_solution(const ValueKind& kind, const Frame& frame, std::vector<Item>& items, Complaints& complaints);
  void take_rawx(const Frame& frame, std::vector<Item>& items, Complaints& complaints);
  void take_subframe(const Frame& frame, std::vector<Item>& items, Complaints& complaints);
  void take_meas(const Frame& frame, std::vector<Item>& items, Complaints& complaints);
  void take_raw(const Frame& frame, std::vector<Item>& items, Complaints& complaints);
  void add_sensors(std::vector<SensorSample>& samples, Kind inertial, std::uint64_t at, std::vector<Item>& items,
                   Complaints* complaints) const;

  Options options_;
  std::vector<ValueKind> kinds_ = value_kinds();
  BroadcastCollector broadcasts_;
  Sensors sensors_, raw_sensors_;
  Time now_;  // of the newest message that has a time
  std::optional<int> leap_;
  bool has_fix_ = true;  // unless the newest NAV-PVT or NAV-STATUS has none
  std::map<int, std::uint64_t> passed_over_;
};

}  // namespace binnacle::ublox
