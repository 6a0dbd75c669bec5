// SPDX-License-Identifier: Apache-2.0
// When a composed filter does what: samples that wait, split and overtake, groups of samples, holes, snapshots.
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "binnacle/eigen.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace instants_test {

using namespace binnacle;
using filter_tests::line;
using filter_tests::session_of;

namespace {

const std::string ins = R"({"binnacle": 1,
  "sources": {
    "imu": {"type": "pushed", "fields": {
      "wx": {"unit": "rad/s", "kind": "rate"}, "wy": {"unit": "rad/s", "kind": "rate"}, "wz": {"unit": "rad/s", "kind": "rate"},
      "fx": {"unit": "m/s^2", "kind": "rate"}, "fy": {"unit": "m/s^2", "kind": "rate"}, "fz": {"unit": "m/s^2", "kind": "rate"}}},
    "gnss": {"type": "pushed", "fields": {"lat": {"unit": "rad"}, "lon": {"unit": "rad"}, "height": {"unit": "m"}}}},
  "filters": {"ins": {
    "blocks": {
      "position": {"type": "position", "init": {"lat": "48 deg", "lon": "11 deg", "height": 500}, "sigma": "5 m"},
      "velocity": {"type": "velocity", "init": {"vn": 3, "ve": 4, "vd": 0}, "sigma": "0.5 m/s"},
      "attitude": {"type": "attitude", "init": {"roll": 0.1, "pitch": 0.05, "yaw": 0.5}, "sigma": "1 deg"},
      "gyro_bias": {"type": "vector", "size": 3, "unit": "rad/s", "sigma": "100 deg/h"},
      "accel_bias": {"type": "vector", "size": 3, "unit": "m/s^2", "sigma": "1 mg"}},
    "derived": {"antenna": {"type": "lever_arm", "blocks": {"position": "position", "attitude": "attitude"},
                            "lever_arm": ["1 m", "0.2 m", "-1.5 m"]}},
    "process": {
      "strapdown": {"type": "phi_error", "input": "imu",
        "blocks": {"position": "position", "velocity": "velocity", "attitude": "attitude",
                   "gyro_bias": "gyro_bias", "accel_bias": "accel_bias"},
        "gyro_noise": 2.9e-5, "accel_noise": 5e-4},
      "bg": {"type": "gauss_markov", "blocks": {"x": "gyro_bias"}, "tau": "1 h", "sigma": "100 deg/h"},
      "ba": {"type": "gauss_markov", "blocks": {"x": "accel_bias"}, "tau": "1 h", "sigma": "1 mg"}},
    "measurements": {"fix": {"type": "position_fix", "channel": "gnss", "blocks": {"position": "antenna"},
                             "sigma": "2 m"}}}}})";

struct InsDrive {
  explicit InsDrive(Session& f) : filter(f), imu(f.channel("imu")), gnss(f.channel("gnss")) {}
  void input(Time t0, Time t1) {
    const double s = seconds(t1);
    const double fields[] = {0.05 * std::sin(s), 0.02, 0.1 * std::cos(0.3 * s), 0.5, 1 + 0.2 * std::sin(2 * s), -9.8};
    filter.push(imu, t0, t1, fields);
  }
  void fix(Time t) {
    const double fields[] = {0.8377580409572782 + 1e-8 * seconds(t), 0.19198621771937624, 500};
    filter.push(gnss, no_time, t, fields);
  }
  Session& filter;
  ChannelId imu, gnss;
};

std::vector<std::byte> bytes_of(const Session& filter) {
  std::vector<std::byte> bytes(filter.snapshot_size());
  filter.snapshot(bytes);
  return bytes;
}

constexpr Time ms = 1'000'000;

}  // namespace

