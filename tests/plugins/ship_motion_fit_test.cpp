// SPDX-License-Identifier: Apache-2.0
// Plugin ship_motion: spectra of seas and series, the shaping filters fitted to them, and what is simulated of these.
#include <unistd.h>

#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <random>

#include "bind.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"

#include "../../plugins/ship_motion/motion.hpp"
#include "../../plugins/ship_motion/motion_parameters.hpp"
#include "../../plugins/ship_motion/shaping_fit.hpp"
#include "../../plugins/ship_motion/simulator.hpp"

namespace ship_motion_fit_test {

using namespace binnacle;
using namespace binnacle::ship_motion;
using namespace binnacle::test;
using Eigen::VectorXd;
using Json = nlohmann::json;

namespace {

constexpr double pi = 3.14159265358979323846, g = 9.80665;

bool is_near(double a, double b, double part) { return std::abs(a - b) <= part * std::abs(b); }

VectorXd grid(double first, double last, int n) { return VectorXd::LinSpaced(n, first, last); }

Spectrum waves(const Sea& sea) {
  const VectorXd omega = grid(0.002, 40, 20000);
  return tabulated(omega, omega.unaryExpr([&](double at) { return sea.density(at); }));
}

ShapingFilter second(double omega, double zeta, double sigma) {
  return {VectorXd::Constant(1, omega), VectorXd::Constant(1, zeta), sigma};
}

ShapingFilter fourth(double w1, double w2, double z1, double z2, double sigma) {
  return {Eigen::Vector2d(w1, w2), Eigen::Vector2d(z1, z2), sigma};
}

Response unit_response() {
  return [](double, double) { return 1.0; };
}

/// Bound with findings, as the kernel does it.
struct Bound {
  std::unique_ptr<Simulator> simulator;
  Findings findings;

