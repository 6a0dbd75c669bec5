// SPDX-License-Identifier: Apache-2.0
// Seeds: equal ones repeat a run to the bit, others do not, and what is added to a config draws nothing from the rest.
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/section.hpp"
#include "catch.hpp"
#include "run/runtime.hpp"
#include "score/run.hpp"

namespace repeat_test {

using namespace binnacle;

namespace {

using Sets = std::vector<std::string>;

/// Has every channel but the filters' shown to whoever runs the composition.
class AllChannels final : public Section {
 public:
  std::vector<std::string> keys() const override { return {}; }
  std::shared_ptr<const SectionData> read(CompositionDraft& draft) const override {
    for (std::size_t c = 0; c < draft.channels().size(); ++c)
      if (draft.channels()[c].pointer.rfind("/filters/", 0) != 0) draft.subscribe(static_cast<int>(c), "");
    return nullptr;
  }
};

std::shared_ptr<const Composition> load(Sets sets = {}) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = std::move(sets);
  options.sections.push_back(std::make_shared<AllChannels>());
  return score::load(BINNACLE_TEST_PROJECT "/tests/consistency/matched.json", options);
}

/// The summary without what the clock on the wall says.
std::string summary(const std::shared_ptr<const Composition>& composition, score::RunOptions options) {
  auto reported = score::run(composition, options).summary;
  reported.erase("wall_s");
  for (auto& [name, filter] : reported["filters"].items()) filter.erase("filter_s");
  return reported.dump();
}

/// All numbers of a field, "drive.imu wx", over a run; its times under "drive.imu t".
class Samples {
 public:
  Samples(const std::shared_ptr<const Composition>& composition, score::RunOptions options)
      : plan_(composition->plan()) {
    score::run(composition, options);  // opens the sources
    internal::runtime::Runtime runtime(plan_);
    runtime.subscribe([this](int channel, const SampleView& sample) { take(channel, sample); });
    runtime.reset(options.seed, options.run);
    while (runtime.next_instant()) {
    }
  }
  /// Names of the fields that differ from the other's, of those that both have.
  std::vector<std::string> differences(const Samples& other) const {
    std::vector<std::string> names;
    for (const auto& [name, numbers] : values_) {
      const auto found = other.values_.find(name);
      if (found == other.values_.end()) continue;
      const auto& theirs = found->second;
      if (numbers.size() != theirs.size() ||
          std::memcmp(numbers.data(), theirs.data(), numbers.size() * sizeof(double)) != 0)
        names.push_back(name);
    }
    return names;
  }
  const std::vector<double>& of(const std::string& name) const { return values_.at(name); }

 private:
  void take(int index, const SampleView& sample) {
    const auto& channel = plan_.channels[static_cast<std::size_t>(index)];
    values_[channel.name + " t"].push_back(seconds(sample.t));
    for (std::size_t i = 0; i < channel.declaration.fields.size(); ++i)
      values_[channel.name + " " + channel.declaration.fields[i].name].push_back(sample.fields[channel.position[i]]);
  }
  const internal::compose::CompositionPlan& plan_;
  std::map<std::string, std::vector<double>> values_;
};

Samples samples(Sets sets, score::RunOptions options = {5, 3}) { return {load(std::move(sets)), options}; }

using Names = std::vector<std::string>;
const Names gyro = {"drive.imu wx", "drive.imu wy", "drive.imu wz"};
const Names gyro_bias = {"drive.truth bgx", "drive.truth bgy", "drive.truth bgz"};

Names both(Names a, const Names& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

TEST_CASE("equal seeds give equal summaries to the byte, other seeds and runs do not") {
  const auto composition = load();
  const std::string first = summary(composition, {5, 3});
  REQUIRE(summary(composition, {5, 3}) == first);
  REQUIRE(summary(load(), {5, 3}) == first);
  REQUIRE(summary(composition, {5, 4}) != first);
  REQUIRE(summary(composition, {6, 3}) != first);
}

TEST_CASE("another block, process or source changes no sample of the others") {
  const Samples base = samples({});
  REQUIRE(base.of("drive.imu wx").size() > 10000);
  const Samples blocks =
      samples({R"(/filters/ins/blocks/more={"type": "vector", "size": 2, "unit": "m", "sigma": 1})",
               R"(/filters/ins/process/more={"type": "random_walk", "blocks": {"x": "more"}, "q": 1})"});
  REQUIRE(blocks.differences(base).empty());

  auto copy = nlohmann::ordered_json::parse(load()->config())["sources"]["drive"];
  const Samples sources = samples({"/sources/another=" + copy.dump()});
  REQUIRE(sources.differences(base).empty());
  REQUIRE(sources.of("another.imu wx") != sources.of("drive.imu wx"));
}

TEST_CASE("changing one error changes no other's draws") {
  const Samples base = samples({});
  const auto changed = [&](const std::string& set) { return samples({"/sources/drive" + set}).differences(base); };
  REQUIRE(changed("/gyro/noise=1 deg/sqrt(h)") == gyro);
  REQUIRE(changed("/gyro/bias=10 deg/h") == both(gyro, gyro_bias));
  REQUIRE(changed("/gyro/bias_instability=10 deg/h") == both(gyro, gyro_bias));
  REQUIRE(changed("/gnss/velocity_sigma=0.2 m/s") == Names{"drive.gnss vd", "drive.gnss ve", "drive.gnss velocity_sd_d",
                                                           "drive.gnss velocity_sd_e", "drive.gnss velocity_sd_n",
                                                           "drive.gnss vn"});
  REQUIRE(changed("/initial_sigma/heading=3 deg") ==
          Names{"drive.initial pitch", "drive.initial roll", "drive.initial yaw"});
}

}  // namespace repeat_test
