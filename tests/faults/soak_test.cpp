// SPDX-License-Identifier: Apache-2.0
// A soak, and the extremes of numbers. `BINNACLE_SOAK_STEPS=10000000 fault_tests "a soak*"` makes it as long as one likes; its
// table goes to stdout, and so does that of "P0 over R*".
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <random>
#include <string>

#include <unistd.h>

#include "binnacle/session.hpp"
#include "catch.hpp"

namespace soak_test {

using namespace binnacle;

namespace {

const char* const verdict_names[] = {"ok", "doubtful", "lost"};
constexpr Time step = 1'000'000;  // 1 ms
const char* const forms[] = {"joseph", "ud", "square_root"};

/// 10^5 in a test.
long steps() {
  const char* const text = std::getenv("BINNACLE_SOAK_STEPS");
  return text ? std::atol(text) : 100'000;
}

Session session_of(const std::string& config) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  return Session(Composition::parse(config, "soak.json"));
}

/// A place that is seen, its velocity, which wanders, and a constant that is seen with far more noise.
std::string soak_config(const std::string& form) {
  return R"({"binnacle": 1,
    "sources": {"place": {"type": "pushed", "fields": {"z0": {"unit": "m"}}},
                "level": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "covariance": ")" +
         form + R"(", "trust": {"false_alarm": 1e-9},
      "blocks": {"p": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1},
                 "v": {"type": "vector", "size": 1, "unit": "m/s", "init": 0, "sigma": 1},
                 "c": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 10}},
      "process": {"move": {"type": "integrated", "blocks": {"x": "p", "rate": "v"}},
                  "wander": {"type": "random_walk", "blocks": {"x": "v"}, "q": 0.1},
                  "stay": {"type": "random_constant", "blocks": {"x": "c"}}},
      "measurements": {
        "place": {"type": "linear_measurement", "channel": "place", "blocks": {"x": "p"}, "sigma": [0.1]},
        "level": {"type": "linear_measurement", "channel": "level", "blocks": {"x": "c"}, "sigma": [1000]}}}}})";
}

/// Samples of a truth that moves as the filter's models say.
class Truth {
 public:
  void push(Session& session, ChannelId place, ChannelId level, Time t) {
    constexpr double dt = 1e-3;
    p_ += v_ * dt;
    v_ += 0.1 * std::sqrt(dt) * normal_(random_);
    const std::array<double, 1> seen{p_ + 0.1 * normal_(random_)}, constant{5 + 1000 * normal_(random_)};
    session.push(place, no_time, t, seen);
    session.push(level, no_time, t, constant);
  }

 private:
  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
  double p_ = 0, v_ = 0;
};

