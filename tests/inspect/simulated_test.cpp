// SPDX-License-Identifier: Apache-2.0
// Signs of delay, lever arm, mounting, axes and vertical velocity against a simulated drive without noise.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include <Eigen/Dense>

#include "catch.hpp"
#include "inspect/inspect.hpp"

namespace simulated_test {

using namespace binnacle::inspect;
using binnacle::FieldKind;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double step = 0.01, length = 240, speed = 12;

/// It stands for 20 s, then moves off: the path's time.
double path_time(double t) {
  const double u = std::max(0.0, t - 20);
  return u * u / (u + 10);
}
double pace(double t) {
  const double u = std::max(0.0, t - 20);
  return (u * u + 20 * u) / ((u + 10) * (u + 10));
}

double yaw_at(double t) { return 0.8 * std::sin(0.11 * t) + 1.3 * std::sin(0.043 * t) + 0.02 * t; }
double climb_at(double t) { return 0.03 * std::sin(0.31 * t) + 0.05 * std::sin(0.07 * t); }
double roll_at(double t) { return 0.04 * std::sin(0.53 * t + 1) + 0.02 * std::sin(0.17 * t); }

/// C_nv, forward right down.
Matrix3d attitude(double now) {
  const double t = path_time(now);
  return (Eigen::AngleAxisd(yaw_at(t), Vector3d::UnitZ()) * Eigen::AngleAxisd(climb_at(t), Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll_at(t), Vector3d::UnitX()))
      .toRotationMatrix();
}
Vector3d rate(double t) {
  const Eigen::AngleAxisd turn(Matrix3d(attitude(t - 5e-4).transpose() * attitude(t + 5e-4)));
  return turn.angle() * turn.axis() / 1e-3;
}
Vector3d velocity(double t) { return attitude(t).col(0) * pace(t) * (speed + 3 * std::sin(0.21 * path_time(t))); }
Vector3d antenna_velocity(double t, const Vector3d& lever_arm) {
  return velocity(t) + attitude(t) * rate(t).cross(lever_arm);
}

Field field(const std::string& name, const std::string& unit, FieldKind kind) {
  Field one;
  one.name = one.column = name;
  one.unit = one.si = unit;
  one.kind = kind;
  return one;
}

/// C_sv turns vehicle into sensor axes.
Channel imu_of(const Matrix3d& C_sv) {
  Channel imu;
  imu.name = "imu";
  imu.type = "csv";
  for (const char* name : {"wx", "wy", "wz"}) imu.fields.push_back(field(name, "rad/s", FieldKind::rate));
  for (const char* name : {"fx", "fy", "fz"}) imu.fields.push_back(field(name, "m/s^2", FieldKind::rate));
  for (double t = step; t < length; t += step) {
    imu.t.push_back(t);
    const double mid = t - 0.5 * step;
    const Vector3d push = (velocity(mid + 5e-4) - velocity(mid - 5e-4)) / 1e-3 - Vector3d(0, 0, 9.7803);
    const Vector3d w = C_sv * rate(mid), f = C_sv * (attitude(mid).transpose() * push);
    for (int k = 0; k < 3; ++k) {
      imu.fields[static_cast<std::size_t>(k)].values.push_back(w[k]);
      imu.fields[static_cast<std::size_t>(k + 3)].values.push_back(f[k]);
    }
  }
  return imu;
}

Channel gnss_of(const Vector3d& lever_arm) {
  Channel gnss;
  gnss.name = "gnss";
  gnss.type = "csv";
  for (const char* name : {"lat", "lon"}) gnss.fields.push_back(field(name, "rad", FieldKind::level));
  gnss.fields.push_back(field("height", "m", FieldKind::level));
  for (const char* name : {"vn", "ve", "vd"}) gnss.fields.push_back(field(name, "m/s", FieldKind::level));
  Vector3d p(0, 0, 100);
  for (int i = 0; i <= static_cast<int>(length / step) - 20; ++i) {
    const double t = i * step;
    if (i > 0) {
      const Vector3d v = antenna_velocity(t - 0.5 * step, lever_arm) * step;
      p += Vector3d(v[0] / 6335439, v[1] / 6378137, -v[2]);  // on the equator
    }
    if (i % 50 != 0) continue;
    const Vector3d v = antenna_velocity(t, lever_arm);
    gnss.t.push_back(t);
    for (int k = 0; k < 3; ++k) {
      gnss.fields[static_cast<std::size_t>(k)].values.push_back(p[k]);
      gnss.fields[static_cast<std::size_t>(k + 3)].values.push_back(v[k]);
    }
  }
  return gnss;
}

void negate(Channel& channel, std::size_t which) {
  for (double& value : channel.fields[which].values) value = -value;
}

/// What is later than `t` is left out.
void cut(Channel& channel, double t) {
  const auto n = static_cast<std::size_t>(std::ranges::lower_bound(channel.t, t) - channel.t.begin());
  channel.t.resize(n);
  for (Field& each : channel.fields) each.values.resize(n);
}

const Finding* find(const Inspection& inspection, const std::string& kind, const std::string& name = "") {
  const auto at = std::ranges::find_if(inspection.findings, [&](const Finding& found) {
    return found.kind == kind && (name.empty() || found.field == name);
  });
  return at == inspection.findings.end() ? nullptr : &*at;
}

}  // namespace

