// SPDX-License-Identifier: Apache-2.0
// The csv source where several lines are one sample (`rows`), and where lines are of several kinds (`where`).
#include <cmath>
#include <string>
#include <vector>

#include "catch.hpp"
#include "csv_files.hpp"

namespace {

using namespace binnacle;
using namespace binnacle::csv_files;

constexpr Time second = nanoseconds_per_second;

ParameterValue whole(int value) {
  ParameterValue v;
  v.type = ParameterValue::Type::integer;
  v.integer = value;
  return v;
}

ParameterValue ranges(const std::string& path, int max_rows = 8) {
  return with(parameters(path, {{"sat", column("sat")}, {"rho", column("rho", unit("m"))}}), "rows",
              object({{"key", text("sat")}, {"max_rows", whole(max_rows)}}));
}

std::string fault_of_ranges(const std::string& content, int max_rows = 8) {
  const TemporaryFile file(content);
  return fault_of(ranges(file.path(), max_rows));
}

struct Epoch {
  Time t;
  std::vector<std::vector<double>> rows;
};

std::vector<Epoch> read_rows(const ParameterValue& value, Warnings* warnings = nullptr) {
  CsvSource source(bind(value));
  Warnings own;
  source.open(warnings ? *warnings : own);
  const binnacle::testing::SourceCaller caller(source);
  auto memory = caller.fresh_memory(1);
  std::vector<Epoch> epochs;
  for (;;) {
    const auto next = caller.next(memory.data());
    REQUIRE(next.damage.empty());
    if (next.status != SourceStatus::sample) return epochs;
    Epoch epoch{next.sample.t, {}};
    const std::size_t width = next.sample.row_fields.size() / static_cast<std::size_t>(next.sample.rows);
    for (int row = 0; row < next.sample.rows; ++row) {
      const auto begin =
          next.sample.row_fields.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(row) * width);
      epoch.rows.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(width));
    }
    epochs.push_back(epoch);
  }
}

}  // namespace

TEST_CASE("csv rows: consecutive lines with one label are one sample") {
  const TemporaryFile file("t,sat,rho\n1,5,100\n1,7,200\n2,7,201\n3,5,102\n3,9,300\n3,7,202\n");
  const auto epochs = read_rows(ranges(file.path()));
  REQUIRE(epochs.size() == 3);
  CHECK(epochs[0].t == second);
  CHECK(epochs[0].rows == std::vector<std::vector<double>>{{5, 100}, {7, 200}});
  CHECK(epochs[1].rows == std::vector<std::vector<double>>{{7, 201}});
  CHECK(epochs[2].rows == std::vector<std::vector<double>>{{5, 102}, {9, 300}, {7, 202}});
}

TEST_CASE("csv rows: faults, in exact words") {
  CHECK(fault_of_ranges("t,sat,rho\n1,5,100\n1,7,200\n1,5,101\n") ==
        "B062 line 4: column 'sat': 5 occurs twice at 1 s, first in line 2");
  CHECK(fault_of_ranges("t,sat,rho\n1,5,100\n1,7,200\n1,8,101\n", 2) ==
        "B062 line 4: more than 2 rows at 1 s: raise rows/max_rows if that many are right");
  CHECK(fault_of_ranges("t,sat,rho\n2,5,100\n1,7,200\n") == "B063 line 3: time goes back: 1 s after 2 s");
  CHECK(fault_of_ranges("t,sat,rho\n1,,100\n") == "B062 line 2: column 'sat' is empty");
  CHECK(fault_of_ranges("t,sat,rho\n1,5,100\n1,7\n") == "B062 line 3: 2 columns where the header has 3");
}

TEST_CASE("csv rows: what does not go together") {
  const TemporaryFile file("t,sat,rho\n1,5,100\n");
  const auto rate = with(parameters(file.path(), {{"sat", column("sat")}, {"rho", column("rho", unit("m"), "rate")}}),
                         "rows", object({{"key", text("sat")}, {"max_rows", whole(8)}}));
  CHECK(fault_of(rate) ==
        "/columns/rho/kind: with rows every field is a level: the rows of a sample are of one instant");
  const auto wrong = with(parameters(file.path(), {{"sat", column("sat")}}), "rows",
                          object({{"key", text("sta")}, {"max_rows", whole(8)}}));
  CHECK(fault_of(wrong) == "/rows/key: no field 'sta' among columns; did you mean 'sat'?");
}

TEST_CASE("csv where: lines of one kind are read, others are passed over, of whatever width") {
  const TemporaryFile file("t,kind,w\n1,imu,5\n1,gnss\n2,imu,6,and more\n2,imu,7\n");
  const auto one = [&](const char* is) {
    return with(parameters(file.path(), {{"w", column("w")}}), "where",
                object({{"column", text("kind")}, {"is", text(is)}}));
  };
  CHECK(fault_of(one("imu")) == "B062 line 4: 4 columns where the header has 3");
  CHECK(fault_of(one("odo")) == "B066 line 0: no line has 'odo' in column 'kind'");
  const TemporaryFile good("t,kind,w\n1,imu,5\n1,gnss\n2,imu,6\n");
  const auto samples = read(with(parameters(good.path(), {{"w", column("w")}}), "where",
                                 object({{"column", text("kind")}, {"is", text("imu")}})));
  REQUIRE(samples.size() == 2);
  CHECK(samples[1].fields == std::vector<double>{6});
}
