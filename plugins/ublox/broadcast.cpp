// SPDX-License-Identifier: Apache-2.0
// GPS: IS-GPS-200 20.3 (subframes, parity, tables 20-I to 20-IV). Galileo: OS SIS ICD issue 2.0, 4.3 (I/NAV pages and words),
// 5.1. How words lie in RXM-SFRBX: u-blox interface description, "broadcast navigation data".
#include "broadcast.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "civil_time/utc_clock.hpp"

namespace binnacle::ublox {

namespace {

constexpr double semicircle = std::numbers::pi;
using civil_time::week_length;

double power(int exponent) { return std::ldexp(1.0, exponent); }

/// The instant of a time of week that is nearest to `now`.
Time nearest(std::uint32_t seconds_of_week, Time now) {
  const Time of_week = Time{seconds_of_week} * nanoseconds_per_second;
  Time t = now - now % week_length + of_week;
  if (t - now > week_length / 2) t -= week_length;
  if (now - t > week_length / 2) t += week_length;
  return t;
}

/// A week number of so many bits, as it is nearest to that of `now`, is that of now or next to it.
bool is_week_of(std::uint32_t number, int bits, std::int64_t zero, Time now) {
  const std::int64_t cycle = std::int64_t{1} << bits;
  const std::int64_t apart = ((now / week_length - zero - number) % cycle + cycle) % cycle;
  return apart <= 1 || apart == cycle - 1;
}

/// IS-GPS-200 table 20-XIV: d25 … d30 of a word's 24 bits, which are as transmitted before they were inverted.
std::uint32_t parity(std::uint32_t data, std::uint32_t d29, std::uint32_t d30) {
  constexpr std::array<std::uint32_t, 6> masks{0xEC7CD2, 0x763E69, 0xBB1F34, 0x5D8F9A, 0xAEC7CD, 0x2DEA27};
  const std::array<std::uint32_t, 6> before{d29, d30, d29, d30, d30, d29};
  std::uint32_t all = 0;
  for (std::size_t i = 0; i < 6; ++i)
    all = all << 1 | ((static_cast<std::uint32_t>(std::popcount(data & masks[i])) & 1u) ^ before[i]);
  return all;
}

/// Bits 31 and 30 of a word are the last two of the word before it; where firmware leaves them out, that word has them.
bool has_right_parity(std::uint32_t word, std::uint32_t before) {
  const std::uint32_t data = word >> 6 & 0xFFFFFF;
  return parity(data, word >> 31, word >> 30 & 1u) == (word & 0x3F) ||
         parity(data, before >> 1 & 1u, before & 1u) == (word & 0x3F);
}

/// IS-GPS-200 20.3.3.3.1.3, nominal values [m]; 0: no prediction.
double user_range_accuracy(std::uint32_t index) {
  constexpr std::array<double, 15> table{2, 2.8, 4, 5.7, 8, 11.3, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096};
  return index < table.size() ? table[index] : 0;
}

/// OS SIS ICD table 76 [m]; 0: no accuracy prediction.
double signal_in_space_accuracy(std::uint32_t index) {
  const double i = index;
  if (index < 50) return 0.01 * i;
  if (index < 75) return 0.5 + 0.02 * (i - 50);
  if (index < 100) return 1 + 0.04 * (i - 75);
  if (index < 126) return 2 + 0.16 * (i - 100);
  return 0;
}

/// OS SIS ICD 5.1.9.4.
template <std::size_t Size>
std::uint32_t crc24q(const Bits<Size>& bits, std::size_t count) {
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t bit = bits.bytes[i / 8] >> (7 - i % 8) & 1u;
    const bool is_set = ((crc >> 23 & 1u) ^ bit) != 0;
    crc = crc << 1 & 0xFFFFFF;
    if (is_set) crc ^= 0x864CFB;
  }
  return crc;
}

/// Subframes 1 to 3, each 10 words of 24 bits.
gnss::BroadcastMessage message_of(const Bits<30>& first, const Bits<30>& second, const Bits<30>& third, Time now) {
  gnss::BroadcastMessage m;
  gnss::Ephemeris& e = m.ephemeris;
  BitReader<30> a(first, 60);  // word 3, behind week number and code
  e.accuracy = user_range_accuracy(a.u(4));
  m.is_healthy = a.u(6) == 0;
  BitReader<30> b(first, 160);
  e.group_delay = b.scaled_signed(8, power(-31));
  b.skip(8);  // issue of data, clock
  const std::uint32_t toc = b.u(16) * 16;
  e.af2 = b.scaled_signed(8, power(-55));
  e.af1 = b.scaled_signed(16, power(-43));
  e.af0 = b.scaled_signed(22, power(-31));

  BitReader<30> c(second, 48);
  e.issue = c.u(8);
  e.crs = c.scaled_signed(16, power(-5));
  e.delta_n = c.scaled_signed(16, power(-43) * semicircle);
  e.m0 = c.scaled_signed(32, power(-31) * semicircle);
  e.cuc = c.scaled_signed(16, power(-29));
  e.eccentricity = c.scaled(32, power(-33));
  e.cus = c.scaled_signed(16, power(-29));
  const double root = c.scaled(32, power(-19));
  e.semi_major_axis = root * root;
  const std::uint32_t toe = c.u(16) * 16;

  BitReader<30> d(third, 48);
  e.cic = d.scaled_signed(16, power(-29));
  e.omega0 = d.scaled_signed(32, power(-31) * semicircle);
  e.cis = d.scaled_signed(16, power(-29));
  e.i0 = d.scaled_signed(32, power(-31) * semicircle);
  e.crc = d.scaled_signed(16, power(-5));
  e.perigee = d.scaled_signed(32, power(-31) * semicircle);
  e.omega_dot = d.scaled_signed(24, power(-43) * semicircle);
  d.skip(8);
  e.i_dot = d.scaled_signed(14, power(-43) * semicircle);

  m.toe = nearest(toe, now);
  e.toe = seconds(m.toe);
  e.toc = seconds(nearest(toc, m.toe));
  return m;
}

/// Words 1 to 5.
gnss::BroadcastMessage message_of(const std::array<std::optional<Bits<16>>, 5>& words, Time now) {
  gnss::BroadcastMessage m;
  gnss::Ephemeris& e = m.ephemeris;
  BitReader<16> a(*words[0], 6);
  e.issue = a.u(10);
  const std::uint32_t toe = a.u(14) * 60;
  e.m0 = a.scaled_signed(32, power(-31) * semicircle);
  e.eccentricity = a.scaled(32, power(-33));
  const double root = a.scaled(32, power(-19));
  e.semi_major_axis = root * root;
  BitReader<16> b(*words[1], 16);
  e.omega0 = b.scaled_signed(32, power(-31) * semicircle);
  e.i0 = b.scaled_signed(32, power(-31) * semicircle);
  e.perigee = b.scaled_signed(32, power(-31) * semicircle);
  e.i_dot = b.scaled_signed(14, power(-43) * semicircle);
  BitReader<16> c(*words[2], 16);
  e.omega_dot = c.scaled_signed(24, power(-43) * semicircle);
  e.delta_n = c.scaled_signed(16, power(-43) * semicircle);
  e.cuc = c.scaled_signed(16, power(-29));
  e.cus = c.scaled_signed(16, power(-29));
  e.crc = c.scaled_signed(16, power(-5));
  e.crs = c.scaled_signed(16, power(-5));
  e.accuracy = signal_in_space_accuracy(c.u(8));
  BitReader<16> d(*words[3], 22);
  e.cic = d.scaled_signed(16, power(-29));
  e.cis = d.scaled_signed(16, power(-29));
  const std::uint32_t toc = d.u(14) * 60;
  e.af0 = d.scaled_signed(31, power(-34));
  e.af1 = d.scaled_signed(21, power(-46));
  e.af2 = d.scaled_signed(6, power(-59));
  BitReader<16> f(*words[4], 57);                   // behind the ionosphere and BGD(E1, E5a)
  e.group_delay = f.scaled_signed(10, power(-32));  // BGD(E1, E5b): the I/NAV clock
  f.skip(2);                                        // E5b health
  const bool is_well = f.u(2) == 0;
  f.skip(1);  // E5b data validity
  m.is_healthy = is_well && f.u(1) == 0;
  m.toe = nearest(toe, now);
  e.toe = seconds(m.toe);
  e.toc = seconds(nearest(toc, m.toe));
  return m;
}

bool is_same(const gnss::BroadcastMessage& a, const gnss::BroadcastMessage& b) {
  const gnss::Ephemeris &x = a.ephemeris, &y = b.ephemeris;
  return a.toe == b.toe && a.is_healthy == b.is_healthy && x.issue == y.issue && x.toc == y.toc && x.af0 == y.af0 &&
         x.af1 == y.af1 && x.m0 == y.m0 && x.accuracy == y.accuracy && x.group_delay == y.group_delay;
}

}  // namespace

