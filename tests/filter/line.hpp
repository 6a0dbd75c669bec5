// SPDX-License-Identifier: Apache-2.0
// Sessions of configs given as text, and the smallest filter worth testing.
#pragma once

#include <cstdlib>
#include <memory>
#include <optional>
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

/// Two components that start from a sample's covariance.
inline std::string from_covariance() {
  return R"({"binnacle": 1,
    "sources": {"start": {"type": "pushed", "fields": {"x0": {"unit": "m"}, "x1": {"unit": "m"}},
                          "covariance": ["x.x0", "x.x1"]},
                "z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 2, "unit": "m", "init": {"channel": "start"}}},
      "process": {"keep": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [1, 1]}}}}})";
}

/// Started with this correlation of the two.
inline Session started_with(double correlation, const std::string& config = from_covariance()) {
  Session session(composition_of(config));
  const double fields[] = {0, 0}, covariance[] = {1, correlation, correlation, 1};
  SampleView sample;
  sample.t = 0;
  sample.fields = fields;
  sample.covariance = covariance;
  session.push(session.channel("start"), sample);
  return session;
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

/// A receiver with position and speed in one sample: `gate` are the keys of the measurement, `sigma` is that of the position,
/// `q` the random walk of the velocity.
inline std::string receiver(const std::string& gate, double sigma, double q) {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m/s"}}}},
    "filters": {"f": {
      "blocks": {"position": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 2},
                 "velocity": {"type": "vector", "size": 1, "unit": "m/s", "init": 0, "sigma": 0.3}},
      "process": {"move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
                  "wander": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": )" +
         std::to_string(q) + R"(}},
      "measurements": {"fix": {"channel": "z", )" +
         gate + R"("stack": {
        "position": {"type": "linear_measurement", "blocks": {"x": "position"}, "fields": {"z0": "z0"}, "sigma": [)" +
         std::to_string(sigma) + R"(]},
        "speed": {"type": "linear_measurement", "blocks": {"x": "velocity"}, "fields": {"z0": "z1"}, "sigma": [0.1]}}}}}}})";
}

/// Reasons and notes of the first filter.
inline std::vector<TrustReason> reasons_of(const Session& session) {
  std::vector<TrustReason> reasons(16);
  reasons.resize(session.reasons(FilterId{0}, reasons));
  return reasons;
}

/// The first of this kind among them.
inline std::optional<TrustReason> reason_of(const Session& session, Doubt doubt) {
  for (const TrustReason& reason : reasons_of(session))
    if (reason.doubt == doubt) return reason;
  return std::nullopt;
}

}  // namespace filter_tests
