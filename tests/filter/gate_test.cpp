// SPDX-License-Identifier: Apache-2.0
// The gate by row and by key: what is left out, what becomes of the rest, and what is reported of it.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace gate_test {

using namespace binnacle;

using filter_tests::session_of;

namespace {

struct Row {
  double key, z, slope, variance = 1;
};

/// Two unknowns seen by any number of rows, all at once or as two parts of a stack.
std::string seen(const std::string& extra, double sigma0 = 10, bool stacked = false) {
  const std::string part = R"("type": "rows", "blocks": {"x": "x"})";
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "max_rows": 8, "fields": {)"
         R"("key": {"unit": "1", "per_row": true}, "z": {"unit": "1", "per_row": true},)"
         R"("slope": {"unit": "1", "per_row": true}, "variance": {"unit": "1", "per_row": true}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 2, "unit": "1", "sigma": [)" +
         std::to_string(sigma0) + R"(, 0.1]}},
      "process": {"keep": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"see": {"channel": "z", )" +
         (stacked ? R"("stack": {"first": {)" + part + R"(}, "second": {)" + part + "}}" : part) + extra + "}}}}}";
}

void push(Session& filter, double t, const std::vector<Row>& rows) {
  SampleView sample;
  sample.t = nanoseconds(t);
  sample.rows = static_cast<int>(rows.size());
  sample.row_fields = &rows.front().key;
  sample.available = true;
  filter.push(filter.channel("z"), sample);
}

class Keep : public StepObserver {
 public:
  void offered(const UpdateRecord& record) override {
    outcome = record.outcome;
    keys.assign(record.row_keys, record.row_keys + record.rows);
    groups.assign(record.row_groups, record.row_groups + record.rows);
    left_out.assign(record.left_out_keys, record.left_out_keys + record.left_out);
    S = record.S.as();
    nis = record.nis;
  }
  Outcome outcome = Outcome::late;
  std::vector<std::int64_t> keys, left_out;
  std::vector<int> groups;
  Eigen::MatrixXd S;
  double nis = 0;
};

const std::vector<Row> good = {{11, 5.2, 1}, {12, 4.9, -1}, {13, 5.1, 0.5}, {14, 4.6, -0.3}, {15, 5.0, 0.1}};

}  // namespace

TEST_CASE("a gate by row leaves out the row that disagrees, and the rest is as if it had never been there") {
  auto with_outlier = good;
  with_outlier.insert(with_outlier.begin() + 2, {99, 1005, 0.2});
  Session gated = session_of(seen(R"(, "gate": {"probability": 0.999, "by": "row"})"));
  Session clean = session_of(seen(""));
  Keep kept, expected;
  gated.attach({0}, &kept);
  clean.attach({0}, &expected);
  push(gated, 0, with_outlier);
  push(clean, 0, good);
  REQUIRE(kept.outcome == Outcome::accepted);
  REQUIRE(kept.left_out == std::vector<std::int64_t>{99});
  REQUIRE(kept.keys == expected.keys);
  REQUIRE(std::abs(kept.nis - expected.nis) < 1e-12);
  REQUIRE((kept.S - expected.S).norm() < 1e-12);
  for (int i = 0; i < 2; ++i)
    REQUIRE(std::abs(gated.state(FilterId{0})[static_cast<std::size_t>(i)] -
                     clean.state(FilterId{0})[static_cast<std::size_t>(i)]) < 1e-12);
  REQUIRE((Eigen::MatrixXd(gated.covariance(FilterId{0}).as()) - Eigen::MatrixXd(clean.covariance(FilterId{0}).as()))
              .norm() < 1e-13);
  REQUIRE(gated.counts({{0}, 0}).rows_left_out == 1);
  REQUIRE(clean.counts({{0}, 0}).rows_left_out == 0);
}

TEST_CASE("an error that all rows share is no row's, while the filter leaves it open") {
  auto all = good;
  for (auto& row : all) row.z += 300;
  Session open = session_of(seen(R"(, "gate": {"probability": 0.999, "by": "row"})", 1e3));
  push(open, 0, all);
  REQUIRE(open.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::accepted)] == 1);
  REQUIRE(open.counts({{0}, 0}).rows_left_out == 0);

  Session sure = session_of(seen(R"(, "gate": {"probability": 0.999, "by": "row"},
    "recover": {"after": 2, "inflate": {"x.x0": 1000}})",
                                 0.5));
  push(sure, 0, all);
  REQUIRE(sure.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::gated)] == 1);
  REQUIRE(sure.counts({{0}, 0}).last_reason == "no majority of its rows agrees with the rest");
  push(sure, 1, all);
  push(sure, 2, all);
  REQUIRE(sure.counts({{0}, 0}).recoveries == 1);
  REQUIRE(sure.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::accepted)] == 1);
}

