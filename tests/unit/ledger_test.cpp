// SPDX-License-Identifier: Apache-2.0
// The ledger by itself: offered = Σ outcomes + waiting + open, at any time.
#include "filter/ledger.hpp"

#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"

namespace ledger_test {

using namespace binnacle;
using namespace binnacle::internal::filter;

namespace {

struct Fixture {
  Fixture() {
    plan.measurements.resize(2);
    plan.measurements[0].recover_after = 2;
    plan.measurements[0].inflations = {{0, 1.0}};
    plan.health = layout.add<Health>(1);
    for (auto& measurement : plan.measurements) {
      measurement.tally = layout.add<Tally>(1);
      measurement.nis = layout.add<NisMonitor>(1);
      measurement.rows = layout.add<RowMonitor>(2);
    }
    ledger.reset();
  }
  std::byte* bytes() { return reinterpret_cast<std::byte*>(arena.data()); }
  std::int64_t closed(int m) const {
    const auto& outcomes = ledger.tally(m).by_outcome;
    return std::accumulate(std::begin(outcomes), std::end(outcomes), std::int64_t{0});
  }

  struct alignas(Layout::alignment) Line {
    std::byte bytes[Layout::alignment];
  };
  FilterPlan plan;
  Layout layout;
  std::vector<Line> arena = std::vector<Line>(256);
  Ledger ledger{plan, bytes()};
};

class Keep : public StepObserver {
 public:
  void offered(const UpdateRecord& record) override {
    records.push_back(record);
    if (throws) throw std::runtime_error("an observer that throws");
  }
  std::vector<UpdateRecord> records;
  bool throws = false;
};

}  // namespace

TEST_CASE("a sample is open until it is closed, or waits and is reopened") {
  Fixture f;
  Keep keep;
  f.ledger.attach(&keep);
  f.ledger.open(1, 10);
  CHECK(f.ledger.has_open());
  CHECK(f.ledger.tally(1).offered == 1);
  f.ledger.wait();
  CHECK_FALSE(f.ledger.has_open());
  CHECK(f.closed(1) == 0);
  f.ledger.open(0, 20);
  f.ledger.close(Outcome::late, "too late");
  CHECK(f.closed(0) == 1);
  f.ledger.reopen(1, 10);
  f.ledger.reach();
  UpdateRecord record;
  record.rows = 3;
  record.nis = 2.5;
  f.ledger.close(Outcome::accepted, "", record);

  CHECK(f.ledger.tally(1).offered == 1);
  CHECK(f.ledger.tally(1).reached == 1);
  CHECK(f.ledger.tally(1).by_outcome[static_cast<int>(Outcome::accepted)] == 1);
  CHECK(f.ledger.tally(1).nis_sum == 2.5);
  CHECK(f.ledger.tally(1).rows_used == 3);
  CHECK(f.ledger.tally(1).last_accepted == 10);
  CHECK(f.ledger.tally(0).last_reason == std::string("too late"));
  REQUIRE(keep.records.size() == 2);
  CHECK(keep.records[0].measurement == 0);
  CHECK(keep.records[0].t == 20);
  CHECK(keep.records[1].measurement == 1);
  CHECK(keep.records[1].outcome == Outcome::accepted);
  CHECK(keep.records[1].t == 10);
}

TEST_CASE("an observer that throws leaves the outcome counted, once") {
  Fixture f;
  Keep keep;
  keep.throws = true;
  f.ledger.attach(&keep);
  f.ledger.open(0, 1);
  CHECK_THROWS(f.ledger.close(Outcome::gated, "beyond"));
  CHECK_FALSE(f.ledger.has_open());
  CHECK(f.closed(0) == 1);
}

TEST_CASE("recovery is due after so many gated ones in a row, and then again after as many") {
  Fixture f;
  const auto gate = [&](int m) {
    f.ledger.open(m, 0);
    f.ledger.close(Outcome::gated, "");
    return f.ledger.is_inflation_due(m);
  };
  CHECK_FALSE(gate(0));
  f.ledger.open(0, 0);
  f.ledger.close(Outcome::accepted, "");  // not in a row
  CHECK_FALSE(gate(0));
  CHECK(gate(0));
  CHECK_FALSE(gate(0));
  CHECK(gate(0));
  for (int i = 0; i < 5; ++i) CHECK_FALSE(gate(1));  // has none
}

TEST_CASE("rows that are left out are counted by key and group, and a new one takes the place of the oldest") {
  Fixture f;
  const std::int64_t keys[] = {7, 9, 7};
  const int groups[] = {0, 0, 0};
  f.ledger.open(0, 0);
  const double zeros[3] = {};
  const ConstMatrixView none{zeros, 3, 3, 0};
  f.ledger.leave_out({keys, groups, zeros, none, none});
  CHECK(f.ledger.tally(0).rows_left_out == 3);
  CHECK(f.ledger.rows(0)[0].key == 7);
  CHECK(f.ledger.rows(0)[0].left_out == 2);
  CHECK(f.ledger.rows(0)[1].key == 9);
  CHECK(f.ledger.rows(0)[1].left_out == 1);
  f.ledger.close(Outcome::accepted, "");
  f.ledger.open(0, 1);
  const std::int64_t later[] = {9, 11};
  f.ledger.leave_out({later, groups, zeros, none, none});
  CHECK(f.ledger.rows(0)[0].key == 11);
  CHECK(f.ledger.rows(0)[0].left_out == 1);
  CHECK(f.ledger.rows(0)[1].left_out == 2);
}

TEST_CASE("the first diagnosis stays, cut to its place") {
  Fixture f;
  CHECK_FALSE(f.ledger.is_broken());
  f.ledger.stop(std::string(1000, 'a'));
  f.ledger.stop("later");
  CHECK(f.ledger.is_broken());
  CHECK(std::string(f.ledger.diagnosis()) == std::string(sizeof(Health::diagnosis) - 1, 'a'));
}

}  // namespace ledger_test
