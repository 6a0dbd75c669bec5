// SPDX-License-Identifier: Apache-2.0
// Sentences: checksums of published ones, fields as they are written and read, UTC.
#include "nmea/sentence.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "catch.hpp"
#include "civil_time/utc_clock.hpp"

namespace sentence_test {

using namespace binnacle;
using namespace binnacle::nmea;
using binnacle::sentences::SentenceWriter;
using namespace std::chrono;

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

template <class Write>
std::string written(Write&& write) {
  std::string text;
  SentenceWriter out(text, "GP", "ABC");
  write(out);
  return text.substr(6);
}

UtcClock clock_with(std::vector<std::pair<std::string, ParameterValue>> members) {
  ParameterValue all;
  all.type = ParameterValue::Type::object;
  all.members = std::move(members);
  return UtcClock(Parameters(all));
}

ParameterValue integer(std::int64_t value) {
  ParameterValue v;
  v.type = ParameterValue::Type::integer;
  v.integer = value;
  return v;
}

ParameterValue text(const std::string& value) {
  ParameterValue v;
  v.type = ParameterValue::Type::text;
  v.text = value;
  return v;
}

constexpr Time s = nanoseconds_per_second;

}  // namespace

TEST_CASE("the checksums of published sentences are right") {
  // D. DePriest, "NMEA data" (gpsinformation.org); Trimble, "NMEA-0183 messages"; u-blox M8 protocol specification.
  for (const char* line :
       {"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47",
        "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A",
        "$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K*48", "$GPGST,172814.0,0.006,0.023,0.020,273.6,0.023,0.020,0.031*6A",
        "$GPGGA,172814.0,3723.46587704,N,12202.26957864,W,2,6,1.2,18.893,M,-25.669,M,2.0,0031*4F",
        "$GPRMC,225446,A,4916.45,N,12311.12,W,000.5,054.7,191194,020.3,E*68", "$GPTHS,77.52,E*34"}) {
    Sentence sentence;
    INFO(line);
    CHECK(parse(line, sentence) == SentenceFault::none);
    CHECK(sentence.talker == "GP");
  }
  CHECK(checksum("") == 0);
  CHECK(checksum("A") == 0x41);
  CHECK(checksum("AB") == 0x03);  // 0x41 ^ 0x42
}

TEST_CASE("what is no whole sentence is refused") {
  Sentence sentence;
  CHECK(parse("$GPHDT,123.456,T*32\r", sentence) == SentenceFault::none);
  CHECK(sentence[1] == "123.456");
  CHECK(sentence[9].empty());
  CHECK(parse("noise\x01\xff$GPRM$GPHDT,123.456,T*32", sentence) == SentenceFault::none);
  CHECK(parse("$GPHDT,123.456,T*33", sentence) == SentenceFault::checksum);
  CHECK(parse("$GPHDT,123.457,T*32", sentence) == SentenceFault::checksum);
  CHECK(parse("$GPHDT,123.456,T*3", sentence) == SentenceFault::cut);
  CHECK(parse("$GPHDT,123.456,T", sentence) == SentenceFault::cut);
  CHECK(parse("$GPHDT,123.456,T*3x", sentence) == SentenceFault::checksum);
  CHECK(parse("$GPHDT,123.456,T*32 and more", sentence) == SentenceFault::checksum);
  CHECK(parse("", sentence) == SentenceFault::no_sentence);
  CHECK(parse("no dollar*32", sentence) == SentenceFault::no_sentence);
  CHECK(parse("$PUBX,00*33", sentence) == SentenceFault::no_sentence);
  std::string many = "$GPGGA";
  many.append(200, ',');
  many += "*56";
  CHECK(parse(many, sentence) == SentenceFault::none);
  CHECK(sentence.count == Sentence::most_fields);
}

TEST_CASE("a sentence ends with its checksum in two digits and CR LF") {
  std::string text = "before";
  SentenceWriter out(text, "GP", "HDT");
  out.bearing(123.456 * degree, 3);
  out.letter('T');
  out.end();
  CHECK(text == "before$GPHDT,123.456,T*32\r\n");
}