Broadcast BroadcastCollector::take(const Payload& payload, Time now) {
  Broadcast result;
  if (payload.size() < 8 || payload.size() != 8u + 4u * payload.u1(4) || payload.u1(6) < 1 || payload.u1(6) > 2) {
    result.fault = "its length or version is not known";
    return result;
  }
  const int system = payload.u1(0), satellite = payload.u1(1);
  const int signal = payload.u1(6) == 2 ? payload.u1(2) : 0, words = payload.u1(4);
  if (system == 0 && signal == 0 && words == 10 && satellite >= 1 && satellite <= 32)
    return take_lnav(payload, satellite, now);
  const bool is_inav = signal == 0 || signal == 1 || signal == 5 || signal == 6;
  if (system == 2 && is_inav && (words == 8 || words == 9) && satellite >= 1 && satellite <= 36)
    return take_inav(payload, satellite, now);
  result.ignored = system == 0   ? "of GPS and not LNAV"
                   : system == 2 ? "of Galileo and not I/NAV"
                                 : "of other systems than GPS and Galileo";
  return result;
}

Broadcast BroadcastCollector::take_lnav(const Payload& payload, int satellite, Time now) {
  Broadcast result;
  Bits<lnav_bytes> bits;
  for (std::size_t i = 0; i < 10; ++i) {
    const std::uint32_t word = payload.u4(8 + 4 * i);
    if (i > 0 && !has_right_parity(word, payload.u4(4 + 4 * i))) {
      result.fault = "its parity is wrong";
      return result;
    }
    bits.set(24 * i, 24, word >> 6 & 0xFFFFFF);
  }
  if (bits.unsigned_at(0, 8) != 0x8B) {
    result.fault = "it does not begin with the preamble";
    return result;
  }
  const std::uint32_t number = bits.unsigned_at(43, 3);
  if (number == 4 && bits.unsigned_at(50, 6) == 56) {  // page 18
    BitReader<lnav_bytes> r(bits, 56);
    result.klobuchar.emplace();
    for (int i = 0; i < 4; ++i)
      result.klobuchar->alpha[i] =
          r.scaled_signed(8, power(std::array{-30, -27, -24, -24}[static_cast<std::size_t>(i)]));
    for (int i = 0; i < 4; ++i)
      result.klobuchar->beta[i] = r.scaled_signed(8, power(std::array{11, 14, 16, 16}[static_cast<std::size_t>(i)]));
  }
  if (number < 1 || number > 3) return result;
  Gps& gps = gps_[satellite];
  gps.subframes[number - 1] = bits;
  const auto& s = gps.subframes;
  if (!s[0] || !s[1] || !s[2]) return result;
  // One issue: IODC's lower byte, IODE of subframes 2 and 3. Else a part of a new one has not come yet.
  const std::uint32_t issue = s[1]->unsigned_at(48, 8);
  if (s[0]->unsigned_at(168, 8) != issue || s[2]->unsigned_at(216, 8) != issue) return result;
  if (!is_week_of(s[0]->unsigned_at(48, 10), 10, 0, now)) {
    result.fault = "its week is not that of the data";
    return result;
  }
  auto message = message_of(*s[0], *s[1], *s[2], now);
  message.ephemeris.satellite = gnss::satellite_key(gnss::Constellation::gps, satellite);
  message.uploaded = now;
  return finish(std::move(message));
}

