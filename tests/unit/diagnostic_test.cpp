// SPDX-License-Identifier: Apache-2.0
// Diagnostics: their text, their collection, the errors that carry them, and the search for what was meant.
#include "binnacle/diagnostic.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "catch.hpp"

namespace diagnostic_test {

using namespace binnacle;

namespace {

Diagnostic example() {
  return {Severity::error,
          "B012",
          {"file.json", 14, 9},
          "/filters/ins/process/bias/tua",
          "unknown key of 'gauss_markov'; did you mean 'tau' (s, > 0)?"};
}

}  // namespace

TEST_CASE("a diagnostic prints place, code, pointer and message", "[diagnostic]") {
  Diagnostic d = example();
  CHECK(to_string(d) ==
        "file.json:14:9: error[B012] /filters/ins/process/bias/tua: "
        "unknown key of 'gauss_markov'; did you mean 'tau' (s, > 0)?");
  d.message = "m";
  d.severity = Severity::warning;
  CHECK(to_string(d) == "file.json:14:9: warning[B012] /filters/ins/process/bias/tua: m");
  d.origin = {"--set", 0, 0};
  CHECK(to_string(d) == "--set: warning[B012] /filters/ins/process/bias/tua: m");
  d.origin = {};
  d.pointer.clear();
  CHECK(to_string(d) == "warning[B012]: m");
  d.code.clear();
  CHECK(to_string(d) == "warning: m");
  d.message = "two\nlines\x1b[31m";
  CHECK(to_string(d) == "warning: two\\nlines\\x1b[31m");
}

TEST_CASE("diagnostics drop duplicates and sort by place", "[diagnostic]") {
  Diagnostics all;
  all.error("B010", {"b.json", 2, 1}, "/x", "third");
  all.warning("B031", {"a.json", 10, 1}, "/x", "second");
  CHECK(all.items().size() == 2);
  Diagnostics more;
  more.error("B010", {"b.json", 2, 1}, "/x", "third");
  more.error("B010", {"a.json", 9, 5}, "/x", "first");
  all.merge(more);
  all.merge(all);
  CHECK(all.items().size() == 3);
  CHECK(all.text() ==
        "a.json:9:5: error[B010] /x: first\n"
        "a.json:10:1: warning[B031] /x: second\n"
        "b.json:2:1: error[B010] /x: third");
}

TEST_CASE("the time of many diagnostics grows with their number, not with its square", "[diagnostic]") {
  const auto seconds_for = [](int many) {
    double best = 1e9;
    for (int attempt = 0; attempt < 3; ++attempt) {
      const auto begin = std::chrono::steady_clock::now();
      Diagnostics all;
      for (int i = 0; i < many; ++i)
        for (int twice = 0; twice < 2; ++twice) all.error("B012", {"a.json", i, 1}, "/x", "unknown");
      all.merge(all);
      CHECK(all.items().size() == static_cast<std::size_t>(many));
      best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    return best;
  };
  // 8 by their number, 64 by its square; under any sanitizer.
  CHECK(seconds_for(16'000) < 24 * seconds_for(2000));
}

TEST_CASE("warnings are no errors", "[diagnostic]") {
  Diagnostics all;
  all.warning("B031", {}, "", "unused");
  CHECK_FALSE(all.has_errors());
  CHECK_FALSE(all.empty());
  all.add(example());
  CHECK(all.has_errors());
}

TEST_CASE("errors carry their diagnostics and exit status", "[diagnostic]") {
  CHECK(FilterError(example()).exit_status() == 1);
  CHECK(ConfigError(example()).exit_status() == 3);
  CHECK(LoadError(example()).exit_status() == 4);
  CHECK(DataError(example()).exit_status() == 5);
  const ConfigError error(example());
  CHECK(std::string(error.what()) == to_string(example()));
  CHECK(error.diagnostics().items().size() == 1);
}

TEST_CASE("the closest candidate is the one that was meant", "[diagnostic]") {
  const std::vector<std::string> keys{"type", "tau", "sigma", "gyro_bias", "accelerometer_bias", "position"};
  CHECK(closest("tua", keys) == "tau");
  CHECK(closest("Tau", keys) == "tau");
  CHECK(closest("sigm", keys) == "sigma");
  CHECK(closest("gyro", keys) == "gyro_bias");
  CHECK(closest("gyro-bias", keys) == "gyro_bias");
  CHECK(closest("acelerometer_bais", keys) == "accelerometer_bias");
  CHECK(closest("pos", keys) == "position");
  CHECK(closest("wavelength", keys).empty());
  CHECK(closest("x", keys).empty());
  CHECK(closest("", keys).empty());
  CHECK(closest("tau", {}).empty());
}

TEST_CASE("a transposition is nearer than another edit", "[diagnostic]") {
  CHECK(closest("tua", {"tub", "tau"}) == "tau");
  CHECK(closest("form", {"fork", "from"}) == "from");
}

}  // namespace diagnostic_test
