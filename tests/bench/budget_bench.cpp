// SPDX-License-Identifier: Apache-2.0
// What budget.py has counted by callgrind: `budget_bench step|update|push|csv COUNT` makes so many IMU steps of 21 states,
// updates by a position fix, samples on a channel that nobody takes, or lines of csv read. All of it lies in
// budget_work(), which callgrind collects.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include <unistd.h>

#include "binnacle/run.hpp"
#include "binnacle/session.hpp"
#include "ins_config.hpp"

using namespace binnacle;

extern "C" __attribute__((noinline)) void budget_work(const std::function<void()>& once, int count) {
  for (int i = 0; i < count; ++i) once();
}

namespace {

constexpr int warm_up = 200;

/// Of 21 states; `act` is measured after some steps.
template <class Act>
bool of_ins(int count, Act&& act) {
  Session session(Composition::parse(bench::ins_config(21), "budget.json"));
  const auto imu = session.channel("imu"), gnss = session.channel("gnss");
  constexpr Time interval = 5'000'000;
  const double increments[] = {1e-4, -2e-4, 5e-4, 0.002, 0.001, -0.04904};
  const double position[] = {0.8377580409572782, 0.19198621771937624, 500};
  Time t = 0;
  const auto step = [&] {
    session.push(imu, t, t + interval, increments);
    t += interval;
  };
  for (int i = 0; i < warm_up; ++i) step();
  act(
      step, [&] { session.push(gnss, no_time, t, position); }, count);
  return session.healthy(FilterId{0});
}

bool push(int count) {
  Session session(Composition::parse(bench::idle_config(), "budget.json"));
  const auto z = session.channel("z");
  const double one = 1;
  Time t = 0;
  budget_work([&] { session.push(z, no_time, ++t, {&one, 1}); }, count);
  return session.counts(z).pushed == count;
}

/// A whole run over a file: what a run costs beside its lines is in it, and small.
bool csv(int count) {
  const auto path = std::filesystem::temp_directory_path() / ("budget_" + std::to_string(::getpid()) + ".csv");
  std::ofstream file(path);
  file << "t,wx,wy,wz,fx,fy,fz\n";
  for (int i = 1; i <= count; ++i) {
    char line[160];
    std::snprintf(line, sizeof line, "%.3f,%.9e,%.9e,%.9e,%.9e,%.9e,%.9e\n", 0.005 * i, 1e-4 * i, -2e-4 / i, 5e-4, 2e-3,
                  1e-3 * i, -0.049 - 1e-9 * i);
    file << line;
  }
  file.close();
  const std::string kinds = R"({"unit": "rad/s", "kind": "rate"})", forces = R"({"unit": "m/s^2", "kind": "rate"})";
  const auto composition =
      Composition::parse(R"({"binnacle": 1, "sources": {"imu": {"type": "csv", "path": ")" + path.string() +
                             R"(", "columns": {"wx": )" + kinds + R"(, "wy": )" + kinds + R"(, "wz": )" + kinds +
                             R"(, "fx": )" + forces + R"(, "fy": )" + forces + R"(, "fz": )" + forces + "}}}, " +
                             bench::idle_filter + "}",
                         "budget.json");
  budget_work([&] { run(composition); }, 1);  // throws where the data are unusable; the idle filter never starts
  std::filesystem::remove(path);
  return true;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string what = argc == 3 ? argv[1] : "";
  const int count = argc == 3 ? std::atoi(argv[2]) : 0;
  bool is_well = false;
  if (what == "step")
    is_well = of_ins(count, [](auto& step, auto&&, int n) { budget_work(step, n); });
  else if (what == "update")
    is_well = of_ins(count, [](auto&, auto&& update, int n) { budget_work(update, n); });
  else if (what == "push")
    is_well = push(count);
  else if (what == "csv")
    is_well = csv(count);
  else {
    std::fprintf(stderr, "usage: budget_bench step|update|push|csv COUNT\n");
    return 2;
  }
  return is_well ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "budget_bench: %s\n", error.what());
  return 1;
}