TEST_CASE("several outliers are left out one after the other") {
  auto rows = good;
  rows[1].z += 50;
  rows[3].z -= 80;
  Session filter = session_of(seen(R"(, "gate": {"probability": 0.999, "by": "row"})"));
  Keep kept;
  filter.attach({0}, &kept);
  push(filter, 0, rows);
  REQUIRE(kept.outcome == Outcome::accepted);
  REQUIRE(kept.left_out == std::vector<std::int64_t>{14, 12});
}

TEST_CASE("a gate by key leaves out the rows of one key in all parts of a stack, and groups stay told apart") {
  auto rows = good;
  rows.resize(4);
  rows[0].z += 200;
  Session filter = session_of(seen(R"(, "gate": {"probability": 0.999, "by": "key"})", 10, true));
  Keep kept;
  filter.attach({0}, &kept);
  push(filter, 0, rows);
  REQUIRE(kept.outcome == Outcome::accepted);
  REQUIRE(kept.left_out == std::vector<std::int64_t>{11, 11});
  REQUIRE(kept.keys == std::vector<std::int64_t>{12, 13, 14, 12, 13, 14});
  REQUIRE(kept.groups == std::vector<int>{0, 0, 0, 1, 1, 1});
}

TEST_CASE("a gate by row lets right rows pass as often as it says") {
  // 20000 rows of unit noise; 0.99 per row leaves out 1 %, give or take five deviations of sqrt(200).
  Session filter = session_of(seen(R"(, "gate": {"probability": 0.99, "by": "row"})", 1e-9));
  std::uint64_t state = 12345;
  const auto uniform = [&] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return (static_cast<double>(state >> 11) + 0.5) / 9007199254740992.0;
  };
  const auto normal = [&] { return std::sqrt(-2 * std::log(uniform())) * std::cos(6.283185307179586 * uniform()); };
  for (int i = 0; i < 4000; ++i) {
    std::vector<Row> rows;
    for (int k = 0; k < 5; ++k) rows.push_back({static_cast<double>(k), normal(), 0});
    push(filter, 0, rows);
  }
  REQUIRE(filter.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::accepted)] >= 3999);
  REQUIRE(std::abs(static_cast<double>(filter.counts({{0}, 0}).rows_left_out) - 200) < 71);
}

TEST_CASE("what is wrong with a gate is reported at its place") {
  for (const auto& [gate, says] :
       std::vector<std::pair<std::string, std::string>>{{R"({"by": "row"})", "probability"},
                                                        {R"({"probability": 0.9, "by": "rows"})", "did you mean 'row'"},
                                                        {R"({"probability": 1.5})", "out of range"},
                                                        {R"({"probability": 0.9, "per": "row"})", "unknown key"}}) {
    INFO(gate);
    try {
      session_of(seen(R"(, "gate": )" + gate));
      FAIL("it was taken");
    } catch (const ConfigError& error) {
      REQUIRE(std::string(error.what()).find(says) != std::string::npos);
    }
  }
}

TEST_CASE("a noise estimator learns once from a sample whose outliers are left out, and not from those") {
  // R is (1 + calls seen) times nominal: a round of the gate that is not rolled back would show.
  const auto filter_of = [] {
    return session_of(seen(R"(, "gate": {"probability": 0.999, "by": "row"}, "noise": {"type": "counting"})"));
  };
  auto rows = good;
  rows[1].z += 500;
  auto clean_rows = good;
  clean_rows.erase(clean_rows.begin() + 1);
  Session with = filter_of(), without = filter_of();
  push(with, 0, rows);
  push(without, 0, clean_rows);
  for (Session* filter : {&with, &without}) push(*filter, 1, good);
  REQUIRE(with.counts({{0}, 0}).rows_left_out == 1);
  REQUIRE((Eigen::MatrixXd(with.covariance(FilterId{0}).as()) - Eigen::MatrixXd(without.covariance(FilterId{0}).as()))
              .norm() < 1e-13);
}

TEST_CASE("a sample gated for want of a majority reports what was left out before, and the NIS of all its rows") {
  const std::vector<Row> split = {{1, 0, 0}, {2, 0, 0}, {3, 900, 0}, {4, -900, 0}, {5, 1800, 0}};
  Session filter = session_of(seen(R"(, "gate": {"probability": 0.999, "by": "row"})", 0.1));
  Keep kept;
  filter.attach({0}, &kept);
  push(filter, 0, split);
  REQUIRE(kept.outcome == Outcome::gated);
  REQUIRE(kept.left_out.size() == 3);
  REQUIRE(kept.nis > 1e6);
  REQUIRE(filter.counts({{0}, 0}).rows_left_out == 0);
}

}  // namespace gate_test