TEST_CASE("a measurement ahead of the input waits and splits the sample it falls into") {
  Session ahead = session_of(ins), split = session_of(ins);
  InsDrive a(ahead), b(split);
  for (int i = 0; i < 10; ++i) {
    a.input(i * 10 * ms, (i + 1) * 10 * ms);
    b.input(i * 10 * ms, (i + 1) * 10 * ms);
  }
  a.fix(104 * ms);  // not yet covered by input
  REQUIRE(ahead.counts({{0}, 0}).by_outcome[0] == 0);
  a.input(100 * ms, 110 * ms);
  REQUIRE(ahead.counts({{0}, 0}).by_outcome[0] == 1);
  REQUIRE(ahead.time(FilterId{0}) == 110 * ms);

  // The same with the sample cut by hand: equal rates over both pieces.
  const double s = seconds(110 * ms);
  const double fields[] = {0.05 * std::sin(s), 0.02, 0.1 * std::cos(0.3 * s), 0.5, 1 + 0.2 * std::sin(2 * s), -9.8};
  split.push(b.imu, 100 * ms, 104 * ms, fields);
  b.fix(104 * ms);
  split.push(b.imu, 104 * ms, 110 * ms, fields);
  REQUIRE((ahead.covariance(FilterId{0}).as() - split.covariance(FilterId{0}).as()).norm() <
          1e-6 * split.covariance(FilterId{0}).as().norm());
  double pa[3], pb[3];
  ahead.read(ahead.block("position"), pa);
  split.read(split.block("position"), pb);
  REQUIRE(std::abs(pa[2] - pb[2]) < 1e-6);
  REQUIRE(std::abs(pa[0] - pb[0]) < 1e-12);
}

TEST_CASE("the queue of samples ahead of the input is bounded, and the overflow is reported") {
  Session filter = session_of(ins);
  InsDrive drive(filter);
  drive.input(0, 10 * ms);
  for (int i = 0; i < 70; ++i) drive.fix((20 + i) * ms);
  REQUIRE(filter.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::rejected)] == 6);
  REQUIRE(filter.counts({{0}, 0}).last_reason == "the queue of samples ahead of the input is full");
}

TEST_CASE("samples of one instant may come in any order") {
  Session first = session_of(ins), last = session_of(ins);
  InsDrive a(first), b(last);
  for (int i = 0; i < 100; ++i) {
    a.input(i * 10 * ms, (i + 1) * 10 * ms);
    if (i % 10 == 9) a.fix((i + 1) * 10 * ms);
    if (i % 10 == 9) b.fix((i + 1) * 10 * ms);
    b.input(i * 10 * ms, (i + 1) * 10 * ms);
  }
  REQUIRE(first.counts({{0}, 0}).by_outcome[0] == 10);
  REQUIRE(last.counts({{0}, 0}).by_outcome[0] == 10);
  REQUIRE((first.covariance(FilterId{0}).as().array() == last.covariance(FilterId{0}).as().array()).all());
  REQUIRE(std::memcmp(first.state(FilterId{0}).data(), last.state(FilterId{0}).data(),
                      first.state(FilterId{0}).size_bytes()) == 0);
}

TEST_CASE("restored and continued equals uninterrupted, bit for bit") {
  auto run = [](Session& filter, int from, int to) {
    InsDrive drive(filter);
    for (int i = from; i < to; ++i) {
      drive.input(i * 10 * ms, (i + 1) * 10 * ms);
      if (i % 7 == 3) drive.fix((i + 1) * 10 * ms + 13 * ms);  // one always waits in the queue
    }
  };
  Session whole = session_of(ins);
  run(whole, 0, 300);
  Session first = session_of(ins);
  run(first, 0, 137);
  const auto saved = bytes_of(first);
  Session second = session_of(ins);
  run(second, 0, 20);  // another past, to be forgotten
  second.restore(saved);
  run(second, 137, 300);
  REQUIRE(bytes_of(whole) == bytes_of(second));

  SECTION("bytes of another composition are refused and nothing changes") {
    Session other = session_of(line());
    auto before = bytes_of(second);
    auto foreign = bytes_of(other);
    REQUIRE_THROWS_AS(second.restore(foreign), ConfigError);
    foreign = saved;
    foreign.pop_back();
    REQUIRE_THROWS_AS(second.restore(foreign), ConfigError);
    REQUIRE_THROWS_AS(second.restore(std::vector<std::byte>(10)), ConfigError);
    REQUIRE(bytes_of(second) == before);
  }
}

TEST_CASE("several input samples in a step: the measurement inside a group closes it") {
  const auto grouped = [](int samples) {
    std::string text = ins;
    const std::string key = R"("input": "imu",)";
    text.insert(text.find(key) + key.size(), " \"samples_per_step\": " + std::to_string(samples) + ",");
    return session_of(text);
  };
  Session one = grouped(1), four = grouped(4);
  InsDrive a(one), b(four);
  for (InsDrive* drive : {&a, &b})
    for (int i = 0; i < 200; ++i) {
      drive->input(i * 5 * ms, (i + 1) * 5 * ms);
      if (i % 25 == 11) drive->fix((i + 1) * 5 * ms);  // on a sample's end, inside a group
      if (i % 25 == 20)
        drive->fix((i + 1) * 5 * ms - 2 * ms);  // inside the sample just taken: late for one, not for four
    }
  REQUIRE(one.time(FilterId{0}) == 1000 * ms);
  // Up to three whole samples wait for their group.
  REQUIRE(four.time(FilterId{0}) <= 1000 * ms);
  REQUIRE(four.time(FilterId{0}) > 980 * ms);
  REQUIRE(one.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::late)] == 8);
  REQUIRE(four.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::late)] < 8);
  double pa[3], pb[3];
  one.read(one.block("attitude"), pa);
  four.read(four.block("attitude"), pb);
  for (int i = 0; i < 3; ++i) REQUIRE(std::abs(pa[i] - pb[i]) < 1e-2);
}