TEST_CASE("coordinates are degrees and minutes, and carry where minutes round up to sixty") {
  const auto latitude = [](double angle) { return written([&](auto& out) { out.latitude(angle); }); };
  const auto longitude = [](double angle) { return written([&](auto& out) { out.longitude(angle); }); };
  CHECK(latitude((48 + 7.038 / 60) * degree) == ",4807.0380000,N");
  CHECK(longitude((11 + 31.0 / 60) * degree) == ",01131.0000000,E");
  CHECK(latitude(-(12 + 0.5 / 60) * degree) == ",1200.5000000,S");
  CHECK(longitude(-0.25 * degree) == ",00015.0000000,W");
  CHECK(latitude((48 + 59.99999999 / 60) * degree) == ",4900.0000000,N");
  CHECK(latitude((48 + 59.9999999 / 60) * degree) == ",4859.9999999,N");
  CHECK(longitude(std::numbers::pi) == ",18000.0000000,E");
  CHECK(latitude(not_known) == ",,");
}

TEST_CASE("bearings run from 0 up to 360") {
  const auto bearing = [](double angle) { return written([&](auto& out) { out.bearing(angle, 3); }); };
  CHECK(bearing(0) == ",000.000");
  CHECK(bearing(-1 * degree) == ",359.000");
  CHECK(bearing(359.9994 * degree) == ",359.999");
  CHECK(bearing(359.9996 * degree) == ",000.000");
  CHECK(bearing(-0.0004 * degree) == ",000.000");
  CHECK(bearing(725.5 * degree) == ",005.500");
  CHECK(bearing(not_known) == ",");
}

TEST_CASE("numbers, times and dates") {
  CHECK(written([](auto& out) { out.number(-25.6687, 3); }) == ",-25.669");
  CHECK(written([](auto& out) { out.number(not_known, 3); }) == ",");
  const auto time = [](Time t) { return written([&](auto& out) { out.time_of_day(t); }); };
  CHECK(time(0) == ",000000.000");
  CHECK(time(45319 * s + 5'000'000) == ",123519.005");
  CHECK(time(86399 * s + 999'999'999) == ",235959.999");
  CHECK(time(86400 * s + 500'000'000) == ",235960.500");
  CHECK(written([](auto& out) { out.date(Day(1994y / 3 / 23)); }) == ",230394");
  CHECK(written([](auto& out) { out.date(Day(2006y / 12 / 1)); }) == ",011206");
}

TEST_CASE("fields are read, and what is none is refused") {
  std::optional<double> number;
  CHECK((parse_number("-25.669", number) && number == -25.669));
  CHECK((parse_number("", number) && !number));
  for (const char* bad : {"1,2", "1e3", "x", "1 ", "nan", "inf", "+1", "--1"}) {
    INFO(bad);
    CHECK_FALSE(parse_number(bad, number));
  }
  std::optional<Time> time;
  CHECK((parse_time_of_day("123519", time) && time == 45319 * s));
  CHECK((parse_time_of_day("172814.25", time) && time == 62894 * s + 250'000'000));
  CHECK((parse_time_of_day("235960.5", time) && time == 86400 * s + 500'000'000));
  CHECK((parse_time_of_day("", time) && !time));
  for (const char* bad : {"12351", "240000", "126019", "123560", "1235x9", "12.3519", "123519.", "1235190", "-12351"}) {
    INFO(bad);
    const bool is_read = parse_time_of_day(bad, time);
    CHECK(is_read == (std::string(bad) == "123519."));  // nothing after the point is nothing
  }
  std::optional<double> angle;
  REQUIRE(parse_coordinate("4807.038", "N", angle));
  CHECK(*angle == (48 + 7.038 / 60) * degree);
  REQUIRE(parse_coordinate("12311.12", "W", angle));
  CHECK(*angle == -(123 + 11.12 / 60) * degree);
  REQUIRE(parse_coordinate("", "", angle));
  CHECK_FALSE(angle);
  for (const auto& [field, sign] : {std::pair("4807.038", ""), std::pair("4807.038", "E"), std::pair("04807.038", "N"),
                                    std::pair("4860.000", "N"), std::pair("9100.00", "N"), std::pair("18000.01", "E"),
                                    std::pair("48x7.0", "N"), std::pair("4807.038", "NN"), std::pair("", "N")}) {
    INFO(field << " " << sign);
    CHECK_FALSE(parse_coordinate(field, sign, angle));
  }
}