Broadcast BroadcastCollector::take_inav(const Payload& payload, int satellite, Time now) {
  Broadcast result;
  Bits<32> page;  // even part, odd part: 128 bits each
  for (std::size_t i = 0; i < 8; ++i) page.set(32 * i, 32, payload.u4(8 + 4 * i));
  if (page.unsigned_at(1, 1) == 1 || page.unsigned_at(129, 1) == 1) {
    result.ignored = "of Galileo that are alert pages";
    return result;
  }
  Bits<28> checked;  // 114 and 82 bits
  for (std::size_t i = 0; i < 114; ++i) checked.set(i, 1, page.unsigned_at(i, 1));
  for (std::size_t i = 0; i < 82; ++i) checked.set(114 + i, 1, page.unsigned_at(128 + i, 1));
  if (page.unsigned_at(0, 1) != 0 || page.unsigned_at(128, 1) != 1 ||
      crc24q(checked, 196) != page.unsigned_at(210, 24)) {
    result.fault = "its CRC is wrong";
    return result;
  }
  Bits<inav_bytes> word;
  for (std::size_t i = 0; i < 112; ++i) word.set(i, 1, page.unsigned_at(2 + i, 1));
  word.set(112, 16, page.unsigned_at(130, 16));
  const std::uint32_t type = word.unsigned_at(0, 6);
  if (type < 1 || type > 5) return result;
  Galileo& galileo = galileo_[satellite];
  galileo.words[type - 1] = word;
  const auto& w = galileo.words;
  for (const auto& each : w)
    if (!each) return result;
  for (std::size_t i = 1; i < 4; ++i)
    if (w[i]->unsigned_at(6, 10) != w[0]->unsigned_at(6, 10)) return result;
  if (w[3]->unsigned_at(16, 6) != static_cast<std::uint32_t>(satellite)) {
    result.fault = "its satellite is not that which the receiver names";
    return result;
  }
  constexpr std::int64_t galileo_zero = 1024;  // GPS weeks
  if (!is_week_of(w[4]->unsigned_at(73, 12), 12, galileo_zero, now)) {
    result.fault = "its week is not that of the data";
    return result;
  }
  auto message = message_of(w, now);
  message.ephemeris.satellite = gnss::satellite_key(gnss::Constellation::galileo, satellite);
  message.uploaded = now;
  return finish(std::move(message));
}

/// One that was known already is sent again and again.
Broadcast BroadcastCollector::finish(gnss::BroadcastMessage message) {
  Broadcast result;
  const auto known = last_.find(message.ephemeris.satellite);
  if (known != last_.end() && is_same(known->second, message)) return result;
  if (!gnss::is_usable(message.ephemeris)) {
    result.fault = "its orbit or clock is not plausible for a satellite";
    return result;
  }
  last_[message.ephemeris.satellite] = message;
  result.message = std::move(message);
  return result;
}

}  // namespace binnacle::ublox