TEST_CASE("a hole in the input is bridged with the rates held, and counted") {
  Session filter = session_of(ins);
  InsDrive drive(filter);
  for (int i = 0; i < 10; ++i) drive.input(i * 10 * ms, (i + 1) * 10 * ms);
  drive.input(150 * ms, 160 * ms);
  REQUIRE(filter.time(FilterId{0}) == 160 * ms);
  REQUIRE(filter.healthy(FilterId{0}));
}

namespace {

/// `ins` with groups of `samples` for the attitude, from rates or from increments.
Session in_groups(int samples, bool of_increments) {
  std::string text = ins;
  const std::string key = R"("input": "imu",)";
  const std::string n = std::to_string(samples);
  text.insert(text.find(key) + key.size(), " \"samples_per_step\": " + n + ", \"attitude\": {\"samples\": " + n + "},");
  const auto replace_all = [&](const std::string& from, const std::string& to) {
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
  };
  if (of_increments) {
    replace_all(R"("unit": "rad/s", "kind": "rate")", R"("unit": "rad", "kind": "increment")");
    replace_all(R"("unit": "m/s^2", "kind": "rate")", R"("unit": "m/s", "kind": "increment")");
  }
  return session_of(text);
}

/// A noisy swing at 100 Hz with samples from `first_lost` to `last_lost` missing.
void swing(Session& filter, int count, int first_lost, int last_lost, bool of_increments) {
  std::mt19937 engine(7);
  std::normal_distribution<double> normal;
  const auto imu = filter.channel("imu");
  for (int i = 0; i < count; ++i) {
    const double t = 0.01 * i, scale = of_increments ? 0.01 : 1.0;
    double fields[6] = {0.3 * std::sin(2 * t) + 0.002 * normal(engine),
                        0.2 * std::cos(3 * t) + 0.002 * normal(engine),
                        0.1 + 0.002 * normal(engine),
                        0.05 * normal(engine),
                        0.05 * normal(engine),
                        -9.8 + 0.05 * normal(engine)};
    for (double& field : fields) field *= scale;
    if (i < first_lost || i > last_lost) filter.push(imu, i * 10 * ms, (i + 1) * 10 * ms, fields);
  }
}

}  // namespace

TEST_CASE("a hole in the input is bridged alone, wherever in a group of samples it falls") {
  for (const bool of_increments : {false, true})
    for (int place = 0; place < 4; ++place) {
      CAPTURE(of_increments, place);
      Session one = in_groups(1, of_increments), four = in_groups(4, of_increments);
      // 1000 samples less the lost ones are no multiple of four plus `place`: both end at the same time.
      for (Session* filter : {&one, &four}) swing(*filter, 1000, 500 + place, 559 + place, of_increments);
      REQUIRE(four.healthy(FilterId{0}));
      REQUIRE(one.time(FilterId{0}) - four.time(FilterId{0}) <= 30 * ms);
      double a[3], b[3], u[3], v[3];
      one.read(one.block("attitude"), a);
      four.read(four.block("attitude"), b);
      one.read(one.block("velocity"), u);
      four.read(four.block("velocity"), v);
      // At most three samples wait for their group: 0.3 rad/s and 0.1 m/s^2 of noise for 30 ms, and no more.
      for (int i = 0; i < 3; ++i) REQUIRE(std::abs(a[i] - b[i]) < 0.012);
      for (int i = 0; i < 3; ++i) REQUIRE(std::abs(u[i] - v[i]) < 0.12);
    }
}

TEST_CASE("a hole inside the first group of increments is bridged by what came before it") {
  for (const int samples : {1, 4}) {
    CAPTURE(samples);
    Session filter = in_groups(samples, true);
    swing(filter, 100, 3, 9, true);
    REQUIRE(filter.healthy(FilterId{0}));
    REQUIRE(filter.time(FilterId{0}) >= 960 * ms);
  }
}

}  // namespace instants_test
