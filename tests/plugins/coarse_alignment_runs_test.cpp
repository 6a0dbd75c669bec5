// SPDX-License-Identifier: Apache-2.0
// Coarse alignment over many runs, and on recorded drives.
#include <cmath>
#include <functional>
#include <iostream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "../recorded_data.hpp"
#include "aligner.hpp"
#include "csv/csv_source.hpp"

namespace coarse_alignment_runs_test {

using namespace binnacle;
using namespace binnacle::aligner;

namespace {

/// Runs with errors drawn anew, and what their mean NEES has to be.
struct MonteCarlo {
  static constexpr int runs = 300;
  std::mt19937 generator{7};
  std::normal_distribution<double> normal;

  Vector3d draw(double sigma) { return sigma * Vector3d(normal(generator), normal(generator), normal(generator)); }
  void check(const char* name, const std::function<double(int)>& one_run, double lowest = 3) {
    double sum = 0;
    for (int i = 0; i < runs; ++i) sum += one_run(i);
    const double mean = sum / runs;
    std::cout << "coarse_alignment: mean NEES of " << runs << " runs, " << name << ": " << mean << " (3 expected)\n";
    const double band = 2.576 * std::sqrt(2.0 * 3.0 / runs);
    REQUIRE(mean > lowest - band);
    REQUIRE(mean < 3 + band);
  }
};

}  // namespace

TEST_CASE("alignment: Monte Carlo, errors are as large as the covariances say") {
  MonteCarlo of;
  of.check("given", [&](int i) {
    Drive drive;
    drive.seed = static_cast<std::uint32_t>(i + 1);
    drive.length = 2.5;
    drive.has_gnss = false;
    drive.euler = Vector3d(10, -40, 7 * i % 360 - 180) * deg;
    drive.accelerometer_bias = of.draw(0.01 * g);
    drive.accelerometer_noise = 0.01;
    Aligner aligner(with_member(defaults("given"), "yaw", drive.euler.z() + 1 * deg * of.normal(of.generator)));
    drive.run(aligner);
    return nees(aligner.out.attitudes.at(0), drive.euler);
  });
  of.check("course", [&](int i) {
    Drive drive;
    drive.seed = static_cast<std::uint32_t>(i + 1);
    drive.rest = 3;
    drive.length = 14;
    drive.acceleration = 0.3;
    drive.euler = Vector3d(10, -20, 7 * i % 360 - 180) * deg;
    drive.accelerometer_bias = of.draw(0.01 * g);
    drive.gyro_bias = of.draw(0.5 * deg);
    drive.gyro_drift = of.draw(0.05 * deg);
    drive.gyro_noise = 0.1 * deg;
    drive.velocity_noise = 0.05;
    auto parameters = with_member(with_member(defaults("course"), "sigma_heading", 0), "velocity_sd", 0.05);
    Aligner aligner(with_member(parameters, "gyro_drift", 0.05 * deg));
    drive.run(aligner);
    const auto& attitude = aligner.out.attitudes.at(0);
    return nees(attitude, drive.euler_at(seconds(attitude.t)));
  });
}

TEST_CASE("alignment: Monte Carlo of gyrocompassing, and of noise alone") {
  MonteCarlo of;
  of.check("gyrocompass", [&](int i) {
    Drive drive;
    drive.seed = static_cast<std::uint32_t>(i + 1);
    drive.length = 2.5;
    drive.has_gnss = false;
    drive.euler = Vector3d(-70, 50, 7 * i % 360 - 180) * deg;
    drive.accelerometer_bias = of.draw(0.001 * g);
    drive.gyro_bias = of.draw(0.01 * deg / 3600);
    auto parameters =
        with_member(with_member(defaults("gyrocompass"), "latitude", drive.lat), "gyro_bias", 0.01 * deg / 3600);
    Aligner aligner(with_member(parameters, "accelerometer_bias", 0.001 * g));
    drive.run(aligner);
    return nees(aligner.out.attitudes.at(0), drive.euler);
  });
  // With noise alone the worst of three axes stands for all: on the safe side.
  of.check(
      "noise alone",
      [&](int i) {
        Drive drive;
        drive.seed = static_cast<std::uint32_t>(i + 1);
        drive.length = 2.5;
        drive.has_gnss = false;
        drive.accelerometer_noise = 0.1;
        Aligner aligner(with_member(with_member(defaults("given"), "yaw", 1 * deg * of.normal(of.generator)),
                                    "accelerometer_bias", 0));
        drive.run(aligner);
        return nees(aligner.out.attitudes.at(0), drive.euler);
      },
      2);
}

namespace {

/// A recorded file through the csv source, one sample ahead.
class Recording {
 public:
  Recording(const std::string& path, const Members& columns) {
    Members specified;
    for (const auto& [name, si_unit] : columns)
      specified.push_back({name, object({{"unit", si_unit}, {"kind", is_imu(name) ? "rate" : "level"}})});
    source_ = binnacle::testing::bind<csv::CsvSource>({object({{"path", path}, {"columns", object(specified)}})});
    struct Silent : Reporter {
      void warn(const std::string&, const std::string&, int, const std::string&) override {}
    } silent;
    source_->open(silent);
    memory_ = binnacle::testing::SourceCaller(*source_).fresh_memory(0);
  }
  bool next() {
    auto next = binnacle::testing::SourceCaller(*source_).next(memory_.data());
    if (next.status != SourceStatus::sample) return false;
    fields = std::move(next.sample.fields);
    t = next.sample.t;
    t0 = next.sample.t0;
    return true;
  }
  Time t = no_time, t0 = no_time;
  std::vector<double> fields;

