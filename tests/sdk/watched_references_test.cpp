// SPDX-License-Identifier: Apache-2.0
// Without a summary only what metrics are of is scored, and no metric depends on it.
#include <cmath>

#include "catch.hpp"

#include "score/metric.hpp"
#include "score/run.hpp"

namespace watched_references_test {

using namespace binnacle;

namespace {

/// By one run, of which there is a summary or not.
std::vector<score::MetricValue> values_of(const std::shared_ptr<const Composition>& composition,
                                          const std::vector<std::string>& names, bool wants_summary) {
  score::RunOptions options;
  options.wants_summary = wants_summary;
  for (const auto& name : names) options.metrics.push_back(*score::read_metric(*composition, name));
  return score::run(composition, options).metrics;
}

}  // namespace

TEST_CASE("metrics of runs without a summary are those of runs with one, alone and together") {
  const auto composition = score::load(BINNACLE_TEST_PROJECT "/configs/quickstart.json");
  const std::vector<std::string> names = {
      "ins/velocity.north/rms", "ins/position.horizontal/final",     "ins/attitude.yaw/max",
      "ins/attitude.yaw/drift", "ins/velocity.down/sigma",           "ins/attitude/nees",
      "ins/state/nees",         "ins/position.segments/translation", "ins/position.segments/rotation"};
  const auto expected = values_of(composition, names, true);
  const auto is_expected = [&](std::size_t i, const score::MetricValue& value) {
    return value.value == expected[i].value && value.dof == expected[i].dof && value.n == expected[i].n;
  };
  const auto together = values_of(composition, names, false);
  REQUIRE(together.size() == names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    INFO(names[i]);
    CHECK(std::abs(expected[i].value) > 0);
    CHECK(is_expected(i, together[i]));
    CHECK(is_expected(i, values_of(composition, {names[i]}, false).front()));
  }
}

}  // namespace watched_references_test
