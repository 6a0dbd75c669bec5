// SPDX-License-Identifier: Apache-2.0
// A composed filter in each form of the covariance: what a config says, what a snapshot holds, and that nothing else of a filter
// notices which form it is.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/diagnostic.hpp"
#include "binnacle/eigen.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace covariance_form_test {

using namespace binnacle;

using filter_tests::composition_of;
using filter_tests::from_covariance;
using filter_tests::line;
using filter_tests::push;
using filter_tests::started_with;
using filter_tests::with_form;

namespace {

constexpr const char* forms[] = {"joseph", "ud", "square_root"};

std::shared_ptr<const Composition> ins(const std::string& form) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = {"/filters/ins/covariance=" + form};
  return Composition::load(BINNACLE_TEST_PROJECT "/tests/filter/ins.json", options);
}

std::vector<std::byte> bytes_of(const Session& session) {
  std::vector<std::byte> bytes(session.snapshot_size());
  session.snapshot(bytes);
  return bytes;
}

/// Seconds of a vehicle at rest, with noise; from 60 s on its fixes are elsewhere, which locks the filter out.
void drive(Session& session, int first, int end, unsigned seed = 3) {
  const auto imu = session.channel("imu"), gnss = session.channel("gnss");
  std::normal_distribution<double> normal;
  for (int second = first; second < end; ++second) {
    std::mt19937 engine(seed + static_cast<unsigned>(second));
    for (int i = 0; i < 100; ++i) {
      const Time t = (100 * second + i) * nanoseconds(0.01);
      const double increments[] = {1e-6 * normal(engine), 1e-6 * normal(engine), 1e-6 * normal(engine),
                                   1e-4 * normal(engine), 1e-4 * normal(engine), -0.0981 + 1e-4 * normal(engine)};
      if (i % 50 == 20) {                           // ahead of the input
        const double off = second >= 60 ? 500 : 0;  // and stays there
        const double fix[] = {0.8377580409572782 + (off + normal(engine)) / 6.4e6,
                              0.19198621771937624 + normal(engine) / 6.4e6, 500 + 2 * normal(engine)};
        session.push(gnss, no_time, t + nanoseconds(0.004), fix);
      }
      session.push(imu, t, t + nanoseconds(0.01), increments);
    }
  }
}

std::string error_of(const std::string& config) {
  try {
    composition_of(config);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE(
    "a filter of each form: the same outcomes, estimates and sigmas, through a lock-out and with what is considered") {
  std::vector<Session> sessions;
  for (const char* form : forms) {
    sessions.emplace_back(ins(form));
    drive(sessions.back(), 0, 90);
    REQUIRE(sessions.back().healthy({0}));
  }
  const auto counts = sessions[0].counts({{0}, 0});
  CHECK(counts.recoveries > 0);
  CHECK(counts.by_outcome[static_cast<int>(Outcome::gated)] > 0);
  const Eigen::MatrixXd P = sessions[0].covariance(FilterId{0}).as();
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  for (const int k : {1, 2}) {
    const Session& session = sessions[static_cast<std::size_t>(k)];
    CAPTURE(forms[k]);
    CHECK(std::ranges::equal(session.counts({{0}, 0}).by_outcome, counts.by_outcome));
    CHECK(session.counts({{0}, 0}).recoveries == counts.recoveries);
    const Eigen::MatrixXd its = session.covariance(FilterId{0}).as();
    CHECK(((its - P).array() / (sigma * sigma.transpose()).array()).abs().maxCoeff() < 1e-9);
    double outputs[3], expected[3], sigmas[3], expected_sigmas[3];
    for (const char* block : {"position", "velocity", "attitude"}) {
      const auto id = session.block(block);
      session.read(id, outputs);
      session.read_sigma(id, sigmas);
      sessions[0].read(id, expected);
      sessions[0].read_sigma(id, expected_sigmas);
      for (int i = 0; i < 3; ++i) {
        CHECK(std::abs(outputs[i] - expected[i]) < 1e-7 * expected_sigmas[i]);
        CHECK(std::abs(sigmas[i] / expected_sigmas[i] - 1) < 1e-9);
      }
    }
  }
}

TEST_CASE("a session that was restored goes on bit for bit, and shows the P that it was restored to") {
  for (const char* form : forms) {
    const auto composition = ins(form);
    Session session(composition), other(composition);
    drive(session, 0, 40);
    const auto kept = bytes_of(session);
    const Eigen::MatrixXd P = session.covariance(FilterId{0}).as();
    drive(session, 40, 80);
    CHECK((Eigen::MatrixXd(session.covariance(FilterId{0}).as()).array() != P.array()).any());
    const auto end = bytes_of(session);
    session.restore(kept);
    CHECK((Eigen::MatrixXd(session.covariance(FilterId{0}).as()).array() == P.array()).all());
    other.restore(kept);
    for (Session* its : {&session, &other}) {
      drive(*its, 40, 80);
      CHECK(bytes_of(*its) == end);
    }
  }
}

TEST_CASE("the form is known, and is what the config says") {
  CHECK(composition_of(line())->filters()[0].covariance == "joseph");
  for (const char* form : forms) CHECK(composition_of(with_form(line(), form))->filters()[0].covariance == form);
  const std::string error = error_of(with_form(line(), "square"));
  CHECK(error.find("/filters/f/covariance") != std::string::npos);
  CHECK(error.find("joseph, ud or square_root; found 'square'") != std::string::npos);
  CHECK(composition_of(with_form(line(), "ud"))->hash() != composition_of(line())->hash());
}

TEST_CASE("a covariance to start from that is none stops a filter that keeps a factor, by name") {
  for (const char* form : forms) {
    const bool is_factored = std::string(form) != "joseph";
    CAPTURE(form);
    for (const double correlation : {0.5, 1.5}) {
      const Session session = started_with(correlation, with_form(from_covariance(), form));
      if (correlation < 1) CHECK(session.started({0}));
      if (correlation < 1 || !is_factored) continue;
      CHECK_FALSE(session.healthy({0}));
      CHECK(session.diagnosis({0}) == "the initial covariance is not positive semidefinite at 'x.x0'");
    }
  }
}

}  // namespace covariance_form_test
