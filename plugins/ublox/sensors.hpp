// SPDX-License-Identifier: Apache-2.0
// Inertial sensors and wheel ticks of ESF-MEAS and ESF-RAW, on the sensors' own clock.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "binnacle/time.hpp"
#include "payload.hpp"

namespace binnacle::ublox {

/// Puts tags of a sensor's clock on GPS time. No message says how they belong together; their order in the stream does: the
/// first sensor message after a navigation message was sent after the epoch of that. So tags are early by the receiver's
/// latency, some 20 to 100 ms.
class SensorClock {
 public:
  /// `tick`: of a tag [ns].
  explicit SensorClock(Time tick = 1'000'000) : tick_(tick) {}

  /// An epoch of navigation that has just come.
  void see_epoch(Time gps) { epoch_ = gps; }
  /// no_time: no epoch has come yet.
  Time time_of(std::uint32_t tag);

  /// GPS time − tag; no_time: not known yet.
  Time offset() const { return offset_; }
  /// How far the order of later messages has been from that offset.
  Time least_apart() const { return least_; }
  Time most_apart() const { return most_; }
  /// How often the sensor's clock has been set.
  std::int64_t jumps() const { return jumps_; }

 private:
  Time tick_;
  Time epoch_ = no_time;  // of the newest one, until a tag has followed it
  Time offset_ = no_time;
  Time least_ = 0, most_ = 0;
  Time own_ = 0;  // the sensor's clock, over all turns of the 32 bits
  std::optional<std::uint32_t> last_;
  std::int64_t jumps_ = 0;
};

/// Values of one tag, put together from several messages.
struct SensorSample {
  Time t = no_time;
  Time t0 = no_time;
  std::vector<double> values;  // wx wy wz fx fy fz temperature; or wheels
  bool is_wheels = false;
};

class Sensors {
 public:
  explicit Sensors(Time tick) : clock_(tick) {}

  SensorClock& clock() { return clock_; }
  const SensorClock& clock() const { return clock_; }
  /// A datum of 24 bits and its type (interface description, "ESF measurement data"). False: the type is not read.
  bool add(std::uint32_t tag, std::uint32_t data, std::vector<SensorSample>& complete);
  /// What waits for more of the same tag.
  void finish(std::vector<SensorSample>& complete);

 private:
  void close(bool is_wheels, std::vector<SensorSample>& complete);

  SensorClock clock_;
  struct Pending {
    Time t = no_time;
    std::vector<double> values;  // empty: none
  };
  Pending inertial_, wheels_;
  std::optional<std::uint32_t> tag_;
  Time now_ = no_time;
  Time last_inertial_ = no_time;
};

}  // namespace binnacle::ublox