 private:
  static bool is_imu(const std::string& name) { return name[0] == 'g' || name[0] == 'a'; }
  std::unique_ptr<csv::CsvSource> source_;
  std::vector<std::byte> memory_;
};

struct RecordedDrive {
  const char* folder;
  Vector3d mount;  // deg
};

}  // namespace

TEST_CASE("alignment: on recorded drives, against the reference", "[data]") {
  const auto drives = binnacle::test::recorded_data("drives");
  if (!drives) return;
  for (const auto& drive :
       std::vector<RecordedDrive>{{"mixed-road-long-drive-large-mount-001", {170.79, 60.50, 167.45}},
                                  {"parkinglot-maneuvers", {-1.82, -24.60, 96.87}},
                                  {"urban-medium-turn-loop-nominal-001", {-1.17, -0.02, 2.59}},
                                  {"urban-mixed-turns-nominal-001", {-2.01, 1.61, 265.33}},
                                  {"urban-stop-go-large-mount-001", {170.75, 60.59, 168.91}}}) {
    const auto file = [&](const char* name) { return (*drives / drive.folder / name).string(); };
    Recording imu(file("imu.csv.gz"), {{"gx_radps", unit("rad/s")},
                                       {"gy_radps", unit("rad/s")},
                                       {"gz_radps", unit("rad/s")},
                                       {"ax_mps2", unit("m/s^2")},
                                       {"ay_mps2", unit("m/s^2")},
                                       {"az_mps2", unit("m/s^2")}});
    Recording gnss(file("gnss.csv.gz"),
                   {{"vn_mps", unit("m/s")}, {"ve_mps", unit("m/s")}, {"lat_deg", unit("rad", deg)}});
    // Raw axes to forward-left-up by the mount angles, then to forward-right-down.
    const Matrix3d C =
        Vector3d(1, -1, -1).asDiagonal() * sd::dcm_from_quaternion(sd::quaternion_from_euler(drive.mount * deg));
    Aligner aligner(with_member(defaults("course"), "velocity_sd", 0.1));
    bool has_gnss = gnss.next();
    while (imu.next() && aligner.out.attitudes.empty()) {
      for (; has_gnss && gnss.t <= imu.t; has_gnss = gnss.next())
        if (gnss.t < imu.t) aligner.gnss(gnss.t, gnss.fields[0], gnss.fields[1], gnss.fields[2]);
      aligner.imu(imu.t0, imu.t, C * Vector3d(imu.fields[0], imu.fields[1], imu.fields[2]),
                  C * Vector3d(imu.fields[3], imu.fields[4], imu.fields[5]));
    }
    INFO(drive.folder);
    REQUIRE(aligner.out.attitudes.size() == 1);
    const auto& attitude = aligner.out.attitudes[0];
    Recording reference(file("reference_attitude.csv.gz"), {{"roll_deg", unit("rad", deg)},
                                                            {"pitch_deg", unit("rad", deg)},
                                                            {"yaw_deg", unit("rad", deg)}});
    while (reference.next() && reference.t < attitude.t) continue;
    // An angle of exactly zero is one that the reference does not know yet.
    const Vector3d expected(reference.fields[0], reference.fields[1], reference.fields[2]);
    const Vector3d sigma = attitude.P.diagonal().cwiseSqrt() / deg;
    std::cout << "coarse_alignment: " << drive.folder << " at " << seconds(attitude.t) << " s, 1-sigma (n e d) "
              << sigma.transpose() << " deg";
    const char* names[] = {"roll", "pitch", "yaw"};
    for (int i = 0; i < 3; ++i) {
      const double error = wrapped(attitude.values[i] - expected[i]) / deg;
      std::cout << ", " << names[i] << " " << attitude.values[i] / deg;
      if (expected[i] == 0) continue;
      std::cout << " (" << (error < 0 ? "" : "+") << error << " against the reference)";
      REQUIRE(std::abs(error) < 3 * sigma[i]);
    }
    std::cout << "\n";
  }
}

}  // namespace coarse_alignment_runs_test
