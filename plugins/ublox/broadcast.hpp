// SPDX-License-Identifier: Apache-2.0
// Broadcast messages put together from subframes of GPS (LNAV) and pages of Galileo (I/NAV).
#pragma once

#include <map>
#include <optional>

#include "bits.hpp"
#include "gnss/atmosphere.hpp"
#include "gnss/message_choice.hpp"
#include "payload.hpp"

namespace binnacle::ublox {

/// What a subframe came to.
struct Broadcast {
  std::optional<gnss::BroadcastMessage> message;  // one that the satellite had not sent before
  std::optional<gnss::Klobuchar> klobuchar;
  const char* fault = nullptr;    // it is damaged, or contradicts itself
  const char* ignored = nullptr;  // whole, and not one that is read: "of GLONASS"
};

/// Times are GPS time since 1980-01-06; `uploaded` is when the last part came.
class BroadcastCollector {
 public:
  /// RXM-SFRBX at the time `now`, to within half a week.
  Broadcast take(const Payload& payload, Time now);

 private:
  static constexpr std::size_t lnav_bytes = 30;  // 10 words of 24 bits
  static constexpr std::size_t inav_bytes = 16;  // a word of 128 bits

  struct Gps {
    std::array<std::optional<Bits<lnav_bytes>>, 3> subframes;
  };
  struct Galileo {
    std::array<std::optional<Bits<inav_bytes>>, 5> words;  // of types 1 to 5
  };

  Broadcast take_lnav(const Payload& payload, int satellite, Time now);
  Broadcast take_inav(const Payload& payload, int satellite, Time now);
  Broadcast finish(gnss::BroadcastMessage message);

  std::map<int, Gps> gps_;
  std::map<int, Galileo> galileo_;
  std::map<gnss::SatelliteKey, gnss::BroadcastMessage> last_;
};

}  // namespace binnacle::ublox
