// SPDX-License-Identifier: Apache-2.0
// csv under damage, in each form of its labels and numbers: no crash, no time that goes back, no line lost without a count.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <regex>
#include <string>

#include "catch.hpp"
#include "csv/csv_source.hpp"
#include "mutator.hpp"
#include "reading.hpp"
#include "text/text_file.hpp"

namespace csv_mutation_test {

using namespace binnacle;
using namespace binnacle::test;
using nlohmann::json;

namespace {

/// Lines that are neither blank nor comment, as RFC 4180 and the README have it.
std::size_t lines_of(const std::string& path) {
  text_file::LineReader reader(path);
  std::size_t count = 0;
  for (std::string_view line; reader.next(line);) {
    const std::size_t start = line.find_first_not_of(" \t");
    count += start != line.npos && line[start] != '#';
  }
  return count;
}

/// The sum of "N rows skipped".
std::size_t skipped_in(const std::string& reports) {
  const std::regex pattern("([0-9]+) rows? skipped");
  std::size_t sum = 0;
  for (std::sregex_iterator at(reports.begin(), reports.end(), pattern), end; at != end; ++at)
    sum += std::stoul((*at)[1]);
  return sum;
}

void read_mutants(const std::string& name, const std::string& line, json parameters) {
  const Folder folder;
  const std::string file = folder.file("data.csv");
  parameters.update(json{{"path", file}, {"header", false}, {"delimiter", ";"}, {"invalid_rows", "skip"}});
  std::string good;
  for (char digit = '0'; digit < '9'; ++digit) {
    std::string row = line;
    for (char& c : row)
      if (c == '?') c = digit;
    good += row + "\n";
  }
  Mutator mutate(mutation_seed());
  std::size_t read = 0, refused = 0, samples = 0, skipped = 0;
  const int count = mutations();
  for (int i = 0; i < count; ++i) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << (i == 0 ? good : mutate(good));
    INFO(name << ", mutation " << i);
    try {
      const Recorded<csv::CsvSource> r(parameters);
      ++read;
      samples += r.samples.size();
      skipped += skipped_in(r.reports);
      REQUIRE(r.samples.size() + skipped_in(r.reports) == lines_of(file));
      if (i == 0) REQUIRE(r.samples.size() == 9);
      for (const Sample& sample : r.samples)
        for (const auto& [field, value] : sample.fields) REQUIRE((std::isfinite(value) || field == "missing"));
    } catch (const ComponentError&) {
      ++refused;
    }
  }
  if (std::getenv("BINNACLE_MUTATIONS"))
    std::printf("csv, %s: %d mutations, %zu read, %zu refused, %zu samples, %zu rows skipped\n", name.c_str(), count,
                read, refused, samples, skipped);
  CHECK(read + refused == static_cast<std::size_t>(count));
  CHECK(read > 0);
}

json column(const char* number, const char* unit) { return {{"column", number}, {"unit", unit}}; }

}  // namespace

TEST_CASE("mutations of csv with plain labels") {
  read_mutants("numbers", "1?.25;1.5;-2e3", {{"columns", {{"a", column("2", "deg")}, {"b", column("3", "m")}}}});
}

TEST_CASE("mutations of csv with times of ISO 8601 and local coordinates") {
  read_mutants("ISO 8601", "2026-11-23T12:00:0?.25+01:00;1.5;-2?;10.5;1;2;3",
               {{"time", {{"column", "1"}, {"format", "iso8601"}}},
                {"origin", {{"lat", 0.85}, {"lon", 0.15}, {"height", 115}}},
                {"local",
                 {{"north", column("2", "m")},
                  {"east", column("3", "km")},
                  {"up", column("4", "m")},
                  {"v_north", column("5", "m/s")},
                  {"v_east", column("6", "m/s")},
                  {"v_up", column("7", "m/s")}}}});
}

TEST_CASE("mutations of csv with dates, times and decimal commas") {
  json scaled = column("3", "deg/s");
  scaled.update(json{{"scale", -0.061}, {"offset", 0.5}, {"kind", "rate"}});
  read_mutants("dates", "23.11.2026;12:00:0?,25;-1,5",
               {{"time", {{"column", "2"}, {"date_column", "1"}, {"date_order", "dmy"}}},
                {"decimal", ","},
                {"columns", {{"w", scaled}}}});
}

TEST_CASE("mutations of csv with GPS weeks") {
  read_mutants("GPS weeks", "2446;12961?000;7.5",
               {{"time", {{"column", "2"}, {"week_column", "1"}, {"unit", "ms"}}},
                {"epoch", "1970-01-01"},
                {"columns", {{"a", column("3", "m")}}}});
}

}  // namespace csv_mutation_test
