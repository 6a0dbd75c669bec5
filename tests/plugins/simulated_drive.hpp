// SPDX-License-Identifier: Apache-2.0
// A simulated drive for tests: the vehicle simulator with parameters from JSON, sample by sample.
#pragma once

#include "binnacle/testing.hpp"

#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "config/document.hpp"
#include "spec/check.hpp"
#include "strapdown/earth.hpp"
#include "vehicle_simulator/simulator.hpp"

namespace binnacle::simulated_drive {

using namespace binnacle::vehicle_simulator;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
constexpr double degree = std::numbers::pi / 180.0;

// ---- parameters from JSON, checked by the kernel

inline ParameterValue checked(const Json& config) {
  Diagnostics diagnostics;
  const auto document = config::Document::load("test.json", {}, diagnostics, config.dump());
  ParameterValue value =
      Reader(document, diagnostics).parameters(VehicleSimulator::spec().parameters, "vehicle_simulator");
  INFO(diagnostics.text());
  REQUIRE(diagnostics.empty());
  return value;
}

// ---- running it

struct Quiet final : Reporter {
  void warn(const std::string&, const std::string&, int, const std::string&) override {}
};

struct Emitted {
  int channel;
  Time t, t0;
  std::vector<double> fields;
  std::vector<double> covariance;

  bool operator==(const Emitted& other) const {
    return channel == other.channel && t == other.t && t0 == other.t0 && fields == other.fields &&
           covariance == other.covariance;
  }
  Vector3d triple(std::size_t first) const { return {fields[first], fields[first + 1], fields[first + 2]}; }
};

class Drive {
 public:
  explicit Drive(const Json& config, std::uint64_t seed = 1) {
    const ParameterValue parameters = checked(config);
    source_ = std::make_shared<VehicleSimulator>(Binding({"drive", Parameters(parameters)}));
    Quiet quiet;
    source_->open(quiet);
    restart(seed);
  }

  void restart(std::uint64_t seed) { memory_ = binnacle::testing::SourceCaller(*source_).fresh_memory(seed); }

  std::optional<Emitted> next() {
    const auto next = binnacle::testing::SourceCaller(*source_).next(memory_.data());
    REQUIRE(next.damage.empty());
    if (next.status == SourceStatus::end) return std::nullopt;
    return Emitted{next.sample.channel, next.sample.t, next.sample.t0, next.sample.fields, next.sample.covariance};
  }

  std::vector<Emitted> rest() {
    std::vector<Emitted> all;
    while (auto sample = next()) all.push_back(std::move(*sample));
    return all;
  }

  std::vector<Emitted> of(int channel) {
    std::vector<Emitted> chosen;
    while (auto sample = next())
      if (sample->channel == channel) chosen.push_back(std::move(*sample));
    return chosen;
  }

  std::vector<std::byte>& memory() { return memory_; }
  const std::vector<ChannelDeclaration>& channels() const { return source_->declaration().channels; }

 private:
  std::shared_ptr<VehicleSimulator> source_;
  std::vector<std::byte> memory_;
};

inline Trajectory trajectory_of(const Json& config) {
  const ParameterValue value = checked(config);
  const Parameters p(value);
  const Parameters start = p.object("start");
  return Trajectory({{start.number("lat"), start.number("lon"), start.number("height")}}, read_segments(p),
                    {p.number("roll_gradient"), p.number("pitch_gradient")});
}

// ---- drives

inline const Json munich = {{"lat", "48.1 deg"}, {"lon", "11.6 deg"}, {"height", "520 m"}, {"heading", "30 deg"}};

inline Json lively_segments() {
  return Json::parse(R"([
    {"do": "still", "duration": "6 s"},
    {"do": "accelerate", "to": "14 m/s", "acceleration": "1.8 m/s^2"},
    {"do": "turn", "angle": "95 deg", "rate": "15 deg/s"},
    {"do": "straight", "duration": "5 s"},
    {"do": "climb", "height": "6 m", "duration": "12 s"},
    {"do": "turn", "angle": "-200 deg", "duration": "14 s"},
    {"do": "accelerate", "to": "22 m/s", "duration": "9 s"},
    {"do": "climb", "slope": "-4 deg", "duration": "7 s"},
    {"do": "accelerate", "to": 0, "acceleration": "-2.5 m/s^2"},
    {"do": "still", "duration": "3 s"}])");
}

inline Json lively_drive(int repeat) {
  return {{"start", munich},
          {"segments", lively_segments()},
          {"repeat", repeat},
          {"perfect", true},
          {"roll_gradient", "4 deg/g"},
          {"pitch_gradient", "1.5 deg/g"},
          {"gnss_rate", 1},
          {"truth_rate", 1}};
}

inline Json standing(double seconds_long) {
  return {{"start", munich}, {"segments", Json::array({{{"do", "still"}, {"duration", seconds_long}}})}};
}

inline double metres(const Vector3d& lla, const Vector3d& from) { return strapdown::position_minus(lla, from).norm(); }

}  // namespace binnacle::simulated_drive
