// SPDX-License-Identifier: Apache-2.0
// Epochs of sentences: published values, midnight, what has no time, talkers, where an epoch ends, garbage.
#include "nmea/decoder.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include "catch.hpp"
#include "drive.hpp"

namespace decoder_test {

using namespace binnacle;
using namespace binnacle::nmea;
using namespace std::chrono;
using Outcome = Decoder::Outcome;

namespace {

using drive::degree;
using drive::knot;
constexpr Time s = nanoseconds_per_second;

/// Unix time: no leap seconds.
UtcClock unix_clock() {
  ParameterValue epoch, all;
  epoch.type = ParameterValue::Type::text;
  epoch.text = "1970-01-01";
  all.type = ParameterValue::Type::object;
  all.members = {{"epoch", epoch}};
  return UtcClock(Parameters(all));
}

struct Decoded {
  Decoder decoder;
  std::vector<Epoch> epochs;

  explicit Decoded(Decoder::Options options = {}) : decoder(unix_clock(), std::move(options)) {}
  Decoded& add(const std::string& body) {
    INFO(body);
    CHECK(decoder.take(drive::sentence(body), epochs) == Outcome::used);
    return *this;
  }
  Decoded& end() {
    decoder.finish(epochs);
    return *this;
  }
};

std::string rmc(const std::string& time, const std::string& date, const std::string& speed = "010.0") {
  return "GPRMC," + time + ",A,4807.038,N,01131.000,E," + speed + ",090.0," + date + ",,,A";
}
std::string gga(const std::string& time) {
  return "GPGGA," + time + ",4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,";
}

double at(const Epoch& epoch, int year, unsigned month_number, unsigned day_number) {
  const Day day = year_month_day{std::chrono::year(year), month(month_number), std::chrono::day(day_number)};
  return binnacle::seconds(epoch.t) - 86400.0 * static_cast<double>(day.time_since_epoch().count());
}

}  // namespace

TEST_CASE("published sentences have the values that their documents state") {
  Decoded all;
  CHECK(all.decoder.take("$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47", all.epochs) ==
        Outcome::used);
  CHECK(all.decoder.take("$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A", all.epochs) ==
        Outcome::used);
  all.add("GPGST,123519,0.006,0.023,0.020,273.6,0.023,0.020,0.031").add("GPHDT,274.07,T").end();
  REQUIRE(all.epochs.size() == 1);
  const Epoch& epoch = all.epochs.front();
  CHECK(at(epoch, 1994, 3, 23) == 12 * 3600 + 35 * 60 + 19);
  CHECK(epoch.has_position);
  CHECK(epoch.lat == (48 + 7.038 / 60) * degree);
  CHECK(epoch.lon == (11 + 31.0 / 60) * degree);
  CHECK(epoch.height == 545.4 + 46.9);  // above the ellipsoid
  CHECK(epoch.quality == 1);
  CHECK(epoch.satellites == 8);
  CHECK(epoch.hdop == 0.9);
  CHECK(epoch.speed == Approx(22.4 * knot).epsilon(1e-15));
  CHECK(epoch.course == 84.4 * degree);
  CHECK(epoch.position_sd == std::array<double, 3>{0.023, 0.020, 0.031});
  CHECK(epoch.yaw == 274.07 * degree);
}

TEST_CASE("VTG gives the velocity where RMC does not, and THS only where its mode is autonomous") {
  Decoded vtg({.date = Day(2026y / 11 / 23)});
  vtg.add(gga("120000")).add("GPVTG,054.7,T,034.4,M,005.5,N,010.2,K").add("GPTHS,77.52,E").end();
  REQUIRE(vtg.epochs.size() == 1);
  CHECK(vtg.epochs[0].speed == 5.5 * knot);
  CHECK(vtg.epochs[0].course == 54.7 * degree);
  CHECK(std::isnan(vtg.epochs[0].yaw));
  Decoded both;
  both.add(rmc("120000", "231126")).add("GPVTG,054.7,T,034.4,M,005.5,N,010.2,K").add("GPTHS,77.52,A").end();
  CHECK(both.epochs[0].speed == 10 * knot);
  CHECK(both.epochs[0].yaw == 77.52 * degree);
  Decoded invalid;
  invalid.add(rmc("120000", "231126", "")).add("GPVTG,054.7,T,,M,005.5,N,010.2,K,N").end();
  CHECK(std::isnan(invalid.epochs[0].speed));
}

TEST_CASE("without a fix there is no position, and no date is believed") {
  Decoded all;
  all.add("GPGGA,000001,,,,,0,00,,,M,,M,,").add("GPRMC,000001,V,,,,,,,060180,,,N").end();
  CHECK(all.epochs.empty());
  CHECK(all.decoder.counts().undated == 1);
  all.add("GPGGA,,,,,,0,00,,,M,,M,,").add("GPRMC,,V,,,,,,,,,,N").end();
  CHECK(all.decoder.counts().undated == 1);
}

TEST_CASE("midnight: the date of RMC, or the day after where the time of day falls back") {
  Decoded dated;
  for (const auto& [time, date] : {std::pair("235959.5", "311226"), std::pair("000000.0", "010127")})
    dated.add(gga(time)).add(rmc(time, date));
  dated.end();
  REQUIRE(dated.epochs.size() == 2);
  CHECK(dated.epochs[1].t - dated.epochs[0].t == s / 2);
  CHECK(at(dated.epochs[1], 2027, 1, 1) == 0);

  Decoded once;  // the date comes once a minute, as ZDA may
  once.add("GPZDA,235958,23,11,2026,00,00")
      .add(gga("235958"))
      .add(gga("235959"))
      .add(gga("000000"))
      .add(gga("000001"))
      .end();
  REQUIRE(once.epochs.size() == 4);
  for (std::size_t i = 1; i < 4; ++i) CHECK(once.epochs[i].t - once.epochs[i - 1].t == s);
  CHECK(at(once.epochs[3], 2026, 11, 24) == 1);

  Decoded given({.date = Day(2026y / 11 / 23)});
  given.add(gga("235959")).add(gga("000000")).end();
  REQUIRE(given.epochs.size() == 2);
  CHECK(at(given.epochs[0], 2026, 11, 23) == 86399);
  CHECK(at(given.epochs[1], 2026, 11, 24) == 0);
}

TEST_CASE("epochs before the first date are left out and counted") {
  Decoded all;
  all.add(gga("120000")).add(gga("120001")).add(gga("120002")).add(rmc("120002", "231126")).add(gga("120003")).end();
  CHECK(all.epochs.size() == 2);
  CHECK(all.decoder.counts().undated == 2);
}

TEST_CASE("an epoch is complete at the sentence that ended two, and no sentence of it is lost before that is known") {
  Decoded all;
  for (int i = 0; i < 6; ++i) {
    const std::string time = "12000" + std::to_string(i);
    all.add(gga(time)).add(rmc(time, "231126"));
    // The first two end when a third begins; from the third on each ends with its RMC.
    CHECK(all.epochs.size() == static_cast<std::size_t>(i < 2 ? i : i + 1));
  }
  all.end();
  REQUIRE(all.epochs.size() == 6);
  for (const Epoch& epoch : all.epochs) CHECK((epoch.quality == 1 && epoch.speed == 10 * knot));
}

TEST_CASE("a receiver that changes its order is followed, and what came too late is counted") {
  Decoded all;
  for (int i = 0; i < 4; ++i) {
    const std::string time = "12000" + std::to_string(i);
    all.add(gga(time)).add(rmc(time, "231126"));
  }
  for (int i = 4; i < 9; ++i) {
    const std::string time = "12000" + std::to_string(i);
    all.add(rmc(time, "231126")).add(gga(time));
  }
  all.end();
  REQUIRE(all.epochs.size() == 9);
  CHECK(all.decoder.counts().after_end == 1);
  CHECK(std::isnan(all.epochs[4].height));  // its GGA came after RMC
  for (std::size_t i = 5; i < 9; ++i) CHECK(std::isfinite(all.epochs[i].height));
}

TEST_CASE("ends_with: complete at once, and what follows without a time is of the next epoch") {
  Decoded all({.ends_with = "RMC"});
  for (int i = 0; i < 3; ++i) {
    const std::string time = "12000" + std::to_string(i);
    all.add("HEHDT,0" + std::to_string(10 + i) + ".0,T").add(gga(time)).add(rmc(time, "231126"));
    CHECK(all.epochs.size() == static_cast<std::size_t>(i + 1));
  }
  CHECK(std::isnan(all.epochs[0].yaw));  // before any time
  CHECK(all.epochs[1].yaw == 11 * degree);
  CHECK(all.epochs[2].yaw == 12 * degree);
  CHECK(all.decoder.counts().untimed == 1);
}

TEST_CASE("of headings within an epoch the first counts: the others have no time") {
  Decoded all;
  for (int i = 0; i < 4; ++i) {
    all.add(rmc("12000" + std::to_string(i), "231126"));
    for (int k = 0; k < 5; ++k) all.add("HEHDT,00" + std::to_string(k) + ".0,T");
  }
  all.end();
  REQUIRE(all.epochs.size() == 4);
  for (const Epoch& epoch : all.epochs) CHECK(epoch.yaw == 0);
  CHECK(all.decoder.counts().untimed == 16);
  CHECK(all.decoder.counts().after_end == 0);
}

TEST_CASE("talkers: all, or those that are chosen, and two that say the same are counted") {
  Decoded all;
  all.add(gga("120000"))
      .add("GNGGA,120000,5007.038,N,01131.000,E,4,20,0.5,545.4,M,46.9,M,,")
      .add(rmc("120000", "231126"))
      .end();
  CHECK(all.decoder.counts().two_talkers == 1);
  CHECK(all.epochs[0].quality == 4);
  std::vector<Epoch> epochs;
  Decoder chosen(unix_clock(), {.talkers = {"GP"}});
  CHECK(chosen.take(drive::sentence("GNGGA,120000,5007.038,N,01131.000,E,4,20,0.5,545.4,M,46.9,M,,"), epochs) ==
        Outcome::ignored);
  CHECK(chosen.take(drive::sentence(gga("120000")), epochs) == Outcome::used);
}

TEST_CASE("a height above the sea alone is none, unless the separation is given") {
  const std::string sea = "GPGGA,120000,4807.038,N,01131.000,E,1,08,0.9,545.4,M,,M,,";
  Decoded none({.date = Day(2026y / 11 / 23)});
  none.add(sea).end();
  CHECK(std::isnan(none.epochs[0].height));
  CHECK(none.decoder.counts().no_separation == 1);
  Decoded given({.geoid_separation = 46.9, .date = Day(2026y / 11 / 23)});
  given.add(sea).end();
  CHECK(given.epochs[0].height == 545.4 + 46.9);
  CHECK(given.decoder.counts().no_separation == 0);
}

TEST_CASE("an epoch that is not younger than the one before is left out and counted") {
  Decoded all;
  all.add(rmc("120002", "231126")).add(rmc("120001", "231126")).add(rmc("120003", "231126")).end();
  CHECK(all.epochs.size() == 2);
  CHECK(all.decoder.counts().backwards == 1);
}

TEST_CASE("fields that cannot be read are no sentence") {
  std::vector<Epoch> epochs;
  Decoder decoder(unix_clock(), {});
  for (const char* body : {"GPGGA,120000", "GPGGA,1200xx,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
                           "GPGGA,120000,4807.038,X,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
                           "GPRMC,120000,B,4807.038,N,01131.000,E,1,2,231126,,",
                           "GPRMC,120000,A,4807.038,N,01131.000,E,022.4,084.4,311126,,",
                           "GPRMC,120000,A,4807.038,N,01131.000,E,022.4,084.4,2311,,", "GPZDA,120000,31,02,2026,00,00",
                           "GPVTG,054.7,034.4,005.5,010.2", "GPHDT,274.07,M", "GPGST,120000,1,2,3,4,x,6,7"}) {
    INFO(body);
    CHECK(decoder.take(drive::sentence(body), epochs) == Outcome::unreadable);
  }
  CHECK(decoder.take(drive::sentence("GPGSV,3,1,11,03,03,111,00"), epochs) == Outcome::ignored);
  CHECK(epochs.empty());
}

TEST_CASE("whatever comes, what comes out is a position on the earth") {
  std::mt19937 random(1);
  const std::string alphabet = "$*,.0123456789ABCDEFGNPRTVWSE\r\xff";
  const std::vector<std::string> good{
      gga("120000"),    rmc("120000", "231126"),      "GPVTG,054.7,T,034.4,M,005.5,N,010.2,K",
      "GPHDT,274.07,T", "GPGST,120000,1,2,3,4,5,6,7", "GPZDA,120000,23,11,2026,00,00"};
  Decoder decoder(unix_clock(), {});
  std::vector<Epoch> epochs;
  int used = 0, refused = 0;
  for (int i = 0; i < 100'000; ++i) {
    std::string body = good[random() % good.size()];
    for (unsigned changes = random() % 4; changes > 0; --changes) {
      const auto where = random() % body.size();
      if (random() % 3 == 0)
        body.erase(where, 1 + random() % 5);
      else
        body[where] = alphabet[random() % alphabet.size()];
      if (body.empty()) body = "x";
    }
    const bool keeps_sum = random() % 2 == 0;
    const auto outcome = decoder.take(keeps_sum ? drive::sentence(body) : "$" + body + "*00", epochs);
    (outcome == Outcome::used ? used : refused) += 1;
  }
  CHECK(used > 10'000);
  CHECK(refused > 10'000);
  REQUIRE_FALSE(epochs.empty());
  for (const Epoch& epoch : epochs) {
    if (!epoch.has_position) continue;
    CHECK(std::abs(epoch.lat) <= std::numbers::pi / 2);
    CHECK(std::abs(epoch.lon) <= std::numbers::pi);
  }
}

}  // namespace decoder_test
