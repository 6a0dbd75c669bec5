// SPDX-License-Identifier: Apache-2.0
// Every filter of configs/ that needs no recorded data goes its first way with "propagation": "unscented" too, by its models as they are.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/catalog.hpp"
#include "binnacle/run.hpp"
#include "catch.hpp"
#include "score/run.hpp"
#include "score/sections.hpp"

namespace propagation_configs_test {

using namespace binnacle;

namespace {

namespace fs = std::filesystem;

/// Stops a run after so many steps of its filters, and looks whether they go on.
struct Beginning final : RunObserver, StepObserver {
  static constexpr int steps_each = 300;
  void begin(Session& its_session) override {
    session = &its_session;
    filters = static_cast<int>(session->composition().filters().size());
    for (int f = 0; f < filters; ++f) session->attach({f}, this);
  }
  bool progress(Time) override { return steps < steps_each * filters; }
  Wants wants() const override { return Wants::transition; }
  void stepped(const StepRecord& record) override {
    ++steps;
    is_finite = is_finite && record.Phi.as().allFinite() && record.Qd.as().allFinite();
  }
  void finished() override {
    for (int f = 0; f < filters; ++f) {
      is_healthy = is_healthy && session->healthy({f});
      is_started = is_started || session->started({f});
      diagnosis += session->diagnosis({f});
    }
  }
  Session* session = nullptr;
  int filters = 0, steps = 0;
  bool is_finite = true, is_healthy = true, is_started = false;
  std::string diagnosis;
};

/// A composition all of whose filters are unscented; null where it needs what is not there.
std::shared_ptr<const Composition> load(const fs::path& config) {
  try {
    const auto json = nlohmann::ordered_json::parse(score::load_config(config, {}).text());
    LoadOptions options;
    for (const auto& [name, filter] : json.at("filters").items())
      if (filter.contains("blocks")) options.sets.push_back("/filters/" + name + "/propagation=\"unscented\"");
    return options.sets.empty() ? nullptr : score::load(config, options);
  } catch (const std::exception&) {
    return nullptr;
  }
}

}  // namespace

TEST_CASE("every filter of configs/ that needs no recorded data can be propagated by sigma points") {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  const fs::path root = BINNACLE_TEST_PROJECT "/configs";
  int ran = 0;
  std::set<std::string> types;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.path().extension() != ".json") continue;
    const auto composition = load(entry.path());
    if (!composition) continue;
    const std::string name = fs::relative(entry.path(), root).string();
    INFO(name);
    Beginning beginning;
    RunOptions options;
    options.observer = &beginning;
    options.feeds_sinks = false;
    RunResult result;
    try {
      result = run(composition, options);
    } catch (const DataError&) {
      continue;  // its data are elsewhere
    }
    INFO(beginning.diagnosis << "\n" << result.warnings.text());
    CHECK(beginning.is_healthy);
    CHECK(beginning.is_finite);
    // A heading of which nothing is known, 100 deg, has sigma points beyond half a turn.
    const bool is_beyond_its_chart = name == "smartloc/odometry.json";
    CHECK((result.warnings.text().find("the step used the Jacobians") != std::string::npos) == is_beyond_its_chart);
    if (!beginning.is_started) continue;
    ++ran;
    for (const auto& filter : composition->filters())
      for (const auto& process : filter.processes) types.insert(process.type->full_name());
    std::printf("%-44s %6d steps\n", name.c_str(), beginning.steps);
    std::fflush(stdout);
  }
  for (const auto& type : types) std::printf("%s ", type.c_str());
  std::printf("\n");
  CHECK(ran >= 15);
  CHECK(types.size() >= 8);
}

}  // namespace propagation_configs_test