TEST_CASE("inspect: mounting, lever arm and delay of a drive without faults") {
  const Matrix3d C_sv =
      (Eigen::AngleAxisd(0.9, Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.4, Vector3d::UnitY())).toRotationMatrix();
  const Vector3d lever_arm(1.5, -0.6, -0.9);
  const auto inspection = inspect({imu_of(C_sv), gnss_of(lever_arm)});
  for (const auto& found : inspection.findings) {
    INFO(found.kind << " " << found.field << ": " << found.text);
    CHECK(found.severity != Severity::warning);
  }
  REQUIRE(inspection.mounting);
  const Matrix3d off = *inspection.mounting * C_sv;
  CHECK(std::acos(std::min(1.0, (off.trace() - 1) / 2)) < 0.01);
  const char* const names[] = {"forward", "right", "down"};
  for (int k = 0; k < 3; ++k) {
    const Finding* const found = find(inspection, "lever_arm", names[k]);
    REQUIRE(found);
    INFO(names[k] << " " << found->value);
    CHECK(std::abs(found->value - lever_arm[k]) < 0.2);
  }
  CHECK(std::abs(inspection.delay) < 0.01);
}

TEST_CASE("inspect: a fix that is late has a positive delay, and its labels are set back") {
  Channel gnss = gnss_of(Vector3d::Zero());
  gnss.first_label = 0.3;
  const auto inspection = inspect({imu_of(Matrix3d::Identity()), gnss});
  const Finding* const delay = find(inspection, "delay");
  REQUIRE(delay);
  CHECK(std::abs(delay->value - 0.3) < 0.02);
  CHECK(delay->severity == Severity::warning);
  REQUIRE(delay->meaning.is_object());
  CHECK(delay->meaning["sources"]["gnss"]["time"]["offset"].get<std::string>().starts_with("-0.3") ==
        (delay->value >= 0.2995));
}

TEST_CASE("inspect: one axis with another sign is named, of rates and of forces") {
  for (std::size_t which = 0; which < 6; ++which) {
    Channel imu = imu_of(Matrix3d::Identity());
    negate(imu, which);
    const auto inspection = inspect({imu, gnss_of(Vector3d::Zero())});
    const Finding* const found = find(inspection, which < 3 ? "rate_axes" : "force_axes");
    INFO(imu.fields[which].name);
    REQUIRE(found);
    CHECK(found->field == imu.fields[which].name);
    CHECK(found->meaning["sources"]["imu"]["columns"][imu.fields[which].name]["scale"] == -1);
  }
}

TEST_CASE("inspect: a height with the wrong sign is named, and not vd") {
  Channel gnss = gnss_of(Vector3d::Zero());
  negate(gnss, 2);
  const auto inspection = inspect({imu_of(Matrix3d::Identity()), gnss});
  CHECK(find(inspection, "height_sign"));
  CHECK(!find(inspection, "down_sign"));
}

TEST_CASE("inspect: vd with the wrong sign is named, and not the height") {
  Channel gnss = gnss_of(Vector3d::Zero());
  negate(gnss, 5);
  const auto inspection = inspect({imu_of(Matrix3d::Identity()), gnss});
  CHECK(!find(inspection, "height_sign"));
  CHECK(find(inspection, "down_sign"));
}

