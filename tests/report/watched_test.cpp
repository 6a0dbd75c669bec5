// SPDX-License-Identifier: Apache-2.0
// What is kept and shown of a run that goes on: bounded, nothing while nobody looks, and no figure that it does not know.
#include "../catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "decimation.hpp"
#include "fixture.hpp"
#include "report/page.hpp"
#include "report/watched_run.hpp"
#include "score/run.hpp"
#include "score/sections.hpp"
#include "thinned_updates.hpp"

namespace watched_test {

using namespace binnacle;
using namespace binnacle::report;

namespace {

using Json = nlohmann::ordered_json;

/// Row r of sample i.
double residual_of(std::size_t i, int r) {
  if (i == 123'456) return r == 1 ? 50 : 0.1;
  if (i == 777'777) return r == 0 ? -60 : 0.1;
  return std::sin(0.7 * static_cast<double>(i) + r);
}

double nis_of(std::size_t i) { return i == 400'001 ? 99 : 2 + std::sin(1.3 * static_cast<double>(i)); }

Outcome outcome_of(std::size_t i) {
  if (i == 500'000) return Outcome::late;
  return i % 1000 == 7 ? Outcome::gated : Outcome::accepted;
}

MeasurementInfo two_rows() {
  MeasurementInfo info;
  info.name = "fix";
  info.max_rows = 2;
  info.groups = {{"position", "m"}};
  return info;
}

void add(ThinnedUpdates& updates, std::size_t i) {
  const std::int64_t keys[] = {0, 1};
  const int groups[] = {0, 0};
  const double residual[] = {residual_of(i, 0), residual_of(i, 1)};
  const double S[] = {4, 0, 0, 9}, R[] = {1, 0, 0, 4};
  UpdateRecord record;
  record.t = static_cast<Time>(i) * 10'000'000;
  record.outcome = outcome_of(i);
  if (record.outcome != Outcome::late) {
    record.rows = 2;
    record.row_keys = keys;
    record.row_groups = groups;
    record.residual = residual;
    record.nis = nis_of(i);
    record.S = ConstMatrixView{S, 2, 2, 2};
    record.R = ConstMatrixView{R, 2, 2, 2};
  }
  updates.add(record);
}

/// Whether every number that is kept is that of its sample.
bool is_true(const results::Updates& updates) {
  std::size_t row = 0;
  for (std::size_t k = 0; k < updates.t.size(); ++k) {
    const auto i = static_cast<std::size_t>(std::llround(updates.t[k] * 100));
    if (updates.outcome[k] != outcome_of(i)) return false;
    if (updates.rows[k] != (outcome_of(i) == Outcome::late ? 0 : 2)) return false;
    if (updates.rows[k] > 0 && updates.nis[k] != nis_of(i)) return false;
    for (int r = 0; r < updates.rows[k]; ++r, ++row)
      if (updates.residual[row] != residual_of(i, r) || updates.key[row] != r || updates.sigma[row] != 2 + r ||
          updates.noise[row] != 1 + r)
        return false;
  }
  return row == updates.residual.size();
}

class Looker final : public score::RunObserver {
 public:
  explicit Looker(Time from) : from_(from) {}
  bool wants_records() const override { return false; }
  void begin_run(const Session& session) override {
    session_ = &session;
    run_ = std::make_unique<WatchedRun>(session);
  }
  StepObserver* step_observer(int filter) override { return observer_ = run_->step_observer(filter, nullptr); }
  void after_instant() override {
    const bool looks = session_->started({0}) && session_->time({0}) >= from_;
    run_->look(looks);
    if (!looks) return;
    run_->take();
    if (++instants_ % 1000 == 0) most = std::max(most, run_->seen().filters[0].t.size());
  }
  void finished() override {
    seen = run_->seen();
    observer_->rewound(rewind_to);
    rewound = run_->seen();
  }

  results::RunResults seen, rewound;
  std::size_t most = 0;
  static constexpr Time rewind_to = 100 * nanoseconds_per_second;

 private:
  Time from_;
  const Session* session_ = nullptr;
  std::unique_ptr<WatchedRun> run_;
  StepObserver* observer_ = nullptr;
  int instants_ = 0;
};

Looker looked_from(Time from) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  Looker looker(from);
  score::RunOptions options;
  options.observer = &looker;
  score::run(score::load(BINNACLE_TEST_PROJECT "/configs/quickstart.json"), options);
  return looker;
}

}  // namespace

TEST_CASE("Thinning: again and again in longer stretches leaves what thinning of the whole leaves") {
  std::vector<double> t, values;
  std::vector<std::uint8_t> kinds;
  for (std::size_t i = 0; i < 20'000; ++i) {
    t.push_back(1000.3 + 0.013 * static_cast<double>(i) + (i > 9000 ? 40 : 0));
    values.push_back(std::sin(0.37 * static_cast<double>(i * i % 7919)));
    kinds.push_back(i % 877 == 0 ? 3 : 0);
  }
  const auto whole = extremes_in_time({values}, kinds, t, 1.6);
  std::vector<std::size_t> kept(t.size());
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = i;
  for (const double width : {0.2, 0.4, 0.8, 1.6}) {
    std::vector<double> some_t, some_values;
    std::vector<std::uint8_t> some_kinds;
    for (const auto i : kept) {
      some_t.push_back(t[i]);
      some_values.push_back(values[i]);
      some_kinds.push_back(kinds[i]);
    }
    std::vector<std::size_t> next;
    for (const auto k : extremes_in_time({some_values}, some_kinds, some_t, width)) next.push_back(kept[k]);
    kept = next;
  }
  REQUIRE(whole.size() < 1000);
  REQUIRE(kept == whole);
}

TEST_CASE(
    "ThinnedUpdates: a million samples in bounded memory, every peak and the only one of its outcome among them") {
  ThinnedUpdates updates(two_rows());
  std::size_t most = 0;
  for (std::size_t i = 0; i < 1'000'000; ++i) {
    add(updates, i);
    most = std::max(most, updates.updates().t.size());
  }
  const auto& kept = updates.updates();
  REQUIRE(most <= ThinnedUpdates::most_samples);
  REQUIRE(kept.t.size() > 500);
  REQUIRE(is_true(kept));
  REQUIRE(std::is_sorted(kept.t.begin(), kept.t.end()));
  for (const double peak : {1234.56, 7777.77, 4000.01, 5000.0}) {
    INFO(peak);
    REQUIRE(std::any_of(kept.t.begin(), kept.t.end(), [&](double t) { return std::abs(t - peak) < 1e-6; }));
  }
  REQUIRE(kept.t.front() == 0);
  REQUIRE(kept.t.back() > 9900);
}

TEST_CASE("ThinnedUpdates: what came after a time is void once it is gone back to") {
  ThinnedUpdates updates(two_rows());
  for (std::size_t i = 0; i < 50'000; ++i) add(updates, i);
  updates.rewind(250);
  REQUIRE(updates.updates().t.back() <= 250);
  REQUIRE(updates.updates().t.back() > 245);
  REQUIRE(is_true(updates.updates()));
  for (std::size_t i = 25'001; i < 60'000; ++i) add(updates, i);
  REQUIRE(is_true(updates.updates()));
  updates.rewind(-1);
  REQUIRE(updates.updates().t.empty());
  REQUIRE(updates.updates().residual.empty());
}

TEST_CASE("WatchedRun: nothing is kept while nobody looks, but counts are of the whole run") {
  const Looker nobody = looked_from(nanoseconds_per_second * 1'000'000);
  const auto& filter = nobody.seen.filters.at(0);
  REQUIRE(filter.t.size() == 1);  // what there is at the moment
  for (const auto& updates : filter.updates) REQUIRE(updates.t.empty());
  const Json& figures = nobody.seen.summary["filters"]["ins"];
  REQUIRE(figures["measurements"]["fix"]["accepted"] == 194);
  REQUIRE(figures["verdict"]["state"] == "ok");
}

TEST_CASE("WatchedRun: of a run that is watched, no more than a plot takes, evenly, to its end") {
  const Looker looker = looked_from(0);
  const auto& filter = looker.seen.filters.at(0);
  REQUIRE(looker.most <= 2049);
  REQUIRE(filter.t.size() > 1000);
  REQUIRE(filter.t.back() == looker.seen.summary["filters"]["ins"]["end_s"].get<double>());
  double widest = 0;
  for (std::size_t i = 1; i + 1 < filter.t.size(); ++i) widest = std::max(widest, filter.t[i] - filter.t[i - 1]);
  REQUIRE(widest < 2.5 * (filter.t.back() - filter.t.front()) / static_cast<double>(filter.t.size()));
  REQUIRE(filter.estimates.size() == 15);
  for (const auto& estimate : filter.estimates) {
    REQUIRE(estimate.values.size() == filter.t.size());
    REQUIRE(estimate.sigma.size() == filter.t.size());
    REQUIRE(*std::min_element(estimate.sigma.begin(), estimate.sigma.end()) > 0);
  }
  REQUIRE(filter.updates.at(0).t.size() == 194);  // few: all of them

  const auto& rewound = looker.rewound.filters.at(0);
  REQUIRE(rewound.updates.at(0).t.back() <= 100);
  REQUIRE(rewound.updates.at(0).t.back() > 98);
  REQUIRE(rewound.t.at(rewound.t.size() - 2) <= 100);
}

TEST_CASE("WatchedRun: from when somebody looks") {
  const Looker late = looked_from(nanoseconds_per_second * 150);
  REQUIRE(late.seen.filters.at(0).t.front() == 150);
  REQUIRE(late.seen.filters.at(0).updates.at(0).t.front() >= 150);
}

TEST_CASE("Live payload: counts are the summary's, and no share or mean is made of what was thinned") {
  results::RunResults run = *test::run_results("ins", 3000).run;
  run.summary["filters"]["ins"]["measurements"]["fix"]["offered"] = 5'000'000;
  const std::string text = live_payload(run, false);
  REQUIRE(text.find('\n') == std::string::npos);
  REQUIRE(text.starts_with(R"({"live":"goes on")"));
  const Json payload = Json::parse(text);
  const Json& fix = payload["run"]["filters"][0]["measurements"][0];
  const Json& figures = run.summary["filters"]["ins"]["measurements"]["fix"];
  REQUIRE(fix["n"] == 5'000'000);
  REQUIRE(fix["outcomes"]["counts"][0] == figures["accepted"]);
  REQUIRE(fix["outcomes"]["counts"][1] == figures["gated"]);
  REQUIRE(fix["nis"]["mean"]["value"] == figures["nis_mean"]);
  REQUIRE(fix["reasons"].empty());
  for (const char* made : {"inside", "accepted", "moving"}) REQUIRE(!fix["nis"].contains(made));
  for (const auto& residual : fix["residuals"]) REQUIRE(residual["within"].is_null());
  REQUIRE(live_payload(run, true).starts_with(R"({"live":"over")"));
  REQUIRE(live_page(run).find("connect-src 'self'") != std::string::npos);
  REQUIRE(page(test::run_results("ins", 100)).find("connect-src") == std::string::npos);
}

}  // namespace watched_test
