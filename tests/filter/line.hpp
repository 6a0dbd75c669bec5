// SPDX-License-Identifier: Apache-2.0
// Sessions of configs given as text, and the smallest filter worth testing.
#pragma once

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/session.hpp"

namespace filter_tests {

using namespace binnacle;

/// Of a config and one plugin that is built for these tests.
inline std::shared_ptr<const Composition> composition_of(const std::string& text, const char* plugin = PROBE_PLUGIN) {
  LoadOptions options;
  options.sets = {"/plugins=[]", std::string("/plugins/-=") + plugin};
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  return Composition::parse(text, "test.json", options);
}

/// The config with P of each of its filters in a form: "ud".
inline std::string with_form(std::string text, const std::string& form) {
  const std::string before = "\"process\": {", key = "\"covariance\": \"" + form + "\", ";
  for (std::size_t at = text.find(before); at != std::string::npos; at = text.find(before, at + key.size() + 1))
    text.insert(at, key);
  return text;
}

inline Session session_of(const std::string& text) { return Session(composition_of(text)); }

inline void push(Session& filter, const char* channel, double t, std::vector<double> fields) {
  filter.push(filter.channel(channel), no_time, nanoseconds(t), fields);
}

/// Position and velocity on a line: position integrates velocity, velocity wanders; position is measured.
inline std::string line(const std::string& blocks_extra = "", const std::string& measurement_extra = "",
                        const std::string& velocity_extra = "") {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {
        "position": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2},
        "velocity": {"type": "vector", "size": 1, "unit": "m/s", "init": 0.5, "sigma": 0.3)" +
         velocity_extra + R"(})" + blocks_extra + R"(},
      "process": {
        "move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
        "wander": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": 0.2}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "position"},
                               "sigma": [0.7])" +
         measurement_extra + R"(}}}}})";
}

/// Position by a fix and velocity by a speedometer, each a measurement of its own: `fix` and `speed` are their sigma and
/// what else they have.
inline std::string fix_and_speed(const std::string& fix, const std::string& speed) {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}},
                "v": {"type": "pushed", "fields": {"z0": {"unit": "m/s"}}}},
    "filters": {"f": {
      "blocks": {"position": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 2},
                 "velocity": {"type": "vector", "size": 1, "unit": "m/s", "init": 0, "sigma": 0.3}},
      "process": {"move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
                  "wander": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": 0.01}},
      "measurements": {
        "fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "position"}, )" +
         fix + R"(},
        "speed": {"type": "linear_measurement", "channel": "v", "blocks": {"x": "velocity"}, )" +
         speed + R"(}}}}})";
}

}  // namespace filter_tests