TEST_CASE("GPS time and UTC differ by the leap seconds of the date") {
  const UtcClock clock = clock_with({});
  const auto of = [&](Time t) { return clock.utc(t); };
  CHECK(of(0).day == Day(1980y / 1 / 6));
  CHECK(of(0).of_day == 0);
  // Week 2086, of 2019-12-29: GPS − UTC = 18 s. RTKLIB's gpst2utc gives 23:59:42 of the day before.
  const UtcClock week = clock_with({{"week", integer(2086)}});
  CHECK(week.utc(0).day == Day(2019y / 12 / 28));
  CHECK(week.utc(0).of_day == (86400 - 18) * s);
  CHECK(week.time({Day(2019y / 12 / 29), 0}) == 18 * s);
  // Week 1042 begins on 1999-12-26: 13 s.
  CHECK(clock_with({{"week", integer(1042)}}).utc(13 * s).of_day == 0);
  CHECK(clock_with({{"week", integer(2086)}, {"leap_seconds", integer(20)}}).utc(20 * s).of_day == 0);
}

TEST_CASE("the leap second of 2016-12-31 is 23:59:60, there and back") {
  const UtcClock clock = clock_with({{"week", integer(1930)}});  // from 2017-01-01 0:00 of GPS time
  const Time begin = 17 * s;                                     // of the leap second
  const Utc before = clock.utc(begin - 1), inside = clock.utc(begin + s / 2), after = clock.utc(begin + s);
  CHECK(before.day == Day(2016y / 12 / 31));
  CHECK(before.of_day == 86400 * s - 1);
  CHECK(inside.day == Day(2016y / 12 / 31));
  CHECK(inside.of_day == 86400 * s + s / 2);
  CHECK(after.day == Day(2017y / 1 / 1));
  CHECK(after.of_day == 0);
  for (Time t = 0; t < 30 * s; t += s / 4) CHECK(clock.time(clock.utc(t)) == t);
}

TEST_CASE("an epoch of UTC counts no leap seconds") {
  const UtcClock clock = clock_with({{"epoch", text("2026-11-23T12:00:05Z")}});
  CHECK(clock.utc(-6 * s).of_day == 43199 * s);
  CHECK(clock.utc(43195 * s).day == Day(2026y / 11 / 24));
  const UtcClock unix_time = clock_with({{"epoch", text("1970-01-01")}});
  CHECK(unix_time.time({Day(2017y / 1 / 1), 0}) == 1'483'228'800 * s);  // date -u -d 2017-01-01 +%s
  for (const char* same : {"2026-11-23T12:00", "2026-11-23 12:00", "2026-11-23T13:00+01:00", "20261123T1200Z"}) {
    INFO(same);
    CHECK(clock_with({{"epoch", text(same)}}).utc(0).of_day == 43200 * s);
  }
  for (const char* bad :
       {"2026-02-29", "2026-11-23T12:00+24:00", "2026-11-23T24:00", "2026-11-23T12:00:60", "23.11.2026", "now"}) {
    INFO(bad);
    CHECK_THROWS_AS(clock_with({{"epoch", text(bad)}}), ComponentError);
  }
  CHECK_THROWS_AS(clock_with({{"epoch", text("2026-11-23")}, {"week", integer(0)}}), ComponentError);
  CHECK_THROWS_AS(clock_with({{"epoch", text("2026-11-23")}, {"leap_seconds", integer(18)}}), ComponentError);
}

}  // namespace sentence_test
