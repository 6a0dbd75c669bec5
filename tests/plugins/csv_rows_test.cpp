// SPDX-License-Identifier: Apache-2.0
// The csv source where several lines are one sample, and where a file has lines of several kinds.
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "binnacle/testing.hpp"
#include "catch.hpp"
#include "csv_files.hpp"

namespace csv_rows_test {

namespace {

using namespace binnacle;
using namespace binnacle::csv_files;

Json by_rows(const std::string& path, int most = 4) {
  return with_member(parameters(path, {{"prn", column("prn")}, {"rho", column("rho", unit("m", 1000))}}), "rows",
                     object({{"key", "prn"}, {"max_rows", most}}));
}

struct Epoch {
  Time t;
  std::vector<double> rows;  // prn, rho
};

std::vector<Epoch> epochs(const Json& value, Warnings* warnings = nullptr) {
  const auto bound = binnacle::testing::bind<CsvSource>({value});
  CsvSource& source = *bound;
  Warnings own;
  source.open(warnings ? *warnings : own);
  const binnacle::testing::SourceCaller caller(source);
  auto memory = caller.fresh_memory(1);
  std::vector<Epoch> list;
  for (;;) {
    const auto next = caller.next(memory.data());
    REQUIRE(next.damage.empty());
    if (next.status != SourceStatus::sample) return list;
    const auto width = source.declaration().channels[0].fields.size();
    list.push_back({next.sample.t,
                    {next.sample.row_fields.begin(),
                     next.sample.row_fields.begin() + static_cast<std::ptrdiff_t>(width) * next.sample.rows}});
  }
}

std::vector<Epoch> epochs_of(const std::string& content) {
  const TemporaryFile file(content);
  return epochs(by_rows(file.path()));
}

std::string fault_of_rows(const std::string& content, int most = 4) {
  const TemporaryFile file(content);
  return fault_of(by_rows(file.path(), most));
}

}  // namespace

TEST_CASE("csv rows: consecutive lines with one label are one sample") {
  const auto list = epochs_of("t,prn,rho\n1,5,1\n1,7,2\n2.5,7,3\n3,5,4\n3,7,5\n3,9,6\n");
  REQUIRE(list.size() == 3);
  CHECK(list[0].t == nanoseconds(1));
  CHECK(list[0].rows == std::vector<double>{5, 1000, 7, 2000});
  CHECK(list[1].rows == std::vector<double>{7, 3000});
  CHECK(list[2].rows == std::vector<double>{5, 4000, 7, 5000, 9, 6000});
  // Labels are the same if they are the same nanosecond, however they are written.
  CHECK(epochs_of("t,prn,rho\n1.5,5,1\n1.50,7,2\n15e-1,8,2\n").size() == 1);
  CHECK(epochs_of("t,prn,rho\n1.5,5,1\n1.500000001,7,2\n").size() == 2);
}

TEST_CASE("csv rows: the channel declares its rows") {
  const TemporaryFile file("t,prn,rho\n1,5,1\n");
  const auto bound = binnacle::testing::bind<CsvSource>({by_rows(file.path(), 7)});
  CsvSource& source = *bound;
  const ChannelDeclaration& channel = source.declaration().channels[0];
  CHECK(channel.max_rows == 7);
  for (const FieldSpec& field : channel.fields) CHECK(field.is_per_row);
}

TEST_CASE("csv rows: what is wrong with a sample is named by line and column") {
  CHECK(fault_of_rows("t,prn,rho\n1,5,1\n1,7,2\n1,5,3\n") ==
        "B062 line 4: column 'prn': 5 occurs twice at 1 s, first in line 2");
  CHECK(fault_of_rows("t,prn,rho\n1,5,1\n1,7,2\n1,8,3\n", 2) ==
        "B062 line 4: more than 2 rows at 1 s: raise rows/max_rows if that many are right");
  CHECK(fault_of_rows("t,prn,rho\n1,5,1\n2,7,2\n1,8,3\n") == "B063 line 4: time goes back: 1 s after 2 s");
  CHECK(fault_of_rows("t,prn,rho\n1,5,1\n1,,2\n") == "B062 line 3: column 'prn' is empty");
  CHECK(fault_of_rows("t,prn,rho\n1,5,1\n1,nan,2\n") == "B064 line 3: column 'prn' is nan");
  CHECK(fault_of_rows("t,prn,rho\n1,5,1\n1,7\n") == "B062 line 3: 2 columns where the header has 3");
  CHECK(fault_of_rows("t,prn,rho\n1,5,1\n1,7,x\n") == "B062 line 3: column 'rho': 'x' is not a number");
  CHECK(fault_of_rows("t,prn,rho\n") == "B066 line 0: no rows after the header");
  // A key that the config lets be missing.
  const TemporaryFile file("t,prn,rho\n1,5,1\n1,-,2\n");
  auto value = by_rows(file.path());
  value =
      with_member(value, "columns",
                  object({{"prn", with_member(column("prn"), "missing", Json::array({"-"}))}, {"rho", column("rho")}}));
  CHECK(fault_of(value) == "B062 line 3: column 'prn', the key of the rows, is missing");
}

TEST_CASE("csv rows: bad lines are left out and counted where the config says so") {
  const TemporaryFile file("t,prn,rho\n1,5,1\n1,5,2\n1,7,x\n1,9,4\n0.5,3,3\n2,x,1\n2,5,1\n");
  Warnings warnings;
  const auto list = epochs(with_member(by_rows(file.path()), "invalid_rows", "skip"), &warnings);
  REQUIRE(list.size() == 2);
  CHECK(list[0].rows == std::vector<double>{5, 1000, 9, 4000});
  CHECK(list[1].rows == std::vector<double>{5, 1000});
  REQUIRE(warnings.all.size() == 2);
  CHECK(warnings.all[0].message == "3 rows skipped, the first: column 'prn': 5 occurs twice at 1 s, first in line 2");
  CHECK(warnings.all[1].message == "1 row skipped: time goes back: 0.5 s after 1 s");
}

TEST_CASE("csv rows: a window keeps whole samples") {
  const TemporaryFile file("t,prn,rho\n1,5,1\n1,7,2\n2,5,3\n2,7,4\n3,5,5\n");
  const auto list = epochs(with_member(by_rows(file.path()), "window", Json::array({2, 2.5})));
  REQUIRE(list.size() == 1);
  CHECK(list[0].rows == std::vector<double>{5, 3000, 7, 4000});
}

TEST_CASE("csv rows: what the config gets wrong is said at its place") {
  const TemporaryFile file("t,prn,rho\n1,5,1\n");
  const auto key = [&](const char* name) {
    return fault_of(with_member(by_rows(file.path()), "rows", object({{"key", name}, {"max_rows", 4}})));
  };
  CHECK(key("prm") == "/rows/key: no field 'prm' among columns; did you mean 'prn'?");
  CHECK(key("xyz") == "/rows/key: no field 'xyz' among columns; they are: prn, rho");
  auto rate = by_rows(file.path());
  rate = with_member(rate, "columns", object({{"prn", column("prn")}, {"rho", column("rho", unit("m"), "rate")}}));
  CHECK(fault_of(rate).find("/columns/rho/kind: with rows every field is a level") == 0);
}

TEST_CASE("csv where: lines of one kind out of several") {
  const TemporaryFile file("range 1 5 1\nspeed 1 3\nrange 1 7 2\nspeed 2 4\nrange 2 5 3  \n");
  auto value = parameters(file.path(), {{"prn", column("3")}, {"rho", column("4", unit("m"))}});
  value = with_member(with_member(with_member(value, "header", false), "delimiter", " "), "time",
                      object({{"column", "2"}, {"unit", unit("s")}, {"offset", 0}}));
  const auto where = [&](const Json& in, const char* column_name, const char* is) {
    return with_member(in, "where", object({{"column", column_name}, {"is", is}}));
  };
  const auto rows = object({{"key", "prn"}, {"max_rows", 4}});
  const auto list = epochs(with_member(where(value, "1", "range"), "rows", rows));
  REQUIRE(list.size() == 2);
  CHECK(list[0].rows == std::vector<double>{5, 1, 7, 2});
  // The same file, the other kind: a line is a sample, and its width its own.
  auto speeds = with_member(value, "columns", object({{"v", column("3")}}));
  const auto samples = read(where(speeds, "1", "speed"));
  REQUIRE(samples.size() == 2);
  CHECK(samples[1].fields == std::vector<double>{4});
  CHECK(fault_of(where(value, "1", "rnage")) == "B066 line 0: no line has 'rnage' in column '1'");
  CHECK(fault_of(where(value, "one", "range")) ==
        "/where/column: 'one' is not a column: without header, columns are numbers from 1");
  // A line of the kind that is cut short is an error, not one of another kind.
  const TemporaryFile cut("range 1 5 1\nrange 1 7\n");
  CHECK(fault_of(with_member(where(value, "1", "range"), "path", cut.path())) ==
        "B062 line 2: 3 columns where the first row has 4");
}

TEST_CASE("csv where: by the name of a column, and the header is always read") {
  const TemporaryFile file("t,kind,prn,rho\n1,a,5,1\n1,b,5,9\n1,a,7,2\n");
  const auto where = [&](const char* name, const char* is) {
    return with_member(by_rows(file.path()), "where", object({{"column", name}, {"is", is}}));
  };
  const auto list = epochs(where("kind", "a"));
  REQUIRE(list.size() == 1);
  CHECK(list[0].rows == std::vector<double>{5, 1000, 7, 2000});
  CHECK(fault_of(where("kind", "c")) == "B066 line 0: no line has 'c' in column 'kind'");
  CHECK(fault_of(where("kinds", "a")).find("/where/column: no column 'kinds'; did you mean 'kind'?") == 0);
}

TEST_CASE("csv rows: whatever a spoilt file holds, every sample has rows with different keys, in order of time") {
  const std::string good = "t,prn,rho\n1,5,1\n1,7,2\n2,5,3\n2,7,4\n2,9,5\n3,5,6\n";
  std::uint64_t state = 4711;
  const auto draw = [&](std::size_t below) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>(state >> 33) % below;
  };
  const char alphabet[] = "0123456789.,-e\n x\"#";
  int survived = 0, refused = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    std::string spoilt = good;
    for (std::size_t change = 0; change <= draw(4); ++change) {
      const std::size_t at = 10 + draw(spoilt.size() - 10);
      const char c = alphabet[draw(sizeof alphabet - 1)];
      switch (draw(3)) {
        case 0: spoilt[at] = c; break;
        case 1: spoilt.erase(at, 1 + draw(3)); break;
        default: spoilt.insert(at, 1, c);
      }
    }
    const TemporaryFile file(spoilt);
    INFO(spoilt);
    auto value = by_rows(file.path());
    if (trial % 2) value = with_member(value, "invalid_rows", "skip");
    try {
      Time last = no_time;
      for (const Epoch& epoch : epochs(value)) {
        REQUIRE((last == no_time || epoch.t > last));
        last = epoch.t;
        std::set<double> keys;
        for (std::size_t i = 0; i < epoch.rows.size(); i += 2) REQUIRE(keys.insert(epoch.rows[i]).second);
        REQUIRE((!keys.empty() && keys.size() <= 4));
      }
      ++survived;
    } catch (const ComponentError& error) {
      REQUIRE((error.is_data_error() || !error.pointer().empty()));
      ++refused;
    }
  }
  CHECK(survived > 500);
  CHECK(refused > 500);
}

}  // namespace csv_rows_test
