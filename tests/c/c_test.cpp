// SPDX-License-Identifier: Apache-2.0
// The C interface against Session: the same bits; nothing is allocated; what is refused; what there is in a composition.
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include <binnacle.h>

#include <nlohmann/json.hpp>

#include "allocations.hpp"
#include "binnacle/session.hpp"
#include "binnacle/state_block.hpp"
#include "binnacle/version.hpp"
#include "catch.hpp"
#include "drive.h"
#include "score/sections.hpp"
#include "skip.hpp"

namespace c_test {

using namespace binnacle;

namespace {

const char* const config = BINNACLE_TEST_PROJECT "/tests/c/drive.json";

std::shared_ptr<const Composition> composition_in_cpp() {
  LoadOptions options;
  options.vars["sigma"] = "3 m";
  options.sets = {"/plugins=[]", std::string("/plugins/-=") + PROBE_PLUGIN};
  return score::load(config, options);
}

SampleView sample_at(Time t, const double* fields) { return {.t = t, .fields = fields, .available = true}; }

/// What drive_steps() pushes, in C++.
void push_steps(Session& session, int first, int last) {
  const auto imu = session.channel("imu"), gnss = session.channel("gnss"), gps = session.channel("gps"),
             ranges = session.channel("ranges"), pulse = session.channel("pulse");
  for (int k = first + 1; k <= last; ++k) {
    const Time t = k * DRIVE_STEP_NS;
    double w_f[6], fix[3], z[6], covariance[36], rows[6][4];
    drive_imu(k, w_f);
    if (k % 20 == 0) {
      SampleView input = sample_at(t, w_f);
      input.t0 = t - DRIVE_STEP_NS;
      session.add(imu, input);
      drive_fix(k, fix);
      session.add(gnss, sample_at(t, fix));
      session.commit(t);
    } else {
      session.push(imu, t - DRIVE_STEP_NS, t, w_f);
    }
    if (k % 50 == 0) {
      drive_gps(k, z, covariance);
      SampleView sample = sample_at(t + 4'000'000, z);
      sample.covariance = covariance;
      session.push(gps, sample);
    }
    if (k % 30 == 0) {
      drive_rows(k, rows);
      SampleView sample = sample_at(t, nullptr);
      sample.rows = 6;
      sample.row_fields = &rows[0][0];
      session.push(ranges, sample);
    }
    if (k % 100 == 0) {
      const double pulse_z[] = {0.5};
      session.push(pulse, no_time, t, pulse_z);
    }
  }
}

void append(std::vector<double>& numbers, ConstMatrixView P) {
  for (int column = 0; column < P.cols; ++column)
    for (int row = 0; row < P.rows; ++row) numbers.push_back(P(row, column));
}

/// What drive_read() reads, in C++.
void read(const Session& session, std::vector<double>& numbers) {
  const auto& filters = session.composition().filters();
  for (int f = 0; f < static_cast<int>(filters.size()); ++f) {
    const FilterId filter{f};
    const auto state = session.state(filter);
    numbers.insert(numbers.end(), state.begin(), state.end());
    append(numbers, session.covariance(filter));
    numbers.push_back(static_cast<double>(session.time(filter)));
    numbers.push_back(session.healthy(filter));
    numbers.push_back(session.started(filter));
    numbers.push_back(static_cast<double>(session.verdict(filter)));
    const auto& blocks = filters[static_cast<std::size_t>(f)].blocks;
    for (int b = 0; b < static_cast<int>(blocks.size()); ++b) {
      std::vector<double> outputs(blocks[static_cast<std::size_t>(b)].declaration->outputs.size());
      session.read({filter, b}, outputs);
      numbers.insert(numbers.end(), outputs.begin(), outputs.end());
      session.read_sigma({filter, b}, outputs);
      numbers.insert(numbers.end(), outputs.begin(), outputs.end());
      append(numbers, session.covariance(BlockId{filter, b}));
    }
  }
}

/// Closes what it holds.
struct InC {
  binnacle_composition* composition = nullptr;
  binnacle_session* session = nullptr;
  InC() {
    REQUIRE(drive_load(config, PROBE_PLUGIN, &composition) == 0);
    REQUIRE(binnacle_open(composition, 3, 4, &session) == BINNACLE_OK);
  }
  InC(const InC&) = delete;
  InC& operator=(const InC&) = delete;
  ~InC() {
    binnacle_close(session);
    binnacle_release(composition);
  }
  binnacle_id filter(const char* name) const {
    binnacle_id id = 0;
    REQUIRE(binnacle_find_filter(session, name, &id) == BINNACLE_OK);
    return id;
  }
};

drive_log drive_log_of_c;

}  // namespace

TEST_CASE("a drive in C gives the bits of Session") {
  drive_log_of_c.count = 0;
  REQUIRE(drive(config, PROBE_PLUGIN, &drive_log_of_c) == 0);
  Session session(composition_in_cpp(), 3, 4);
  std::vector<double> expected;
  for (int second = 0; second < DRIVE_STEPS / 100; ++second) {
    push_steps(session, 100 * second, 100 * (second + 1));
    read(session, expected);
  }
  REQUIRE(static_cast<std::size_t>(drive_log_of_c.count) == expected.size());
  REQUIRE(expected.size() > 5000);
  CHECK(std::memcmp(drive_log_of_c.numbers, expected.data(), expected.size() * sizeof(double)) == 0);
  // The drive has something of everything.
  CHECK(session.verdict({0}) == Verdict::lost);
  CHECK_FALSE(session.healthy({2}));
  CHECK(session.counts(MeasurementId{{1}, 0}).rows_left_out > 0);
  CHECK(session.counts(session.measurement("ins/pv")).by_outcome[static_cast<int>(Outcome::accepted)] > 20);
}

TEST_CASE("a snapshot that is restored in C goes on bit for bit") { CHECK(drive_restored(config, PROBE_PLUGIN) == 0); }

TEST_CASE("what is wrong in a call from C is refused, with its status and message, and changes nothing") {
  CHECK(drive_refusals(config, PROBE_PLUGIN) == 0);
}

TEST_CASE("a snapshot of a session in C is that of the same Session") {
  const InC in;
  REQUIRE(drive_steps(in.session, 0, 730) == 0);
  Session session(composition_in_cpp(), 3, 4);
  std::vector<std::byte> bytes(session.snapshot_size());
  std::uint64_t size = 0;
  REQUIRE(binnacle_snapshot_size(in.session, &size) == BINNACLE_OK);
  REQUIRE(size == bytes.size());
  REQUIRE(binnacle_snapshot(in.session, bytes.data(), size) == BINNACLE_OK);
  session.restore(bytes);
  push_steps(session, 730, 1500);
  REQUIRE(drive_steps(in.session, 730, 1500) == 0);
  std::vector<double> expected;
  read(session, expected);
  drive_log_of_c.count = 0;
  REQUIRE(drive_read(in.composition, in.session, &drive_log_of_c) == 0);
  REQUIRE(static_cast<std::size_t>(drive_log_of_c.count) == expected.size());
  CHECK(std::memcmp(drive_log_of_c.numbers, expected.data(), expected.size() * sizeof(double)) == 0);
}

TEST_CASE("texts and counts in C are those of Session") {
  const InC in;
  Session session(composition_in_cpp(), 3, 4);
  REQUIRE(drive_steps(in.session, 0, DRIVE_STEPS) == 0);
  push_steps(session, 0, DRIVE_STEPS);
  const char* text = nullptr;
  REQUIRE(binnacle_diagnosis(in.session, in.filter("brittle"), &text) == BINNACLE_OK);
  CHECK(std::string(text) == session.diagnosis({2}));
  CHECK_FALSE(std::string(text).empty());
  REQUIRE(binnacle_diagnosis(in.session, in.filter("ins"), &text) == BINNACLE_OK);
  CHECK(std::string(text).empty());
  REQUIRE(binnacle_reasons(in.session, in.filter("ins"), &text) == BINNACLE_OK);
  CHECK(std::string(text) == session.doubts({0}).text());
  CHECK(std::string(text).find("drive.json:") != std::string::npos);
  REQUIRE(binnacle_reasons_json(in.session, in.filter("ins"), &text) == BINNACLE_OK);
  const auto reasons = nlohmann::json::parse(text);
  REQUIRE(reasons.size() == session.doubts({0}).items().size());
  CHECK(reasons[0]["message"] == session.doubts({0}).sorted()[0].message);
  CHECK(reasons[0]["code"].get<std::string>().rfind("B1", 0) == 0);
  for (const char* name : {"ins/fix", "ins/pv", "rows/see", "brittle/see"}) {
    INFO(name);
    binnacle_id measurement = 0;
    binnacle_counts counts{};
    counts.size = sizeof counts;
    const auto expected = session.counts(session.measurement(name));
    const auto of = [&](Outcome outcome) { return expected.by_outcome[static_cast<int>(outcome)]; };
    REQUIRE(binnacle_find_measurement(in.session, name, &measurement) == BINNACLE_OK);
    REQUIRE(binnacle_count_samples(in.session, measurement, &counts) == BINNACLE_OK);
    CHECK(counts.size == sizeof counts);
    CHECK(std::vector<std::int64_t>{counts.offered, counts.accepted, counts.gated, counts.late, counts.unsupported,
                                    counts.invalid, counts.withheld, counts.rejected, counts.before_start,
                                    counts.recoveries, counts.rows_used, counts.rows_left_out} ==
          std::vector<std::int64_t>{expected.offered, of(Outcome::accepted), of(Outcome::gated), of(Outcome::late),
                                    of(Outcome::unsupported), of(Outcome::invalid), of(Outcome::withheld),
                                    of(Outcome::rejected), expected.before_start, expected.recoveries,
                                    expected.rows_used, expected.rows_left_out});
    CHECK(counts.nis_mean == expected.nis_mean);
    CHECK(counts.dof_mean == expected.dof_mean);
    REQUIRE(binnacle_last_reason(in.session, measurement, &text) == BINNACLE_OK);
    CHECK(std::string(text) == expected.last_reason);
  }
  std::int64_t start = 0;
  REQUIRE(binnacle_read_start_time(in.session, in.filter("ins"), &start) == BINNACLE_OK);
  CHECK(start == session.start_time({0}));
}

TEST_CASE("pushing and reading in C allocate nothing") {
  if (!conform::allocations_are_counted()) return test::skip("with this C library allocations can not be counted");
  const InC in;
  drive_channels to{};
  REQUIRE(drive_channels_of(in.session, &to) == 0);
  REQUIRE(drive_push(in.session, &to, 0, 100) == 0);
  drive_log_of_c.count = 0;
  const auto before = conform::allocations();
  const int failed = drive_push(in.session, &to, 100, 1100) + drive_read(in.composition, in.session, &drive_log_of_c);
  const auto after = conform::allocations();
  CHECK(failed == 0);
  CHECK(after == before);
  CHECK(drive_steps(in.session, 1100, 1101) == 0);
  CHECK(conform::allocations() > after);  // a look-up does, and is counted
}

TEST_CASE("what there is in a composition, in C") {
  const InC in;
  const auto composition = composition_in_cpp();
  std::uint64_t count = 0;
  REQUIRE(binnacle_channel_count(in.composition, &count) == BINNACLE_OK);
  REQUIRE(count == composition->channels().size());
  for (std::size_t i = 0; i < count; ++i) {
    const ChannelInfo& expected = composition->channels()[i];
    INFO(expected.name);
    binnacle_id channel = 0;
    binnacle_channel_info info{};
    info.size = sizeof info;
    REQUIRE(binnacle_channel_at(in.composition, i, &channel) == BINNACLE_OK);
    REQUIRE(binnacle_describe_channel(in.composition, channel, &info) == BINNACLE_OK);
    CHECK(info.name == expected.name);
    CHECK(info.max_rows == static_cast<std::uint64_t>(expected.declaration->max_rows));
    CHECK(info.covariance_rows == expected.declaration->covariance.size());
    REQUIRE(info.fields + info.row_fields == expected.declaration->fields.size());
    for (std::size_t f = 0; f < expected.declaration->fields.size(); ++f) {
      const FieldSpec& field = expected.declaration->fields[f];
      const char *name = nullptr, *unit = nullptr;
      binnacle_kind kind = -1;
      const auto at = static_cast<std::uint64_t>(expected.position[f]);
      const auto of = field.is_per_row ? binnacle_row_field : binnacle_field;
      REQUIRE(of(in.composition, channel, at, &name, &unit, &kind) == BINNACLE_OK);
      CHECK(name == field.name);
      CHECK(unit == field.unit);
      CHECK(kind == static_cast<int>(field.kind));
    }
  }
  binnacle_id gps = 0;
  const char *name = nullptr, *unit = nullptr;
  REQUIRE(binnacle_find_channel(in.session, "gps", &gps) == BINNACLE_OK);
  REQUIRE(binnacle_covariance_row(in.composition, gps, 5, &name, &unit) == BINNACLE_OK);
  CHECK(std::string(name) == "velocity.z");
}

TEST_CASE("what there is in a filter, in C") {
  const InC in;
  const auto composition = composition_in_cpp();
  const FilterInfo& ins = composition->filters()[0];
  binnacle_filter_info info{};
  info.size = sizeof info;
  REQUIRE(binnacle_describe_filter(in.composition, in.filter("ins"), &info) == BINNACLE_OK);
  CHECK(std::string(info.name) == "ins");
  CHECK(info.rows == static_cast<std::uint64_t>(ins.dof));
  CHECK(info.state_size == static_cast<std::uint64_t>(ins.stored_size));
  CHECK(info.measurements == 2);
  binnacle_id imu = 0, gyro_bias = 0, fix = 0, gnss = 0;
  REQUIRE(binnacle_find_channel(in.session, "imu", &imu) == BINNACLE_OK);
  REQUIRE(binnacle_find_channel(in.session, "gnss", &gnss) == BINNACLE_OK);
  CHECK(info.input == imu);
  REQUIRE(binnacle_find_block(in.session, "ins/gyro_bias", &gyro_bias) == BINNACLE_OK);
  binnacle_block_info block{};
  block.size = sizeof block;
  REQUIRE(binnacle_describe_block(in.composition, gyro_bias, &block) == BINNACLE_OK);
  CHECK(std::string(block.type) == ins.blocks[3].type);
  CHECK(block.rows == 2);  // z is frozen
  CHECK(block.outputs == 3);
  CHECK(block.first_row == static_cast<std::uint64_t>(ins.blocks[3].first_row));
  CHECK(block.state_offset == static_cast<std::uint64_t>(ins.blocks[3].stored_offset));
  const char *name = nullptr, *unit = nullptr;
  REQUIRE(binnacle_row(in.composition, gyro_bias, 1, &name, &unit) == BINNACLE_OK);
  CHECK(std::string(name) == "y");
  CHECK(std::string(unit) == "rad/s");
  CHECK(binnacle_row(in.composition, gyro_bias, 2, &name, &unit) == BINNACLE_USAGE);
  REQUIRE(binnacle_output(in.composition, gyro_bias, 2, &name, &unit) == BINNACLE_OK);
  CHECK(std::string(name) == "z");
  REQUIRE(binnacle_measurement_at(in.composition, in.filter("ins"), 0, &fix) == BINNACLE_OK);
  binnacle_measurement_info measurement{};
  measurement.size = sizeof measurement;
  REQUIRE(binnacle_describe_measurement(in.composition, fix, &measurement) == BINNACLE_OK);
  CHECK(std::string(measurement.name) == "fix");
  CHECK(measurement.channel == gnss);
  CHECK(measurement.max_rows == 3);
}

TEST_CASE("a struct of a later version's caller is filled with zeros beyond what is known") {
  const InC in;
  struct {
    binnacle_filter_info known;
    std::uint64_t later[2];
  } info;
  std::memset(&info, 0xff, sizeof info);
  info.known.size = sizeof info;
  REQUIRE(binnacle_describe_filter(in.composition, in.filter("rows"), &info.known) == BINNACLE_OK);
  CHECK(std::string(info.known.name) == "rows");
  CHECK(info.known.size == sizeof info);
  CHECK(info.known.input == 0);
  CHECK((info.later[0] == 0 && info.later[1] == 0));
}

TEST_CASE("the last error is each thread's own, and stays when a call succeeds") {
  std::uint64_t count = 0;
  CHECK(binnacle_channel_count(nullptr, &count) == BINNACLE_USAGE);
  const std::string mine = binnacle_last_error();
  CHECK(mine == "error: binnacle_channel_count: composition is null");
  std::string other_before, other_after;
  std::thread([&] {
    other_before = binnacle_last_error();
    binnacle_commit(nullptr, 0);
    other_after = binnacle_last_error();
  }).join();
  CHECK(other_before.empty());
  CHECK(other_after == "error: binnacle_commit: session is null");
  const InC in;
  CHECK(binnacle_last_error() == mine);
  CHECK(nlohmann::json::parse(binnacle_last_error_json())[0]["text"] == mine);
}

TEST_CASE("what `binnacle run` takes can be loaded in C, with its warnings") {
  binnacle_composition* composition = nullptr;
  REQUIRE(binnacle_load(BINNACLE_TEST_PROJECT "/configs/quickstart.json", nullptr, &composition) == BINNACLE_OK);
  const char* text = nullptr;
  REQUIRE(binnacle_warnings(composition, &text) == BINNACLE_OK);
  CHECK(std::string(text) == score::load(BINNACLE_TEST_PROJECT "/configs/quickstart.json")->warnings().text());
  CHECK(binnacle_release(composition) == BINNACLE_OK);
  REQUIRE(binnacle_parse(R"({"binnacle": 1, "sources": {"idle": {"type": "pushed", "fields": {"z": {"unit": "m"}}}},
    "filters": {}})",
                         "idle.json", nullptr, &composition) == BINNACLE_OK);
  REQUIRE(binnacle_warnings_json(composition, &text) == BINNACLE_OK);
  CHECK(nlohmann::json::parse(text)[0]["code"] == "B031");
  CHECK(binnacle_release(composition) == BINNACLE_OK);
}

TEST_CASE("the versions of the C interface") {
  CHECK(binnacle_interface_version() == (BINNACLE_INTERFACE_MAJOR << 16 | BINNACLE_INTERFACE_MINOR));
  CHECK(std::string(binnacle_version()) == BINNACLE_VERSION);
}

}  // namespace c_test