TEST_CASE("inspect: an antenna far ahead or behind is neither shortened nor taken for a delay") {
  for (const double forward : {4.0, -4.0}) {
    const auto inspection = inspect({imu_of(Matrix3d::Identity()), gnss_of(Vector3d(forward, 0, 0))});
    const Finding* const found = find(inspection, "lever_arm", "forward");
    REQUIRE(found);
    CHECK(std::abs(found->value - forward) < 0.2);
    CHECK(std::abs(inspection.delay) < 0.01);
  }
}

TEST_CASE("inspect: axes of a record too short for windows of 40 s") {
  Channel imu = imu_of(Matrix3d::Identity()), gnss = gnss_of(Vector3d::Zero());
  negate(imu, 1);
  cut(imu, 170);
  cut(gnss, 170);
  const auto inspection = inspect({imu, gnss});
  const Finding* const found = find(inspection, "rate_axes");
  REQUIRE(found);
  CHECK(found->field == "wy");
  CHECK(found->evidence.find("windows of 20 s") != std::string::npos);
}

TEST_CASE("inspect: what is proposed for a receiver's file states where its time begins") {
  Channel imu = imu_of(Matrix3d::Identity()), gnss = gnss_of(Vector3d::Zero());
  imu.path = "/imu.csv", gnss.path = "/log.ubx";
  gnss.type = "ublox";
  const auto proposal = propose(inspect({imu, gnss}), "/", "");
  CHECK(proposal.config.at("sources").at("gnss").at("week") == 0);
  CHECK_FALSE(proposal.config.at("sources").at("imu").contains("week"));
}

TEST_CASE("inspect: a part of the lever arm that the data do not show is said to be so, and proposed as zero") {
  Channel imu = imu_of(Matrix3d::Identity()), gnss = gnss_of(Vector3d(1.5, -0.6, -0.9));
  // White errors of 0.15 m/s: rolling shows no lever arm down through these.
  std::uint32_t state = 1;
  const auto noise = [&] {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += (state = state * 1664525u + 1013904223u) / 4294967296.0;
    return 0.15 * sum;
  };
  for (std::size_t k = 3; k < 6; ++k)
    for (double& value : gnss.fields[k].values) value += noise();
  cut(imu, 170);
  cut(gnss, 170);
  imu.path = "/imu.csv", gnss.path = "/gnss.csv";
  const auto inspection = inspect({imu, gnss});
  const Finding* const down = find(inspection, "lever_arm", "down");
  REQUIRE(down);
  INFO(down->text);
  CHECK(down->severity == Severity::unknown);
  CHECK(std::abs(down->value + 0.9) < 3 * down->sigma);
  const auto proposal = propose(inspection, "/", "");
  CHECK(proposal.config.at("filters").at("ins").at("derived").at("antenna").at("lever_arm")[2] == 0);
}

TEST_CASE(
    "inspect: what is proposed has a gate, the antenna's place, and noises and levelling of the rest at the begin") {
  Channel imu = imu_of(Matrix3d::Identity()), gnss = gnss_of(Vector3d(1.5, -0.6, -0.9));
  imu.path = "/imu.csv", gnss.path = "/gnss.csv";
  for (std::size_t i = 0; i < imu.t.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k) imu.fields[k].values[i] += (k < 3 ? 0.02 : 0.3) * (i % 2 ? 1 : -1);
  const auto proposal = propose(inspect({imu, gnss}), "/", "");
  const Json& ins = proposal.config.at("filters").at("ins");
  CHECK(ins.at("measurements").at("fix").at("gate") == 0.9999);
  CHECK(ins.at("derived").at("antenna").at("lever_arm")[0].get<std::string>().starts_with("1."));
  CHECK(ins.at("derived").at("antenna_velocity").at("lever_arm") == ins.at("derived").at("antenna").at("lever_arm"));
  // 0.02 rad/s at 100 Hz, and 0.3 m/s^2.
  CHECK(ins.at("process").at("strapdown").at("gyro_noise") == "6.88 deg/sqrt(h)");
  CHECK(ins.at("process").at("strapdown").at("accel_noise") == "1.8 m/s/sqrt(h)");
  const Json& alignment = proposal.config.at("transforms").at("alignment");
  CHECK(alignment.at("type") == "coarse_alignment");
  CHECK(alignment.at("heading") == "course");
  CHECK(alignment.contains("max_specific_force_sd"));
}

}  // namespace simulated_test