double resident_mib() {
  std::ifstream file("/proc/self/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

/// Of the processor: what else the machine does, or that all was stopped for a while, is no matter.
double seconds_of_processor() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double asymmetry(const ConstMatrixView& P) {
  double most = 0;
  for (int i = 0; i < P.rows; ++i)
    for (int j = 0; j < P.cols; ++j) {
      if (!std::isfinite(P(i, j))) return std::nan("");
      most = std::max(most, std::abs(P(i, j) - P(j, i)));
    }
  return most;
}

struct Part {
  double ns_per_step = 0, mib = 0;
};

Part soak_part(Session& session, Truth& truth, long first, long count) {
  const ChannelId place = session.channel("place"), level = session.channel("level");
  const double begin = seconds_of_processor();
  for (long k = first; k < first + count; ++k) truth.push(session, place, level, k * step);
  return {1e9 * (seconds_of_processor() - begin) / static_cast<double>(count), resident_mib()};
}

}  // namespace

TEST_CASE("a soak drifts in neither time, memory, symmetry nor sigma") {
  const long part = std::max(1000L, steps() / 10);
  std::printf("%-12s %10s %12s %12s %14s %10s %s\n", "covariance", "steps", "ns a step", "MiB", "P - P'", "sigma c",
              "verdict");
  for (const char* form : forms) {
    INFO(form);
    Session session = session_of(soak_config(form));
    const FilterId filter = session.filter("f");
    Truth truth;
    Part first, now;
    for (int k = 0; k < 10; ++k) {
      now = soak_part(session, truth, k * part, part);
      if (k == 0) first = now;
      const double crooked = asymmetry(session.covariance(filter)),
                   sigma = std::sqrt(session.covariance(session.block("f/c"))(0, 0));
      std::printf("%-12s %10ld %12.0f %12.1f %14.1e %10.6f %s\n", form, (k + 1) * part, now.ns_per_step, now.mib,
                  crooked, sigma, verdict_names[static_cast<int>(session.verdict(filter))]);
      CHECK(crooked == 0);
      const double expected = 1 / std::sqrt(1.0 / 100 + static_cast<double>((k + 1) * part) / 1e6);
      CHECK(std::abs(sigma / expected - 1) < 1e-9);
      CHECK(session.healthy(filter));
      CHECK(session.verdict(filter) == Verdict::ok);
    }
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    CHECK(now.mib < first.mib + 1);  // they keep what was freed
#endif
    CHECK(now.ns_per_step < 3 * first.ns_per_step);
    double estimate = 0;
    session.read(session.block("f/c"), {&estimate, 1});
    CHECK(std::abs(estimate - 5) < 5 * std::sqrt(session.covariance(session.block("f/c"))(0, 0)));
  }
}

// ---- the extremes

namespace {

constexpr double noise = 1e-3;  // sigma of each row

/// Of one constant, or of two of which the sum and the second are seen.
std::string extreme_config(const std::string& form, int size, double sigma) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", sigma);
  const std::string rows = size == 1 ? R"("sigma": [1e-3])" : R"("H": [[1, 1], [0, 1]], "sigma": [1e-3, 1e-3])";
  const std::string fields = size == 1 ? R"("z0": {"unit": "m"})" : R"("z0": {"unit": "m"}, "z1": {"unit": "m"})";
  return R"({"binnacle": 1, "sources": {"z": {"type": "pushed", "fields": {)" + fields + R"(}}},
    "filters": {"f": {"covariance": ")" +
         form + R"(",
      "blocks": {"x": {"type": "vector", "size": )" +
         std::to_string(size) + R"(, "unit": "m", "init": 0, "sigma": )" + text + R"(}},
      "process": {"stay": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"z": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, )" +
         rows + R"(}}}}})";
}

/// Sigma of the first constant after so many samples; the information of the prior is i, of a sample of a row w.
double closed_form(int size, double P0, int samples) {
  const double i = 1 / P0, w = samples / (noise * noise);
  return std::sqrt(size == 1 ? 1 / (i + w) : (i + 2 * w) / (w * w + 3 * i * w + i * i));
}

struct End {
  double error = 0;  // of a sigma, relative
  bool is_healthy = false, is_said = false;
};

End extreme_end(const std::string& form, int size, double ratio) {
  constexpr int samples = 50;
  const double P0 = ratio * noise * noise;
  Session session = session_of(extreme_config(form, size, std::sqrt(P0)));
  const FilterId filter = session.filter("f");
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < samples; ++k) {
    const std::array<double, 2> z{3 + noise * normal(random), 1 + noise * normal(random)};
    session.push(session.channel("z"), no_time, k * 1000 * step, std::span(z).first(static_cast<std::size_t>(size)));
  }
  End end;
  const double variance = session.covariance(session.block("f/x"))(0, 0);
  end.error = std::abs(std::sqrt(variance) / closed_form(size, P0, samples) - 1);
  end.is_healthy = session.healthy(filter);
  const Diagnostics doubts = session.doubts(filter);
  for (const auto& doubt : doubts.items())
    end.is_said = end.is_said || doubt.code == "B126" || doubt.code == "B127" || doubt.code == "B110";
  return end;
}

}  // namespace

TEST_CASE("P0 over R from 1 to 1e30: a sigma is right, or the filter says that it is not") {
  std::printf("%-10s %6s %22s %22s %22s\n", "constants", "P0/R", forms[0], forms[1], forms[2]);
  for (const int size : {1, 2})
    for (int power = 0; power <= 30; power += 2) {
      std::printf("%-10d   1e%02d", size, power);
      for (const std::string form : forms) {
        const End end = extreme_end(form, size, std::pow(10.0, power));
        const bool is_right = end.error < 1e-3;
        std::printf(" %12.1e %9s", end.error, !end.is_healthy ? "stopped" : end.is_said ? "doubtful" : "ok");
        INFO(form << ", " << size << " constants, P0/R 1e" << power << ", error " << end.error);
        CHECK((is_right || end.is_said || !end.is_healthy));
        if (form != "joseph" || power <= 8) CHECK((end.error < 1e-6 && end.is_healthy));
      }
      std::printf("\n");
    }
}

}  // namespace soak_test
