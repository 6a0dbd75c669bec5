// SPDX-License-Identifier: Apache-2.0
// The csv writer: read again by the csv source, and what it cannot write.
#include "csv/csv_writer.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "catch.hpp"
#include "csv_files.hpp"

namespace csv_writer_test {

namespace {

using namespace binnacle;
using namespace binnacle::csv_files;

/// A sample of the writer's input: every field NaN but those named.
std::vector<double> writable(const std::vector<std::pair<std::string, double>>& numbers) {
  const auto fields = csv::CsvWriter::spec().inputs.at(0).fields;
  std::vector<double> values(fields.size(), std::nan(""));
  for (const auto& [name, number] : numbers)
    for (std::size_t i = 0; i < fields.size(); ++i)
      if (fields[i].name == name) values[i] = number;
  return values;
}

void write(csv::CsvWriter& writer, Time t, const std::vector<double>& fields) {
  SampleView view{};
  view.t = t;
  view.fields = fields.data();
  writer.on(Input(0, true), view);
}

Json written(const std::string& path, Members columns) {
  return object({{"path", path}, {"columns", object(std::move(columns))}, {"time", "t"}, {"offset", 0.5}});
}

}  // namespace

TEST_CASE("csv_writer writes what the csv source reads again, bit by bit") {
  const TemporaryFile file("what was there before");
  const double degree = std::numbers::pi / 180;
  const auto bound = binnacle::testing::bind<csv::CsvWriter>(
      {written(file.path(), {{"fx", object({{"unit", unit("m/s^2", 9.80665)}, {"column", "a"}})},
                             {"wz", object({{"unit", unit("rad/s", degree)}, {"column", "w"}})}})});
  csv::CsvWriter& writer = *bound;
  writer.open();
  write(writer, -510'000'000, writable({{"fx", 9.80665}, {"wz", 0.3 * degree}}));
  write(writer, 0, writable({{"vn", 3}}));  // no number of the two: left out
  write(writer, 1'699'999'999'623'456'789, writable({{"wz", degree}}));
  std::string before;
  std::getline(std::ifstream(file.path()), before);
  CHECK(before == "what was there before");
  writer.close();

  std::ifstream stream(file.path());
  const std::string content{std::istreambuf_iterator<char>(stream), {}};
  CHECK(content == "t,a,w\n-0.01,1,0.3\n1700000000.123456789,,1\n");
  auto gap = column("a", unit("m/s^2", 9.80665));
  gap["missing"] = Json::array({""});
  const auto samples = read(parameters(file.path(), {{"wz", column("w", unit("rad/s", degree))}, {"fx", gap}}));
  REQUIRE(samples.size() == 2);
  CHECK(samples[0].t == -10'000'000);
  CHECK(samples[1].t == 1'700'000'000'123'456'789);
  CHECK(samples[0].fields[0] == 0.3 * degree);
  CHECK(samples[0].fields[1] == 9.80665);
  CHECK(std::isnan(samples[1].fields[1]));
}

TEST_CASE("csv_writer says what it cannot write") {
  const auto refusal = [](const Json& value) -> std::string {
    try {
      const auto bound = binnacle::testing::bind<csv::CsvWriter>({value});
      csv::CsvWriter& writer = *bound;
      writer.open();
      write(writer, 0, writable({{"vn", 1}}));
      writer.close();
    } catch (const ComponentError& error) {
      return error.pointer() + ": " + error.what();
    }
    return "written";
  };
  const TemporaryFile file("before");
  const auto m_per_s = object({{"unit", unit("m/s")}});
  CHECK(refusal(written(file.path(), {{"vn", m_per_s}})) == "written");
  CHECK(refusal(written(file.path(), {{"vx", m_per_s}})).rfind("/columns/vx: there is no field 'vx' to write", 0) == 0);
  CHECK(refusal(written(file.path(), {{"lat", m_per_s}})) ==
        "/columns/lat/unit: 'lat' is in rad, and this is a unit of m/s");
  CHECK(refusal(written(file.path(), {{"ve", m_per_s}})) == "/columns/ve: no sample has a 've'; nothing was written");
  CHECK(refusal(written(file.path() + "/of/none.csv", {{"vn", m_per_s}})).find("make it first") != std::string::npos);
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(file.path()).parent_path()))
    CHECK_FALSE(entry.path().string().starts_with(file.path() + ".part"));
}

}  // namespace csv_writer_test
