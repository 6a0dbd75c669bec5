// SPDX-License-Identifier: Apache-2.0
// The filter that benchmarks measure.
#pragma once

#include <string>

namespace binnacle::bench {

/// A filter that subscribes to nothing, for a config that is about something else.
inline const char* const idle_filter =
    R"("filters": {"idle": {"blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1}},
                         "process": {"stands": {"type": "random_constant", "blocks": {"x": "x"}}}}})";

/// A channel "z" that nobody subscribes to: what a push costs beside what is done with it.
inline std::string idle_config() {
  return R"({"binnacle": 1, "sources": {"z": {"type": "pushed", "fields": {"x": {"unit": "m"}}}}, )" +
         std::string(idle_filter) + "}";
}

/// An INS of n states: position, velocity, attitude; from 15 on gyro and accelerometer bias, from 21 on their scale
/// factors; what remains are Gauss-Markov states in vectors of three that nothing reads.
inline std::string ins_config(int n, const std::string& order = "", const std::string& history = "") {
  struct Optional {
    const char* name;
    const char* unit;
    const char* sigma;
    const char* process;
  };
  constexpr const char* bias_process = R"("type": "gauss_markov", "tau": "1 h", )";
  constexpr const char* constant_process = R"("type": "random_constant", )";
  const Optional optional[] = {{"gyro_bias", "rad/s", "10 deg/h", bias_process},
                               {"accel_bias", "m/s^2", "1 mg", bias_process},
                               {"gyro_scale", "1", "300 ppm", constant_process},
                               {"accel_scale", "1", "300 ppm", constant_process}};
  std::string blocks, process, ports;
  int states = 9;
  for (const auto& block : optional) {
    if (states + 3 > n) break;
    const std::string name = block.name;
    blocks += ", \"" + name + R"(": {"type": "vector", "size": 3, "unit": ")" + block.unit + R"(", "sigma": ")" +
              block.sigma + "\"}";
    const bool drifts = block.process == bias_process;
    process += ", \"of_" + name + "\": {" + block.process + R"("blocks": {"x": ")" + name + "\"}" +
               (drifts ? R"(, "sigma": ")" + std::string(block.sigma) + "\"" : "") + "}";
    ports += ", \"" + name + "\": \"" + name + "\"";
    states += 3;
  }
  for (int i = 0; states + 3 <= n; ++i, states += 3) {
    const std::string name = "extra" + std::to_string(i);
    blocks += ", \"" + name + R"(": {"type": "vector", "size": 3, "unit": "m", "sigma": 1})";
    process +=
        ", \"" + name + R"(": {"type": "gauss_markov", "blocks": {"x": ")" + name + R"("}, "tau": "1 h", "sigma": 1})";
  }
  const std::string history_text = history.empty() ? "" : "\"history\": " + history + ", ";
  const std::string order_text = order.empty() ? "" : R"(, "order": ")" + order + "\"";
  return R"({"binnacle": 1,
    "sources": {
      "imu": {"type": "pushed", "fields": {
        "wx": {"unit": "rad", "kind": "increment"}, "wy": {"unit": "rad", "kind": "increment"},
        "wz": {"unit": "rad", "kind": "increment"}, "fx": {"unit": "m/s", "kind": "increment"},
        "fy": {"unit": "m/s", "kind": "increment"}, "fz": {"unit": "m/s", "kind": "increment"}}},
      "gnss": {"type": "pushed", "fields": {
        "lat": {"unit": "rad"}, "lon": {"unit": "rad"}, "height": {"unit": "m"}}}},
    "filters": {"ins": {)" +
         history_text + R"(
      "blocks": {
        "position": {"type": "position", "init": {"lat": "48 deg", "lon": "11 deg", "height": 500}, "sigma": "5 m"},
        "velocity": {"type": "velocity", "init": {"vn": 3, "ve": 4, "vd": 0}, "sigma": "0.5 m/s"},
        "attitude": {"type": "attitude", "init": {"roll": 0, "pitch": 0, "yaw": "0.5 rad"}, "sigma": "1 deg"})" +
         blocks +
         R"(},
      "process": {
        "strapdown": {"type": "phi_error", "input": "imu",
          "blocks": {"position": "position", "velocity": "velocity", "attitude": "attitude")" +
         ports + R"(},
          "gyro_noise": 2.9e-5, "accel_noise": 5e-4)" +
         order_text + "}" + process + R"(},
      "measurements": {"fix": {"type": "position_fix", "channel": "gnss", "blocks": {"position": "position"},
                               "sigma": "2 m"}}}}})";
}

}  // namespace binnacle::bench
