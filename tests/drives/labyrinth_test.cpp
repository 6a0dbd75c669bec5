// SPDX-License-Identifier: Apache-2.0
// The configs of configs/labyrinth: fitted on the first half of the recording, scored on the second.
#include <algorithm>
#include <filesystem>
#include <string>

#include "../recorded_data.hpp"
#include "catch.hpp"
#include "score/run.hpp"

namespace labyrinth_test {

using namespace binnacle;

namespace {

/// Horizontal RMS over the second half [m].
double second_half(const std::filesystem::path& data, const std::string& config) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions load;
  load.vars["uwb"] = data.string();
  const auto result = score::run(score::load(BINNACLE_TEST_PROJECT "/configs/labyrinth/" + config + ".json", load));
  INFO(config << "\n" << result.failures.text());
  CHECK(result.failures.empty());
  const auto& filter = result.summary.at("filters").at("robot");
  CHECK(filter.at("measurements").at("ranges").at("accepted") == 232);  // all but that of the start
  return filter.at("windows").at("second half").at("position.horizontal").at("rms");
}

}  // namespace

TEST_CASE("the labyrinth: of filters fitted on one half, one with a robust loss is best on the other", "[data]") {
  const auto data = binnacle::test::recorded_data("uwb");
  if (!data) return;
  const double gaussian = second_half(*data, "gaussian");
  double best = 1;
  for (const char* loss : {"huber", "cauchy", "student_t", "dcs"}) best = std::min(best, second_half(*data, loss));
  CAPTURE(gaussian, best);
  CHECK(best < gaussian);
}

}  // namespace labyrinth_test
