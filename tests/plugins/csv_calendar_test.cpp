// SPDX-License-Identifier: Apache-2.0
// csv: calendar times and GPS weeks as labels, decimal commas, several samples made one.
#include <cmath>
#include <string>
#include <vector>

#include "catch.hpp"
#include "civil_time/iso8601.hpp"
#include "csv_files.hpp"

namespace csv_calendar_test {

using namespace binnacle;
using namespace binnacle::csv_files;
using binnacle::test::Contains;

namespace {

constexpr Time second = nanoseconds_per_second;
constexpr Time noon = 1479470418;  // 2026-11-23T12:00:00Z as GPS time since 1980-01-06, 18 leap seconds [s]

/// One field `a`; `time` as given.
Json timed(const std::string& path, Members time) {
  return with_member(parameters(path, {{"a", column("a")}}), "time", object(std::move(time)));
}

Json iso(const std::string& path) { return timed(path, {{"format", "iso8601"}}); }

std::vector<Time> times_of(const Json& value) {
  std::vector<Time> times;
  for (const Sample& sample : read(value)) times.push_back(sample.t);
  return times;
}

/// Of a file with this one label.
Time time_of(const std::string& label, Time zone = 0) {
  const TemporaryFile file("t,a\n\"" + label + "\",1\n");
  return times_of(timed(file.path(), {{"format", "iso8601"}, {"zone", seconds(zone)}})).at(0);
}

std::string fault_of_label(const std::string& label) {
  const TemporaryFile file("t,a\n\"" + label + "\",1\n");
  return fault_of(iso(file.path()));
}

}  // namespace

TEST_CASE("csv: times of ISO 8601, with fractions and zones, are GPS time", "[csv]") {
  CHECK(time_of("2026-11-23T12:00:00Z") == noon * second);
  CHECK(time_of("2026-11-23T12:00:00.25Z") == noon * second + second / 4);
  CHECK(time_of("2026-11-23 12:00:00,123456789") == noon * second + 123456789);
  CHECK(time_of("20261123T120000Z") == noon * second);
  CHECK(time_of("2026-11-23T12:00Z") == noon * second);
  CHECK(time_of("2026-11-23T13:00:00+01:00") == noon * second);
  CHECK(time_of("2026-11-23T06:30:00-0530") == noon * second);
  CHECK(time_of("2026-11-24T01:00:00+13") == noon * second);
  CHECK(time_of("2026-11-23T11:59:59.9999999996Z") == noon * second);
  // A zone of the config counts where the cell has none.
  CHECK(time_of("2026-11-23T13:00:00", 3600 * second) == noon * second);
  CHECK(time_of("2026-11-23T12:00:00Z", 3600 * second) == noon * second);
  // The last leap second, and the second after it.
  CHECK(time_of("2016-12-31T23:59:60Z") == Time{1167264017} * second);
  CHECK(time_of("2016-12-31T18:59:60.5-05:00") == Time{1167264017} * second + second / 2);
  CHECK(time_of("2017-01-01T00:00:00Z") == Time{1167264018} * second);
}

TEST_CASE("csv: what is no time of ISO 8601 is a fault", "[csv]") {
  for (const char* label :
       {"noon", "2026-11-23", "2026-11-31T12:00:00Z", "2026-11-23T24:00:00Z", "2026-11-23T12:60:00Z",
        "2026-11-23T12:00:61Z", "2026-11-23T12:00:60Z", "2026-11-23T12:00:00.Z", "2026-11-23T12Z",
        "2026-11-23T12:00:00+1", "2026-11-23T12:00:00+25:00", "2026-11-23T12:00:00Zulu", "12:00:00",
        "2026-11-23T12:00:00 ", "1e9", "26-11-23T12:00:00Z", "2300-01-01T00:00:00Z"}) {
    INFO(label);
    if (std::string(label).back() == ' ') continue;  // blanks around cells go
    CHECK(fault_of_label(label) == "B062 line 2: time column 't': '" + std::string(label) +
                                       "' is not a time of ISO 8601, as 2026-11-23T12:00:05.25Z is");
  }
  CHECK(fault_of_label("") == "B062 line 2: time column 't' is empty");
}

TEST_CASE("csv: date and time in two columns, in any order", "[csv]") {
  const auto read_date = [](const std::string& date, const std::string& order, const std::string& time) {
    const TemporaryFile file("d,t,a\n" + date + "," + time + ",1\n");
    return times_of(timed(file.path(), {{"column", "t"}, {"date_column", "d"}, {"date_order", order}}));
  };
  const std::vector<Time> expected{noon * second + second / 2};
  CHECK(read_date("2026-11-23", "ymd", "12:00:00.5") == expected);
  CHECK(read_date("2026/11/23", "ymd", "120000.5") == expected);
  CHECK(read_date("20261123", "ymd", "12:00:00.50Z") == expected);
  CHECK(read_date("23.11.2026", "dmy", "12:00:00.5") == expected);
  CHECK(read_date("23112026", "dmy", "13:00:00.5+01:00") == expected);
  CHECK(read_date("11/23/2026", "mdy", "12:00:00.5") == expected);
  const auto fault = [](const std::string& date, const std::string& time) {
    const TemporaryFile file("d,t,a\n" + date + "," + time + ",1\n");
    return fault_of(timed(file.path(), {{"column", "t"}, {"date_column", "d"}}));
  };
  CHECK(fault("23.11.2026", "12:00:00") ==
        "B062 line 2: time column 'd': '23.11.2026' is not a date of year, month, day");
  CHECK(fault("2026-11-23", "25:00") ==
        "B062 line 2: time column 't': '25:00' is not a time of day, as 12:00:05.25 is");
  CHECK(fault("2026-11-23", "11:59:60") ==
        "B062 line 2: time column 't': '11:59:60' is a leap second at the wrong time");
  CHECK(fault("", "12:00:00") == "B062 line 2: time column 'd' is empty");
}

TEST_CASE("csv: GPS week and seconds", "[csv]") {
  const TemporaryFile file("wn,tow,a\n2446,129618,1\n2446,129618.123456789,2\n2447,0.5,3\n");
  const auto value = timed(file.path(), {{"column", "tow"}, {"week_column", "wn"}});
  CHECK(times_of(value) ==
        std::vector<Time>{noon * second, noon * second + 123456789, 2447 * civil_time::week_length + second / 2});
  // Of a week that is counted from, and as Unix time, 18 s behind.
  CHECK(times_of(with_member(value, "week", 2446)).at(0) == 129618 * second);
  CHECK(times_of(with_member(value, "epoch", "2026-11-23T11:00:00Z")).at(0) == 3600 * second);
  const auto milliseconds = timed(file.path(), {{"column", "tow"}, {"week_column", "wn"}, {"unit", unit("s", 1e-3)}});
  CHECK(times_of(milliseconds).at(0) == 2446 * civil_time::week_length + 129618000000);
  const auto fault = [](const std::string& row) {
    const TemporaryFile spoilt("wn,tow,a\n" + row + ",1\n");
    return fault_of(timed(spoilt.path(), {{"column", "tow"}, {"week_column", "wn"}}));
  };
  CHECK(fault("-1,5") == "B062 line 2: time column 'wn': '-1' is no GPS week");
  CHECK(fault("2446.5,5") == "B062 line 2: time column 'wn': '2446.5' is no GPS week");
  CHECK(fault("nan,5") == "B062 line 2: time column 'wn': 'nan' is no GPS week");
  CHECK(fault("2446,604801") == "B062 line 2: time column 'tow': '604801' is not a time of a week, which has 604800 s");
  CHECK(fault("2446,x") == "B062 line 2: time column 'tow': 'x' is not a number");
}

TEST_CASE("csv: calendar labels that do not go together point at the config", "[csv]") {
  const TemporaryFile file("d,t,a\n2026-11-23,12:00:00,1\n");
  const auto said = [&](Members time) { return fault_of(timed(file.path(), std::move(time))); };
  CHECK_THAT(said({{"format", "iso8601"}, {"date_column", "d"}}), Contains("/time/date_column: a time of ISO"));
  CHECK_THAT(said({{"format", "iso8601"}, {"week_column", "d"}}), Contains("/time/week_column: a time of ISO"));
  CHECK_THAT(said({{"date_column", "d"}, {"week_column", "d"}}), Contains("/time/week_column: there is 'date"));
  CHECK_THAT(said({{"zone", 3600}}), Contains("/time/zone: a zone belongs to calendar times"));
  CHECK_THAT(said({{"column", "t"}, {"date_column", "t"}}), Contains("/time/date_column: it is the column"));
  CHECK_THAT(said({{"format", "iso8601"}, {"unit", unit("s", 1e-3)}}), Contains("/time/unit: calendar times have"));
  CHECK_THAT(said({{"column", "t"}, {"date_column", "date"}}), Contains("/time/date_column: no column 'date'"));
  const auto numbers = parameters(file.path(), {{"a", column("a")}});
  CHECK_THAT(fault_of(with_member(numbers, "week", 2446)), Contains("/week: it gives the origin of time"));
  CHECK_THAT(fault_of(with_member(numbers, "epoch", "1970-01-01")), Contains("/epoch: it gives the origin of time"));
}

TEST_CASE("csv: spoilt calendar rows are skipped on request, and counted", "[csv]") {
  const TemporaryFile file(
      "t,a\n2026-11-23T12:00:00Z,1\nnoon,2\n2026-11-23T12:00:01Z,3\n2026-11-23T12:00:01Z,4\n2026-11-23T12:00:02Z,x\n"
      "2026-11-23T12:00:03Z,5\n");
  Warnings warnings;
  const auto samples = read(with_member(iso(file.path()), "invalid_rows", "skip"), &warnings);
  CHECK(samples.size() == 3);
  REQUIRE(warnings.all.size() == 2);
  CHECK_THAT(warnings.all[0].message, Contains("2 rows skipped, the first: time column 't': 'noon' is not a time"));
  CHECK_THAT(warnings.all[1].message, Contains("1 row skipped: time does not increase"));
}

TEST_CASE("csv: decimal commas", "[csv]") {
  const TemporaryFile file("t;a\n0,25;-1,5\n1e0;2,5e1\n2;3\n");
  const auto value =
      with_member(with_member(parameters(file.path(), {{"a", column("a")}}), "delimiter", ";"), "decimal", ",");
  const auto samples = read(value);
  REQUIRE(samples.size() == 3);
  CHECK(samples[0].t == second / 4);
  CHECK(samples[0].fields[0] == -1.5);
  CHECK(samples[1].fields[0] == 25);
  // A point may be a thousand's: 1.234 is not read as something else.
  const TemporaryFile points("t;a\n0;1.234\n");
  CHECK(fault_of(with_member(with_member(parameters(points.path(), {{"a", column("a")}}), "delimiter", ";"), "decimal",
                             ",")) == "B062 line 2: column 'a': '1.234' is not a number");
  CHECK(fault_of(with_member(parameters(file.path(), {{"a", column("a")}}), "delimiter", ";")) ==
        "B062 line 2: time column 't': '0,25' is not a number; for decimal commas set \"decimal\": \",\"");
  CHECK_THAT(fault_of(with_member(parameters(file.path(), {{"a", column("a")}}), "decimal", ",")),
             Contains("/decimal: decimal commas need another delimiter"));
}

TEST_CASE("csv: every so many samples one: levels stay, rates are averaged, increments summed", "[csv]") {
  std::string content = "t,w,a\n";
  for (int i = 0; i < 8; ++i)
    content += std::to_string(i) + "," + std::to_string(10 * i) + "," + std::to_string(i) + "\n";
  const TemporaryFile file(content);
  const auto levels = read(with_member(parameters(file.path(), {{"a", column("a")}}), "every", 3));
  REQUIRE(levels.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(levels[i].t == static_cast<Time>(3 * i) * second);
    CHECK(levels[i].fields[0] == 3.0 * static_cast<double>(i));
  }
  const auto value = parameters(file.path(), {{"w", column("w", unit("rad/s"), "rate")},
                                              {"dv", column("w", unit("m/s"), "increment")},
                                              {"a", column("a", unit("m"))}});
  const auto joined = read(with_member(value, "every", 3));
  // The first row starts the clock; 1 2 3, 4 5 6, and 7, at the end, alone.
  REQUIRE(joined.size() == 4);
  CHECK(joined[0].t0 == no_time);
  CHECK(joined[1].t0 == 0);
  CHECK(joined[1].t == 3 * second);
  CHECK(joined[1].fields == std::vector<double>{20, 60, 3});
  CHECK(joined[2].fields == std::vector<double>{50, 150, 6});
  CHECK(joined[3].t0 == 6 * second);
  CHECK(joined[3].fields == std::vector<double>{70, 70, 7});
}

TEST_CASE("csv: samples put together are weighted by their time, and end at a gap", "[csv]") {
  const TemporaryFile file("t,w,a\n0,9,0\n1,1,0\n3,4,0\n4,6,0\n10,8,0\n11,2,0\n13,5,0\n");
  auto value = parameters(file.path(), {{"w", column("w", unit("rad/s"), "rate")}});
  value = with_member(with_member(value, "max_gap", 3), "every", 2);
  const auto samples = read(value);
  REQUIRE(samples.size() == 5);
  CHECK(samples[1].fields[0] == 3);  // (1·1 + 2·4)/3
  CHECK(samples[1].t0 == 0);
  CHECK(samples[2].t == 4 * second);
  CHECK(samples[2].fields[0] == 6);
  CHECK(samples[3].t == 10 * second);
  CHECK(samples[3].t0 == no_time);
  CHECK(samples[4].fields[0] == 4);  // (1·2 + 2·5)/3
  CHECK(samples[4].t0 == 10 * second);
}

TEST_CASE("csv: every so many epochs of several rows one", "[csv]") {
  const TemporaryFile file("t,k,a\n0,1,10\n0,2,20\n1,1,11\n2,1,12\n2,2,22\n2,3,32\n");
  const auto value = with_member(parameters(file.path(), {{"k", column("k")}, {"a", column("a")}}), "rows",
                                 object({{"key", "k"}, {"max_rows", 8}}));
  const auto bound = binnacle::testing::bind<CsvSource>({with_member(value, "every", 2)});
  CsvSource& source = *bound;
  Warnings warnings;
  source.open(warnings);
  const binnacle::testing::SourceCaller caller(source);
  auto memory = caller.fresh_memory(1);
  const auto first = caller.next(memory.data()), second_one = caller.next(memory.data());
  CHECK(first.sample.t == 0);
  CHECK(first.sample.rows == 2);
  CHECK(second_one.sample.t == 2 * second);
  CHECK(second_one.sample.rows == 3);
  CHECK(second_one.damage.empty());
  CHECK(caller.next(memory.data()).status == SourceStatus::end);
}

TEST_CASE("csv: columns are scaled and shifted", "[csv]") {
  const TemporaryFile file("t,w,a\n0,100,-999\n1,-100,5\n");
  auto turned = column("w", unit("rad/s", 0.01));
  turned["scale"] = -0.5;
  turned["offset"] = quantity(0.25, "rad/s");
  auto gaps = column("a", unit("m"));
  gaps["scale"] = 2;
  gaps["missing"] = Json::array({"-999"});
  const auto samples = read(parameters(file.path(), {{"w", turned}, {"a", gaps}}));
  REQUIRE(samples.size() == 2);
  CHECK(samples[0].fields[0] == Approx(-0.25));
  CHECK(samples[1].fields[0] == Approx(0.75));
  CHECK(std::isnan(samples[0].fields[1]));
  CHECK(samples[1].fields[1] == 10);
}

}  // namespace csv_calendar_test
