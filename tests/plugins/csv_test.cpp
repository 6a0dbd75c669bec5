// SPDX-License-Identifier: Apache-2.0
// The csv source: what it reads, how it cuts intervals, and the exact words for every fault of the data.
#include "../recorded_data.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include "csv/cells.hpp"
#include "csv_files.hpp"
#include "spec_text.hpp"

namespace csv_test {

namespace {

using namespace binnacle;
using namespace binnacle::csv_files;

constexpr Time second = nanoseconds_per_second;

std::string many_rows(int count) {
  std::string content = "t,w,a\n";
  for (int i = 0; i < count; ++i) {
    char row[64];
    std::snprintf(row, sizeof row, "%.2f,%.6f,%.6f\n", 0.01 * i, std::sin(1.7 * i), std::cos(2.3 * i * i));
    content += row;
  }
  return content;
}

Time parsed_time(const char* cell, std::int64_t ns_per_unit = second) {
  Time t = -1;
  REQUIRE(csv::parse_time(cell, ns_per_unit, t) == csv::CellFault::none);
  return t;
}

}  // namespace

TEST_CASE("csv: decimal labels become nanoseconds, rounded once") {
  REQUIRE(parsed_time("0") == 0);
  REQUIRE(parsed_time("1.5") == 1'500'000'000);
  REQUIRE(parsed_time("+1.5") == 1'500'000'000);
  REQUIRE(parsed_time("-0.25") == -250'000'000);
  REQUIRE(parsed_time(".5") == 500'000'000);
  REQUIRE(parsed_time("7.") == 7 * second);
  REQUIRE(parsed_time("1278.803943507731") == 1'278'803'943'508);
  REQUIRE(parsed_time("0.0000000005") == 1);
  REQUIRE(parsed_time("-0.0000000005") == -1);
  REQUIRE(parsed_time("0.00000000049999999999999999999") == 0);
  REQUIRE(parsed_time("0.1000000000000000055511151231257827") == 100'000'000);
  REQUIRE(parsed_time("1.278803943507731000e+03") == 1'278'803'943'508);
  REQUIRE(parsed_time("1E-9") == 1);
  REQUIRE(parsed_time("5e2") == 500 * second);
  // GPS and Unix seconds keep the nanosecond, which a double loses from 2^23 s on.
  REQUIRE(parsed_time("1389648012.123456789") == 1'389'648'012'123'456'789);
  REQUIRE(parsed_time("00001389648012.1234567894999999999999999") == 1'389'648'012'123'456'789);
  REQUIRE(parsed_time("9223372036.854775807") == std::numeric_limits<Time>::max());
  REQUIRE(parsed_time("1500.25", 1'000'000) == 1'500'250'000);                  // ms
  REQUIRE(parsed_time("1389648012123456789", 1) == 1'389'648'012'123'456'789);  // ns
  REQUIRE(parsed_time("0.000277777777777777777777", 3600 * second) == second);  // h
  Time t = 0;
  REQUIRE(csv::parse_time("9223372036.854775808", second, t) == csv::CellFault::out_of_range);
  REQUIRE(csv::parse_time("1e300", second, t) == csv::CellFault::out_of_range);
  for (const char* bad : {"abc", "1,5", "1.2.3", "--1", "+-1", ".", "-", "1e", "1e+-3", "1 2", "nan", "0x10", "12:30"})
    REQUIRE(csv::parse_time(bad, second, t) == csv::CellFault::not_a_number);
  REQUIRE(csv::parse_time("", second, t) == csv::CellFault::empty);
}

TEST_CASE("csv: a label within half a nanosecond of its decimal, whatever its digits") {
  std::uint64_t state = 12345;
  for (int i = 0; i < 20000; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const std::int64_t ns = static_cast<std::int64_t>(state >> 4);  // up to 36 years
    char cell[64];
    std::snprintf(cell, sizeof cell, "%lld.%09lld%03d", static_cast<long long>(ns / second),
                  static_cast<long long>(ns % second), static_cast<int>(state % 1000));
    const Time expected = ns + (state % 1000 >= 500 ? 1 : 0);
    REQUIRE(parsed_time(cell) == expected);
  }
}

TEST_CASE("csv: numbers are the nearest double, short ones too") {
  std::uint64_t state = 99;
  for (int i = 0; i < 50000; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    char cell[64];
    const int decimals = static_cast<int>(state >> 60);
    const double drawn = static_cast<double>(static_cast<std::int64_t>(state)) * std::pow(10.0, -10.0 - i % 9);
    std::snprintf(cell, sizeof cell, i % 2 ? "%.*f" : "%.*g", decimals, drawn);
    double value = 0;
    REQUIRE(csv::parse_number(cell, value) == csv::CellFault::none);
    REQUIRE(value == std::strtod(cell, nullptr));
  }
  double value = 1;
  REQUIRE(csv::parse_number("-0", value) == csv::CellFault::none);
  REQUIRE(std::signbit(value));
  for (const char* bad : {"-", ".", "1.2.3", "1-2", "1,2", "--1", "+-1", "+", "0x1p3", "1e", "12 3"}) {
    INFO(bad);
    REQUIRE(csv::parse_number(bad, value) == csv::CellFault::not_a_number);
  }
}

TEST_CASE("csv: seconds are printed exactly") {
  REQUIRE(csv::time_text(0) == "0 s");
  REQUIRE(csv::time_text(12 * second + second / 2) == "12.5 s");
  REQUIRE(csv::time_text(-250'000'001) == "-0.250000001 s");
  REQUIRE(csv::time_text(std::numeric_limits<Time>::min()) == "-9223372036.854775808 s");
}

TEST_CASE("csv: fields arrive in SI, in the order of the config, with the intervals of their labels") {
  const TemporaryFile file("t_s,gx_dps,unused,h\n0.5,90,x,1\n0.6,-180,y,2\n0.8,0,,3\n");
  const auto value = parameters(file.path(), {{"height", column("h", unit("m", 1))},
                                              {"wx", column("gx_dps", unit("rad/s", std::numbers::pi / 180), "rate")}});
  const auto bound = binnacle::testing::bind<CsvSource>({value});
  CsvSource& source = *bound;
  REQUIRE(source.declaration().channels.size() == 1);
  const auto& channel = source.declaration().channels[0];
  REQUIRE(channel.name.empty());
  REQUIRE(channel.fields.size() == 2);
  REQUIRE(channel.fields[0].name == "height");
  REQUIRE(channel.fields[0].unit == "m");
  REQUIRE(channel.fields[0].kind == FieldKind::level);
  REQUIRE(channel.fields[1].name == "wx");
  REQUIRE(channel.fields[1].unit == "rad/s");
  REQUIRE(channel.fields[1].kind == FieldKind::rate);
  REQUIRE(channel.covariance.empty());

  const auto samples = read(value);
  REQUIRE(samples.size() == 3);
  REQUIRE(samples[0].t == second / 2);
  REQUIRE(samples[0].t0 == no_time);
  REQUIRE(samples[1].t0 == samples[0].t);
  REQUIRE(samples[2].t0 == samples[1].t);
  REQUIRE(samples[2].t == 800'000'000);
  REQUIRE(std::abs(samples[0].fields[1] - std::numbers::pi / 2) < 1e-15);
  REQUIRE(std::abs(samples[1].fields[1] + std::numbers::pi) < 1e-15);
  REQUIRE(samples[1].fields[0] == 2);
}

TEST_CASE("csv: levels are instants, a fixed interval is kept, increments have intervals") {
  const TemporaryFile file("t,w,a\n1,1,1\n2,2,2\n");
  const auto levels = read(parameters(file.path(), {{"a", column("a", unit("m"))}}));
  REQUIRE(levels[1].t0 == no_time);
  const auto fixed = read(with_member(rate_and_level(file.path()), "interval", 0.25));
  REQUIRE(fixed[0].t0 == second * 3 / 4);
  REQUIRE(fixed[1].t0 == second * 7 / 4);
  const auto increments = read(parameters(file.path(), {{"w", column("w", unit("rad"), "increment")}}));
  REQUIRE(increments[1].t0 == second);
}

TEST_CASE("csv: a column is taken by the field's name where none is given") {
  const TemporaryFile file("t,w,a\n1,5,6\n");
  auto field = object({{"unit", unit("m")}, {"kind", "level"}});
  REQUIRE(read(parameters(file.path(), {{"a", field}}))[0].fields[0] == 6);
}

TEST_CASE("csv: line ends, byte order mark, quotes, blanks, comments, empty lines, no newline at the end") {
  for (const char* content :
       {"t,w,a\n1,2,3\n2,4,5\n", "t,w,a\r\n1,2,3\r\n2,4,5\r\n", "\xEF\xBB\xBFt,w,a\n1,2,3\n2,4,5\n",
        "\"t\",\"w\",\"a\"\n\"1\",\"2\",3\n2,\"4\",5\n", "  t , w,\ta \n 1, 2 ,3\t\n2, +4,5.0e0\n",
        "# made by hand\nt,w,a\n\n1,2,3\n  # half time\n2,4,5\n\n", "t,w,a\n1,2,3\n2,4,5",
        "t,w,a\r\n1,2,3\r\n2,4,5\r"}) {
    INFO(content);
    const auto samples = read_text(content);
    REQUIRE(samples.size() == 2);
    REQUIRE(samples[1].t == 2 * second);
    REQUIRE(samples[0].fields == std::vector<double>{2, 3});
    REQUIRE(samples[1].fields == std::vector<double>{4, 5});
  }
}

TEST_CASE("csv: quoted header names may hold the delimiter") {
  const TemporaryFile file("\"time, s\",\"w, deg/s\"\n1,2\n");
  auto value = parameters(file.path(), {{"w", column("w, deg/s")}});
  value = with_member(value, "time", object({{"column", "time, s"}, {"unit", unit("s")}}));
  REQUIRE(read(value)[0].fields[0] == 2);
}

TEST_CASE("csv: other delimiters") {
  for (const auto& [delimiter, content] : std::vector<std::pair<std::string, std::string>>{
           {";", "t;w;a\n1;2;3\n"}, {"\t", "t\tw\ta\n1\t2\t3\n"}, {" ", "  t  w a\n 1   2\t3 \n"}}) {
    const TemporaryFile file(content);
    const auto samples = read(with_member(rate_and_level(file.path()), "delimiter", delimiter));
    REQUIRE(samples.size() == 1);
    REQUIRE(samples[0].fields == std::vector<double>{2, 3});
  }
}

TEST_CASE("csv: without header columns are numbers") {
  const TemporaryFile file("1,2,3\n2,4,5\n");
  auto value = with_member(parameters(file.path(), {{"w", column("3")}}), "header", false);
  const auto samples = read(value);
  REQUIRE(samples.size() == 2);
  REQUIRE(samples[1].fields[0] == 5);
  REQUIRE(samples[1].t == 2 * second);
  value = with_member(parameters(file.path(), {{"w", column("4")}}), "header", false);
  REQUIRE(fault_of(value) == "/columns/w/column: '4' is not a column: without header, columns are numbers from 1 to 3");
}

TEST_CASE("csv: unit and offset of the labels") {
  const TemporaryFile file("w,a,ms\n1,2,1500.5\n");
  const auto value = with_member(rate_and_level(file.path()), "time",
                                 object({{"column", "ms"}, {"unit", unit("s", 1e-3)}, {"offset", -0.5}}));
  REQUIRE(read(value)[0].t == 1'000'500'000);
  REQUIRE(fault_of(with_member(value, "time", object({{"unit", unit("m")}}))) ==
          "/time/unit: labels need a unit of time of whole nanoseconds, like \"s\", \"ms\", \"us\", \"ns\" or \"h\"");
}

TEST_CASE("csv: only the window is read, after the offset, and its first sample starts the clock") {
  const TemporaryFile file("t,w,a\n1,nan,1\n2,2,2\n3,3,3\n4,4,4\n5,x,5,5\n");
  auto value = with_member(rate_and_level(file.path()), "time", object({{"unit", unit("s")}, {"offset", 10}}));
  value = with_member(value, "window", Json::array({12, 13.5}));
  const auto samples = read(value);
  REQUIRE(samples.size() == 2);
  REQUIRE(samples[0].t == 12 * second);
  REQUIRE(samples[0].t0 == no_time);
  REQUIRE(samples[1].t0 == 12 * second);
  REQUIRE(fault_of(with_member(value, "window", Json::array({13, 12}))) ==
          "/window: a window is [from, to] with from < to");
  REQUIRE(fault_of(with_member(value, "window", Json::array({13}))) ==
          "/window: a window is [from, to] with from < to");
  REQUIRE(fault_of(with_member(value, "window", Json::array({1, 2}))) ==
          "B066 line 0: no rows in the window; times run from 11 s to 11 s and on");
}

TEST_CASE("csv: gzip, in several members too, reads as the plain file does") {
  const std::string content = many_rows(30000);
  const TemporaryFile plain(content);
  const TemporaryFile packed(gzipped(content), "data.csv.gz");
  const TemporaryFile members(gzipped(content.substr(0, 1001)) + gzipped(content.substr(1001)) + std::string(7, '\0'),
                              "data.csv.gz");
  const TemporaryFile unnamed(gzipped(content), "data.csv");
  const auto expected = read(rate_and_level(plain.path()));
  REQUIRE(expected.size() == 30000);
  for (const auto* file : {&packed, &members, &unnamed}) {
    const auto samples = read(rate_and_level(file->path()));
    REQUIRE(samples.size() == expected.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      REQUIRE(samples[i].t == expected[i].t);
      REQUIRE(samples[i].fields == expected[i].fields);
    }
  }
}

TEST_CASE("csv: damaged gzip: the message states where, and how much was read") {
  const std::string packed = gzipped(many_rows(30000));
  {
    const std::size_t half = packed.size() / 2;
    const TemporaryFile file(packed.substr(0, half), "data.csv.gz");
    const std::string fault = fault_of(rate_and_level(file.path()));
    const std::string start = "B061 line 0: gzip data are cut off at byte " + std::to_string(half) + "; ";
    REQUIRE(fault.substr(0, start.size()) == start);
    const int rows = std::stoi(fault.substr(start.size()));
    REQUIRE(rows > 10000);
    REQUIRE(rows < 20000);
    REQUIRE(fault.substr(fault.find("; ") + 2) == std::to_string(rows) + " rows could be read before");
  }
  {
    const TemporaryFile file(packed.substr(0, packed.size() - 1), "data.csv.gz");
    REQUIRE(fault_of(rate_and_level(file.path())) == "B061 line 0: gzip data are cut off at byte " +
                                                         std::to_string(packed.size() - 1) +
                                                         "; 30000 rows could be read before");
  }
  {
    std::string wrong = packed;
    wrong[wrong.size() - 6] = static_cast<char>(wrong[wrong.size() - 6] ^ 1);  // in the CRC
    const TemporaryFile file(wrong, "data.csv.gz");
    const std::string fault = fault_of(rate_and_level(file.path()));
    REQUIRE(fault == "B061 line 0: gzip data are corrupt at byte " + std::to_string(wrong.size() - 4) +
                         " (incorrect data check); 30000 rows could be read before");
  }
  {
    const TemporaryFile file(packed + "surplus", "data.csv.gz");
    REQUIRE(fault_of(rate_and_level(file.path())) == "B061 line 0: gzip data are followed by other bytes at byte " +
                                                         std::to_string(packed.size()) +
                                                         "; 30000 rows could be read before");
  }
  {
    const TemporaryFile file("t,w,a\n1,2,3\n", "data.csv.gz");
    REQUIRE(fault_of(rate_and_level(file.path())) == "B061 line 0: is named .gz but is not a gzip file");
  }
}

TEST_CASE("csv: files that are not there or empty") {
  const TemporaryFile file("");
  REQUIRE(fault_of(rate_and_level(file.path() + "x")) == "B060 line 0: cannot be opened: No such file or directory");
  REQUIRE(fault_of(rate_and_level(std::filesystem::path(file.path()).parent_path().string())) ==
          "B060 line 0: cannot be read: Is a directory");
  REQUIRE(fault_of(rate_and_level(file.path())) == "B066 line 0: the file is empty");
  REQUIRE(fault_of_text("# nothing\n\n") == "B066 line 0: the file is empty");
  REQUIRE(fault_of_text("t,w,a\n") == "B066 line 0: no rows after the header");
  try {
    read(rate_and_level(file.path()));
  } catch (const ComponentError& error) {
    REQUIRE(error.file() == file.path());
  }
}

TEST_CASE("csv: faults of rows, in exact words") {
  REQUIRE(fault_of_text("t,w,a\n1,2,3\n\n2,4\n") == "B062 line 4: 2 columns where the header has 3");
  REQUIRE(fault_of_text("t,w,a\n1,2,3,4\n") == "B062 line 2: 4 columns where the header has 3");
  REQUIRE(fault_of_text("t,w,a\n1,2,3\n7\n") == "B062 line 3: 1 column where the header has 3");
  REQUIRE(fault_of_text("t,w,a\n1,abc,3\n") == "B062 line 2: column 'w': 'abc' is not a number");
  REQUIRE(fault_of_text("t,w,a\n1,2,1.5x\n") == "B062 line 2: column 'a': '1.5x' is not a number");
  REQUIRE(fault_of_text("t,w,a\n1,,3\n") == "B062 line 2: column 'w' is empty");
  REQUIRE(fault_of_text("t,w,a\n1,1e999,3\n") == "B062 line 2: column 'w': '1e999' is beyond the range of a double");
  REQUIRE(fault_of_text("t,w,a\n1,2,3\n2,nan,3\n") == "B064 line 3: column 'w' is nan");
  REQUIRE(fault_of_text("t,w,a\n1,2,-inf\n") == "B064 line 2: column 'a' is -inf");
  REQUIRE(fault_of_text("t,w,a\nnoon,2,3\n") == "B062 line 2: time column 't': 'noon' is not a number");
  REQUIRE(fault_of_text("t,w,a\n,2,3\n") == "B062 line 2: time column 't' is empty");
  REQUIRE(fault_of_text("t,w,a\n1e11,2,3\n") == "B062 line 2: time column 't': '1e11' is beyond +-146 years");
  REQUIRE(fault_of_text("t,w,a\n1,2,3\n2.5,2,3\n2.4,2,3\n") ==
          "B063 line 4: time does not increase: 2.4 s after 2.5 s");
  REQUIRE(fault_of_text("t,w,a\n1,2,3\n1.0,2,3\n") == "B063 line 3: time does not increase: 1 s after 1 s");
  const TemporaryFile file("1,2\n2\n");
  const auto value = with_member(parameters(file.path(), {{"w", column("2")}}), "header", false);
  REQUIRE(fault_of(value) == "B062 line 2: 1 column where the first row has 2");
}

TEST_CASE("csv: a number too small for a double is zero") {
  const auto samples = read_text("t,w,a\n1,1e-999,-1e-400\n");
  REQUIRE(samples[0].fields == std::vector<double>{0, 0});
}

TEST_CASE("csv: faults of the header point at the config and suggest a column") {
  const TemporaryFile file("t_s,gx_radps,gx_radps,ax_mps2\n1,2,3,4\n");
  const auto fault = [&](const std::string& name) { return fault_of(parameters(file.path(), {{"wx", column(name)}})); };
  REQUIRE(fault("ax_mps") ==
          "/columns/wx/column: no column 'ax_mps'; did you mean 'ax_mps2'? the header has: t_s, gx_radps, gx_radps, "
          "ax_mps2");
  REQUIRE(fault("pressure") ==
          "/columns/wx/column: no column 'pressure'; the header has: t_s, gx_radps, gx_radps, ax_mps2");
  REQUIRE(fault("gx_radps") == "/columns/wx/column: column 'gx_radps' appears in the header twice");
  REQUIRE(fault_of(with_member(parameters(file.path(), {{"a/b", column("x")}}), "time", object({{"column", "ts"}}))) ==
          "/time/column: no column 'ts'; did you mean 't_s'? the header has: t_s, gx_radps, gx_radps, ax_mps2");
  REQUIRE(fault_of(parameters(file.path(), {{"a/b", column("x")}})).substr(0, 23) == "/columns/a~1b/column: n");
  const TemporaryFile numbers("1,2,3\n2,4,5\n");
  REQUIRE(fault_of(rate_and_level(numbers.path())) ==
          "/columns/w/column: no column 'w': the first line holds numbers only; for a file without header line set "
          "\"header\": false");
  const TemporaryFile semicolons("t;w;a\n1;2;3\n");
  REQUIRE(fault_of(rate_and_level(semicolons.path())) ==
          "/columns/w/column: no column 'w'; the header is a single cell: is the delimiter \";\"?");
}

TEST_CASE("csv: parameters that do not go together") {
  const TemporaryFile file("t,w,a\n1,2,3\n");
  REQUIRE(fault_of(with_member(parameters(file.path(), {{"a", column("a")}}), "interval", 1)) ==
          "/interval: an interval needs a column of kind \"rate\" or \"increment\"");
  REQUIRE(fault_of(with_member(rate_and_level(file.path()), "delimiter", "ab")) ==
          "/delimiter: a delimiter is one character, like \",\", \";\", \"\\t\" or \" \" for any run of blanks");
  REQUIRE(fault_of(parameters(file.path(), {})) == "/columns: no field is named");
}

TEST_CASE("csv: what stands for no data becomes NaN, in any spelling") {
  const TemporaryFile file("t,w,a\n1,-9999.0,\n2,n/a,3\n3,NaN,4\n4,5,-9999\n");
  auto field = column("w");
  field = with_member(field, "missing", Json::array({"-9999", "n/a", "nan"}));
  const auto optional = with_member(column("a"), "missing", Json::array({""}));
  const auto samples = read(parameters(file.path(), {{"w", field}, {"a", optional}}));
  REQUIRE(samples.size() == 4);
  for (int i = 0; i < 3; ++i) REQUIRE(std::isnan(samples[static_cast<std::size_t>(i)].fields[0]));
  REQUIRE(samples[3].fields[0] == 5);
  REQUIRE(std::isnan(samples[0].fields[1]));
  REQUIRE(samples[1].fields[1] == 3);
  REQUIRE(samples[3].fields[1] == -9999);
}

TEST_CASE("csv: a label far ahead takes no earlier row with it, nor a sample back in time") {
  const auto times_of = [](const char* rows) {
    const TemporaryFile file(rows);
    Warnings warnings;
    std::vector<Time> times;
    for (const auto& sample : read(with_member(rate_and_level(file.path()), "invalid_rows", "skip"), &warnings))
      times.push_back(sample.t);
    return times;
  };
  // Behind the jump two rows are unusable: what was before it is not known any more when the label goes back for good.
  CHECK(times_of("t,w,a\n0,0,0\n1,0,0\n2,0,0\n100,0,0\n3,x,0\n4,x,0\n0.5,0,0\n0.7,0,0\n5,0,0\n") ==
        std::vector<Time>{0, nanoseconds(1.0), nanoseconds(2.0), nanoseconds(5.0)});
  // Two samples are taken back: the one before them is still the earliest that there may be.
  CHECK(times_of("t,w,a\n0,0,0\n3,0,0\n24,0,0\n12,x,0\n24,x,0\n0.2,x,0\n2,x,0\n-4,0,0\n") == std::vector<Time>{0});
}

TEST_CASE("csv: bad rows are skipped only on request, and counted") {
  const TemporaryFile file("t,w,a\n1,1,1\n2,nan,2\n3,3,3\n4,4\n5,inf,5\n5,5,5\n4.5,1,1\n6,x,6\n7,7,7\n");
  Warnings warnings;
  const auto samples = read(with_member(rate_and_level(file.path()), "invalid_rows", "skip"), &warnings);
  REQUIRE(samples.size() == 4);
  REQUIRE(samples[1].t == 3 * second);
  REQUIRE(samples[1].t0 == second);  // stretched over the hole
  REQUIRE(samples[2].t == 5 * second);
  REQUIRE(samples[3].t == 7 * second);
  REQUIRE(warnings.all.size() == 3);
  REQUIRE(warnings.all[0].code == "B062");
  REQUIRE(warnings.all[0].line == 5);
  REQUIRE(warnings.all[0].file == file.path());
  REQUIRE(warnings.all[0].message == "2 rows skipped, the first: 2 columns where the header has 3");
  REQUIRE(warnings.all[1].code == "B063");
  REQUIRE(warnings.all[1].line == 8);
  REQUIRE(warnings.all[1].message == "1 row skipped: time does not increase: 4.5 s after 5 s");
  REQUIRE(warnings.all[2].code == "B064");
  REQUIRE(warnings.all[2].line == 3);
  REQUIRE(warnings.all[2].message == "2 rows skipped, the first: column 'w' is nan");
  const TemporaryFile useless("t,w,a\n1,x,1\n2,y,2\n");
  REQUIRE(fault_of(with_member(rate_and_level(useless.path()), "invalid_rows", "skip")) ==
          "B066 line 0: no rows remain: all rows in the window were skipped");
}

TEST_CASE("csv: gaps are reported once and restart the clock") {
  const TemporaryFile one("t,w,a\n1,1,1\n1.1,1,1\n3.4,1,1\n3.5,1,1\n");
  Warnings warnings;
  auto samples = read(with_member(rate_and_level(one.path()), "max_gap", 0.5), &warnings);
  REQUIRE(samples[1].t0 == second);
  REQUIRE(samples[2].t0 == no_time);
  REQUIRE(samples[3].t0 == samples[2].t);
  REQUIRE(warnings.all.size() == 1);
  REQUIRE(warnings.all[0].code == "B065");
  REQUIRE(warnings.all[0].line == 4);
  REQUIRE(warnings.all[0].message == "1 gap longer than 0.5 s: 2.3 s from 1.1 s to 3.4 s");

  const TemporaryFile three("t,w,a\n1,1,1\n2,1,1\n2.1,1,1\n5,1,1\n6,1,1\n");
  warnings.all.clear();
  samples = read(with_member(with_member(rate_and_level(three.path()), "max_gap", 0.5), "interval", 0.1), &warnings);
  REQUIRE(samples[0].t0 == 900'000'000);
  REQUIRE(samples[1].t0 == no_time);
  REQUIRE(samples[2].t0 == 2 * second);
  REQUIRE(warnings.all.size() == 1);
  REQUIRE(warnings.all[0].line == 3);
  REQUIRE(warnings.all[0].message ==
          "3 gaps longer than 0.5 s, 4.9 s in all; the first from 1 s to 2 s; the longest, 2.9 s, ends at line 5");

  // A gap as long as max_gap is none.
  warnings.all.clear();
  read(with_member(rate_and_level(one.path()), "max_gap", 2.3), &warnings);
  REQUIRE(warnings.all.empty());
}

TEST_CASE("csv: without max_gap, ten median steps of rates are a gap, levels have none") {
  std::string content = "t,w,a\n";
  for (int i = 0; i < 100; ++i) content += std::to_string(i + (i >= 50 ? 20 : 0)) + ",1,1\n";
  const TemporaryFile file(content);
  Warnings warnings;
  const auto samples = read(rate_and_level(file.path()), &warnings);
  REQUIRE(samples[50].t0 == no_time);
  REQUIRE(warnings.all.size() == 1);
  REQUIRE(warnings.all[0].message == "1 gap longer than 10 s: 21 s from 49 s to 70 s");
  warnings.all.clear();
  read(parameters(file.path(), {{"a", column("a")}}), &warnings);
  REQUIRE(warnings.all.empty());
}

TEST_CASE("csv: the cursor is all of its memory") {
  const TemporaryFile file("t,w,a\n1,1,1\n2,2,2\n3,3,3\n");
  const auto bound = binnacle::testing::bind<CsvSource>({rate_and_level(file.path())});
  CsvSource& source = *bound;
  Warnings warnings;
  source.open(warnings);
  const binnacle::testing::SourceCaller caller(source);
  auto memory = caller.fresh_memory(1);
  REQUIRE(caller.next(memory.data()).status == SourceStatus::sample);
  const auto snapshot = memory;
  REQUIRE(caller.next(memory.data()).status == SourceStatus::sample);
  REQUIRE(caller.next(memory.data()).status == SourceStatus::sample);
  REQUIRE(caller.next(memory.data()).status == SourceStatus::end);
  REQUIRE(caller.next(memory.data()).status == SourceStatus::end);
  memory = snapshot;
  const auto next = caller.next(memory.data());
  REQUIRE(next.status == SourceStatus::sample);
  REQUIRE(next.sample.t == 2 * second);
  REQUIRE(next.sample.t0 == second);
}

TEST_CASE("csv: the spec is complete") {
  const auto spec = CsvSource::spec();
  REQUIRE(spec.type == "csv");
  REQUIRE(!spec.summary.empty());
  REQUIRE(!spec.example.empty());
  REQUIRE(binnacle::test::undocumented(spec.parameters) == "");
}

TEST_CASE("csv: a recorded drive of 127 000 rows is read in a fraction of a second", "[data]") {
  const auto drives = binnacle::test::recorded_data("drives");
  if (!drives) return;
  const std::string path = (*drives / "mixed-road-long-drive-large-mount-001" / "imu.csv.gz").string();
  const auto rate = [](const char* name, const char* si) { return column(name, unit(si), "rate"); };
  const auto value = parameters(path, {{"wx", rate("gx_radps", "rad/s")},
                                       {"wy", rate("gy_radps", "rad/s")},
                                       {"wz", rate("gz_radps", "rad/s")},
                                       {"fx", rate("ax_mps2", "m/s^2")},
                                       {"fy", rate("ay_mps2", "m/s^2")},
                                       {"fz", rate("az_mps2", "m/s^2")}});
  Warnings warnings;
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu_begin = std::clock();
  const auto bound = binnacle::testing::bind<CsvSource>({value});
  CsvSource& source = *bound;
  source.open(warnings);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  const double cpu = static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
  std::cout << "csv: imu.csv.gz of the long drive read in " << elapsed.count() << " s, " << cpu
            << " s of processor: " << 15.314359 / cpu << " MB of text per second\n";
  REQUIRE(warnings.all.empty());
  const binnacle::testing::SourceCaller caller(source);
  auto memory = caller.fresh_memory(0);
  int count = 0;
  binnacle::testing::Emitted last;
  for (auto next = caller.next(memory.data()); next.status == SourceStatus::sample; next = caller.next(memory.data())) {
    last = next.sample;
    ++count;
  }
  REQUIRE(count == 127198);
  REQUIRE(last.t == 1'278'803'943'508);
  REQUIRE(last.fields[0] == -0.0021347899298075172);
  REQUIRE(last.fields[5] == -4.8505859375);
}

}  // namespace csv_test