  explicit Bound(const Json& json) {
    simulator = testing::bind<Simulator>({.parameters = json, .name = "sea", .findings = &findings});
  }
  double figure(const std::string& name) const {
    for (const auto& figure : findings.figures)
      if (figure.name == name) return figure.value;
    throw std::logic_error("no figure " + name);
  }
};

struct Played {
  std::vector<Time> t;
  std::vector<std::vector<double>> truth;
  std::vector<double> gyro;
};

Played played_by(Simulator& simulator, std::uint64_t seed) {
  class Silent final : public Reporter {
    void warn(const std::string&, const std::string&, int, const std::string&) override {}
  } silent;
  simulator.open(silent);
  const binnacle::testing::SourceCaller caller(simulator);
  auto memory = caller.fresh_memory(seed);
  Played played;
  for (auto next = caller.next(memory.data()); next.status == SourceStatus::sample; next = caller.next(memory.data())) {
    REQUIRE(next.damage.empty());
    if (next.sample.channel == Simulator::gyro) {
      played.gyro.push_back(next.sample.fields[0]);
      continue;
    }
    played.t.push_back(next.sample.t);
    played.truth.push_back(next.sample.fields);
  }
  return played;
}

VectorXd angles(const Played& played) {
  VectorXd x(static_cast<Eigen::Index>(played.truth.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = played.truth[static_cast<std::size_t>(i)][0];
  return x;
}

class File {
 public:
  explicit File(const std::string& text)
      : path_(std::filesystem::temp_directory_path() / ("binnacle_motion_" + std::to_string(::getpid()) + ".csv")) {
    std::ofstream(path_) << text;
  }
  ~File() { std::filesystem::remove(path_); }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

const AdditiveKind angle(1, "rad"), rate(1, "rad/s"), forcing(1, "rad/s^2"), forcing_rate(1, "rad/s^3");

}  // namespace

TEST_CASE("Bretschneider's sea: height, period and moments in closed form", "[ship_motion]") {
  const double height = 3.5, period = 9;
  const Sea sea(height, period);
  const Spectrum spectrum = waves(sea);
  REQUIRE(is_near(4 * std::sqrt(spectrum.moment(0)), height, 1e-4));
  REQUIRE(is_near(spectrum.peak(), 2 * pi / period, 3e-3));
  for (const int n : {-1, 1, 2}) {
    const double wanted =
        height * height / 16 * std::pow(sea.peak(), n) * std::pow(1.25, n / 4.0) * std::tgamma(1 - n / 4.0);
    REQUIRE(is_near(spectrum.moment(n), wanted, n == 2 ? 2e-3 : 1e-3));
  }
}

TEST_CASE("JONSWAP: Bretschneider at gamma 1, the same height and a sharper peak beyond", "[ship_motion]") {
  const Sea plain(2, 8), still(2, 8, 1 + 1e-12), sharp(2, 8, 3.3);
  for (const double omega : {0.3, 0.7, 0.7854, 1.0, 3.0})
    REQUIRE(is_near(still.density(omega), plain.density(omega), 1e-5));
  REQUIRE(is_near(4 * std::sqrt(waves(sharp).moment(0)), 2, 1e-4));
  // Goda's approximation of the factor that keeps the height.
  REQUIRE(is_near(sharp.density(sharp.peak()) / plain.density(plain.peak()), 3.3 * (1 - 0.287 * std::log(3.3)), 0.01));
  // Two widths below the peak and two above: 0.07 and 0.09.
  const double factor = sharp.density(100) / plain.density(100);
  for (const double part : {1 - 0.14, 1 + 0.18}) {
    const double omega = part * sharp.peak();
    REQUIRE(is_near(sharp.density(omega) / plain.density(omega) / factor, std::pow(3.3, std::exp(-2.0)), 1e-6));
  }
}

TEST_CASE("a ship meets head seas sooner, following seas later, and all of their energy", "[ship_motion]") {
  const double U = 6;
  REQUIRE(is_near(Encounter{U, pi}.frequency(0.8), 0.8 + 0.64 * U / g, 1e-12));
  REQUIRE(is_near(Encounter{U, 0}.frequency(0.8), 0.8 - 0.64 * U / g, 1e-12));
  REQUIRE(is_near(Encounter{U, pi / 2}.frequency(0.8), 0.8, 1e-12));
  REQUIRE(is_near(Encounter{U, 0}.frequency(3), 9 * U / g - 3, 1e-12));  // overtaken: waves from ahead
  const Sea sea(3, 9);
  for (const double heading : {pi, pi / 2, 0.8, 0.0}) {
    const Spectrum met = motion_spectrum(sea, {U, heading}, unit_response());
    INFO("heading " << heading);
    REQUIRE(is_near(4 * std::sqrt(met.moment(0)), 3, 2e-3));
  }
  const Encounter head{U, pi};
  REQUIRE(is_near(motion_spectrum(sea, head, unit_response()).peak(), head.frequency(sea.peak()), 0.05));
  // S(ω_e) = S(ω) / (dω_e/dω).
  const Spectrum met = motion_spectrum(sea, head, unit_response());
  for (const Eigen::Index bin : {40, 80, 120}) {
    const double omega = (std::sqrt(1 + 4 * met.omega[bin] * U / g) - 1) / (2 * U / g);
    REQUIRE(is_near(met.density[bin], sea.density(omega) / (1 + 2 * omega * U / g), 0.01));
  }
}

TEST_CASE("responses: a table, a resonance, of height and of slope", "[ship_motion]") {
  const auto table = tabulated_response(Eigen::Vector3d(0.5, 1, 2), Eigen::Vector3d(1, 3, 2));
  REQUIRE(is_near(table(0.75, 9), 2, 1e-12));
  REQUIRE(is_near(table(1.5, 9), 2.5, 1e-12));
  REQUIRE(table(0.4, 0.7) == 0);
  REQUIRE(table(2.1, 0.7) == 0);
  const auto height = resonant_response(0.6, 0.1, 0.02, false);
  REQUIRE(is_near(height(5, 1e-6), 0.02, 1e-9));
  REQUIRE(is_near(height(5, 0.6), 0.02 / 0.2, 1e-12));
  REQUIRE(is_near(height(5, 1.2), 0.02 / std::hypot(3, 0.4), 1e-12));
  REQUIRE(is_near(resonant_response(0.6, 0.1, 1, true)(0.7, 1e-6), 0.49 / g, 1e-9));
  const Spectrum doubled =
      motion_spectrum(Sea(3, 9), {}, tabulated_response(Eigen::Vector2d(0, 100), Eigen::Vector2d(2, 2)));
  REQUIRE(is_near(4 * std::sqrt(doubled.moment(0)), 6, 2e-3));
}

TEST_CASE("a shaping filter's spectrum and autocovariance belong together", "[ship_motion]") {
  const double w = 0.7, z = 0.2, sigma = 0.03;
  for (const ShapingFilter& filter : {second(w, z, sigma), fourth(0.7, 1.0, 0.2, 0.1, sigma)}) {
    const VectorXd nu = grid(0, 60, 120001);
    const Spectrum spectrum = tabulated(nu, filter.spectrum(nu));
    REQUIRE(is_near(spectrum.moment(0), sigma * sigma, 1e-5));
    const VectorXd r = filter.autocovariance(0.5, 12);
    for (Eigen::Index k = 0; k < 12; ++k) {
      const double integral =
          (spectrum.density.array() * (nu.array() * 0.5 * static_cast<double>(k)).cos() * spectrum.width.array()).sum();
      REQUIRE(std::abs(r[k] - integral) < 1e-5 * sigma * sigma);
    }
    REQUIRE(is_near(filter.peak(), spectrum.peak(), 2e-3));
  }
  const ShapingFilter filter = second(w, z, sigma);
  REQUIRE(is_near(filter.peak(), w * std::sqrt(1 - 2 * z * z), 2e-3));
  const double damped = w * std::sqrt(1 - z * z), t = 1.5;
  REQUIRE(is_near(filter.autocovariance(t, 2)[1],
                  sigma * sigma * std::exp(-z * w * t) * (std::cos(damped * t) + z * w / damped * std::sin(damped * t)),
                  1e-12));
}

TEST_CASE("Welch's spectrum has the area of the variance", "[ship_motion]") {
  const Eigen::Index n = 64;
  const double T = 0.5, amplitude = 0.3;
  const Welch welch(n, T);
  // A whole number of periods in a segment: nothing leaks beyond the two bins beside.
  VectorXd wave(5 * n);
  for (Eigen::Index i = 0; i < wave.size(); ++i)
    wave[i] = amplitude * std::cos(9 * welch.bin() * T * static_cast<double>(i) + 0.4);
  const Spectrum spectrum = welch.of(wave);
  REQUIRE(is_near(spectrum.moment(0), 0.5 * amplitude * amplitude, 1e-12));
  REQUIRE(is_near(spectrum.peak(), 9 * 2 * pi / 32, 1e-12));
  const VectorXd lags = VectorXd::LinSpaced(n, 0, static_cast<double>(n - 1)) * T;
  const VectorXd expected = welch.expected((0.5 * amplitude * amplitude) * (lags * (9 * welch.bin())).array().cos());
  REQUIRE((expected - spectrum.density).cwiseAbs().maxCoeff() < 1e-12);
  // White noise is flat, σ² over 0 … π/T.
  REQUIRE((welch.expected(VectorXd::Unit(n, 0) * 4).array() - 4 * T / pi).abs().maxCoeff() < 1e-12);

  // By its definition, one segment of noise.
  std::mt19937 engine(5);
  VectorXd noise(n);
  for (auto& x : noise) x = std::ldexp(static_cast<double>(engine()), -32) - 0.5;
  const Spectrum once = welch.of(noise);
  double squares = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    squares += std::pow(std::sin(pi * static_cast<double>(i) / static_cast<double>(n)), 4);
  for (const Eigen::Index k : {Eigen::Index(1), Eigen::Index(7), n / 2 - 1}) {
    std::complex<double> X = 0;
    for (Eigen::Index i = 0; i < n; ++i)
      X += noise[i] * std::pow(std::sin(pi * static_cast<double>(i) / static_cast<double>(n)), 2) *
           std::polar(1.0, -2 * pi * static_cast<double>(i * k) / static_cast<double>(n));
    REQUIRE(is_near(once.density[k - 1], std::norm(X) * T / (pi * squares), 1e-10));
  }
}

TEST_CASE("a filter's own spectrum gives the filter back", "[ship_motion]") {
  const VectorXd omega = grid(0, 8, 801);
  const ShapingFilter two = second(0.9, 0.15, 0.04);
  const ShapingFit found = fit(2, tabulated(omega, two.spectrum(omega)));
  REQUIRE(is_near(found.filter.omega[0], 0.9, 1e-3));
  REQUIRE(is_near(found.filter.zeta[0], 0.15, 3e-3));
  REQUIRE(is_near(found.filter.sigma, 0.04, 1e-3));
  REQUIRE(found.misfit < 2e-3);
  REQUIRE(found.is_good());

  const ShapingFilter four = fourth(0.6, 1.0, 0.1, 0.2, 0.04);
  const ShapingFit also = fit(4, tabulated(omega, four.spectrum(omega)));
  REQUIRE((also.filter.omega - four.omega).cwiseAbs().maxCoeff() < 2e-3);
  REQUIRE((also.filter.zeta - four.zeta).cwiseAbs().maxCoeff() < 2e-3);
  REQUIRE(also.is_good());

  // Two swells are no one resonance.
  const ShapingFilter low = second(0.4, 0.03, 0.04), high = second(1.6, 0.03, 0.04);
  const ShapingFit poor = fit(2, tabulated(omega, low.spectrum(omega) + high.spectrum(omega)));
  REQUIRE_FALSE(poor.is_good());
}

TEST_CASE("a simulated series gives the filter back", "[ship_motion]") {
  const double w = 0.7, z = 0.08, sigma = 0.03;
  Bound sea({{"omega", {w}}, {"zeta", {z}}, {"sigma", sigma}, {"noise", 0}, {"interval", 1}, {"duration", 40000}});
  VectorXd x = angles(played_by(*sea.simulator, 3));
  REQUIRE(x.size() == 40001);
  x.array() -= x.mean();
  // A segment of 64 s, whose bin is nearly the width of the resonance: what the window broadens is allowed for.
  const ShapingFit found = fit(2, x, Welch(64, 1));
  REQUIRE(is_near(found.filter.omega[0], w, 0.01));
  REQUIRE(is_near(found.filter.zeta[0], z, 0.08));
  REQUIRE(is_near(found.filter.sigma, sigma, 0.03));
  REQUIRE(found.misfit < 0.05);

  Bound four({{"omega", {0.5, 0.9}}, {"zeta", {0.1, 0.2}}, {"sigma", sigma}, {"noise", 0}, {"duration", 40000}});
  const Played played = played_by(*four.simulator, 4);
  x = angles(played);
  x.array() -= x.mean();
  REQUIRE(is_near(std::sqrt(x.squaredNorm() / static_cast<double>(x.size())), sigma, 0.04));
  const ShapingFit also = fit(4, x, Welch(128, 1));
  REQUIRE(is_near(also.filter.omega[0], 0.5, 0.02));
  REQUIRE(is_near(also.filter.omega[1], 0.9, 0.04));
  // The rate is the angle's.
  for (std::size_t i = 1; i + 1 < 200; ++i)
    REQUIRE(std::abs(0.5 * (played.truth[i + 1][0] - played.truth[i - 1][0]) - played.truth[i][1]) < 0.35 * sigma);
}

TEST_CASE("a simulated motion begins in its steady state", "[ship_motion]") {
  const ShapingFilter filter = fourth(0.5, 0.9, 0.1, 0.2, 0.03);
  Bound sea(
      {{"omega", {0.5, 0.9}}, {"zeta", {0.1, 0.2}}, {"sigma", 0.03}, {"noise", 0}, {"interval", 2}, {"duration", 2}});
  const int runs = 4000;
  double square[2] = {}, speed = 0, lagged = 0;
  for (int run = 0; run < runs; ++run) {
    const Played played = played_by(*sea.simulator, static_cast<std::uint64_t>(run));
    for (const std::size_t i : {0U, 1U}) square[i] += played.truth[i][0] * played.truth[i][0] / runs;
    speed += played.truth[0][1] * played.truth[0][1] / runs;
    lagged += played.truth[0][0] * played.truth[1][0] / runs;
  }
  // Of a variance from so many runs the standard error is 2.2 %.
  const VectorXd r = filter.autocovariance(2, 2);
  for (const double of_angle : square) REQUIRE(is_near(of_angle, r[0], 0.08));
  REQUIRE(is_near(speed, filter.steady_covariance()(1, 1), 0.08));
  REQUIRE(std::abs(lagged - r[1]) < 0.08 * r[0]);
}

TEST_CASE("a motion fitted to a sea, and the figures it reports", "[ship_motion]") {
  const Json sea = {{"significant_height", 3},
                    {"peak_period", 9},
                    {"speed", 0},
                    {"heading", 0},
                    {"response", {{"omega", 0.7}, {"zeta", 0.1}, {"slope_gain", 1}}}};
  for (const int order : {2, 4}) {
    const Bound bound({{"fit", {{"order", order}, {"sea", sea}}}, {"noise", 0}});
    const Spectrum wanted = motion_spectrum(Sea(3, 9), {}, resonant_response(0.7, 0.1, 1, true));
    REQUIRE(is_near(bound.figure("sigma"), std::sqrt(wanted.moment(0)), 1e-9));
    REQUIRE(is_near(bound.figure("significant amplitude, given"), 2 * std::sqrt(wanted.moment(0)), 1e-9));
    REQUIRE(is_near(bound.figure("significant amplitude, fitted"), bound.figure("significant amplitude, given"), 0.05));
    REQUIRE(is_near(bound.figure("peak, fitted"), wanted.peak(), 0.05));
    REQUIRE(bound.figure("misfit") < (order == 2 ? 0.2 : 0.1));
    REQUIRE(bound.findings.notes.empty());
  }
  const VectorXd omega = grid(0.01, 3, 100);
  const VectorXd two = second(0.4, 0.03, 1).spectrum(omega) + second(1.6, 0.03, 1).spectrum(omega);
  const Bound poor({{"fit",
                     {{"spectrum",
                       {{"omega", std::vector<double>(omega.begin(), omega.end())},
                        {"density", std::vector<double>(two.begin(), two.end())}}}}},
                    {"noise", 0}});
  REQUIRE(poor.findings.notes.size() == 1);
  REQUIRE(poor.findings.notes[0].find("the fit is poor") == 0);
}

TEST_CASE("a motion fitted to a record, and the record played", "[ship_motion]") {
  std::string text = "t,roll,heave\n";
  Bound sea({{"omega", {0.6}}, {"zeta", {0.1}}, {"sigma", 2.0}, {"noise", 0}, {"duration", 3000}});
  const Played motion = played_by(*sea.simulator, 8);
  for (std::size_t i = 0; i < motion.t.size(); ++i)
    text += std::to_string(100 + seconds(motion.t[i])) + "," + std::to_string(7 + motion.truth[i][0]) + ",0\n";
  const File file(text);
  const Json record = {{"path", file.path()}, {"column", "roll"}, {"unit", "deg"}};
  const double deg = pi / 180;
  const Bound player({{"record", record}, {"noise", 0}, {"drift", 1e-4}});
  const Played played = played_by(*player.simulator, 1);
  REQUIRE(played.t.size() == motion.t.size());
  REQUIRE(played.t.front() == nanoseconds(100));
  REQUIRE(played.truth[0].size() == 3);
  Json part = record;
  part["window"] = {200, 300};
  const Bound in_part({{"record", part}, {"noise", 0}});
  const Played short_play = played_by(*in_part.simulator, 1);
  REQUIRE(short_play.t.front() == nanoseconds(200));
  REQUIRE(short_play.t.back() == nanoseconds(300));
  REQUIRE(std::abs(angles(short_play).mean()) < 1e-12);
  const VectorXd x = angles(played);
  REQUIRE(std::abs(x.mean()) < 1e-12);
  REQUIRE(is_near(x[10] - x[20], deg * (motion.truth[10][0] - motion.truth[20][0]), 1e-4));
  for (std::size_t i = 0; i < 100; ++i)
    REQUIRE(std::abs(played.gyro[i] - played.truth[i][0] - played.truth[i][1]) < 1e-15);
  // The error is the integral of the drift, which hardly changes from second to second.
  REQUIRE(std::abs(played.truth[100][2]) > 1e-6);
  REQUIRE(std::abs(played.truth[101][1] - played.truth[100][1] - played.truth[100][2]) < 1e-5);

  Json parts = record;
  parts["segment"] = 100;
  const Bound fitted({{"fit", {{"record", parts}}}, {"noise", 0}});
  REQUIRE(fitted.findings.figures.size() == 9);
  REQUIRE(is_near(fitted.figure("omega"), 0.6, 0.05));
  REQUIRE(is_near(fitted.figure("zeta"), 0.1, 0.3));
  REQUIRE(is_near(fitted.figure("sigma"), std::sqrt(x.squaredNorm() / static_cast<double>(x.size())), 1e-9));
  REQUIRE(is_near(fitted.figure("resolution"), 2 * pi / 100, 1e-9));
  REQUIRE(fitted.findings.notes.empty());
}

TEST_CASE("ship motion: fits that are refused", "[ship_motion]") {
  const Ports two{{"angle", &angle}, {"rate", &rate}};
  const Json table = {{"omega", {0.1, 0.5, 1.0}}, {"density", {0.1, 2.0, 0.1}}};
  const auto refused = [&](const Json& parameters) {
    REQUIRE_THROWS_AS(bind<Motion>({parameters, two, {}}), ComponentError);
  };
  REQUIRE_NOTHROW(bind<Motion>({{{"fit", {{"spectrum", table}}}}, two, {}}));
  refused(Json::object());
  refused({{"omega", {1.0}}, {"zeta", {0.1}}});
  refused({{"sigma", 1}, {"fit", {{"spectrum", table}}}});
  refused({{"fit", {{"order", 3}, {"spectrum", table}}}});
  refused({{"fit", {{"order", 4}, {"spectrum", table}}}});  // its ports are open
  refused({{"fit", Json::object()}});
  refused({{"fit", {{"spectrum", {{"omega", {0.1, 0.5}}, {"density", {0.1, 2.0, 0.1}}}}}}});
  refused({{"fit", {{"spectrum", {{"omega", {0.5, 0.1, 1.0}}, {"density", {0.1, 2.0, 0.1}}}}}}});
  refused({{"fit", {{"spectrum", {{"omega", {0.1, 0.5, 1.0}}, {"density", {0.1, -2.0, 0.1}}}}}}});
  Json sea = {{"significant_height", 3}, {"peak_period", 9}};
  refused({{"fit", {{"sea", sea}}}});
  sea["response"] = {{"omega", 0.7}, {"zeta", 0.1}};
  refused({{"fit", {{"sea", sea}}}});
  // It may fall from 0 on.
  REQUIRE_NOTHROW(bind<Motion>(
      {{{"fit", {{"spectrum", {{"omega", {0.0, 0.5, 1.0, 2.0}}, {"density", {3.0, 2.0, 0.1, 0.01}}}}}}}, two, {}}));
  const File file("t,roll\n0,1\n1,2\n2,x\n");
  const Json record = {{"path", file.path()}, {"column", "roll"}, {"unit", "deg"}};
  const auto why = [&](const Json& changed) {
    try {
      bind<Motion>({{{"fit", {{"record", changed}}}}, two, {}});
    } catch (const ComponentError& error) {
      return (error.is_data_error() ? error.code() + " " + std::to_string(error.line()) + " " : "") + error.what() +
             error.pointer();
    }
    return std::string("nothing");
  };
  REQUIRE(why(record) == "B062 4 'x' is not a number");
  Json other = record;
  other["column"] = "yaw";
  REQUIRE(why(other) == "no column 'yaw'; the header has: t, roll/fit/record/column");
  other = record;
  other["unit"] = "m";
  REQUIRE(why(other) == "the motion is in rad, the column in m/fit/record/unit");
  other = record;
  other["path"] = file.path() + ".none";
  REQUIRE(why(other).find("B060") == 0);
  std::string gap = "t,roll\n", still = gap;
  for (int i = 0; i < 100; ++i) {
    gap += std::to_string(i < 50 ? i : i + 1) + "," + std::to_string(i % 7) + "\n";
    still += std::to_string(i) + ",3\n";
  }
  std::ofstream(file.path()) << gap;
  REQUIRE(why(record).find("B065") == 0);
  std::ofstream(file.path()) << still;
  other = record;
  other["segment"] = 20;
  REQUIRE(why(other) == "the record contains no motion/fit/record");
  REQUIRE(why(record).find("a segment of 10 samples") == 0);
}

}  // namespace ship_motion_fit_test
