// SPDX-License-Identifier: Apache-2.0
// binnacle tune: what it writes, what it refuses, and each objective on a place that wanders.
#include "catch.hpp"

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace verb_test {

using namespace binnacle::test;
using nlohmann::json;

namespace {

constexpr double true_q = 0.5, true_sigma = 0.3;
constexpr const char* q_at = "/filters/walk/process/wander/q";
constexpr const char* sigma_at = "/filters/walk/measurements/seen/sigma";

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// NAME.csv of fixes, NAME-truth.csv of the place.
void simulate(const Workbench& bench, const std::string& name, unsigned seed, bool has_outliers = false,
              double tau = std::numeric_limits<double>::infinity(), int period_of_outliers = 20) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::string fixes = "t,place\n", truth = fixes;
  const double keeps = std::exp(-1 / tau);
  double place = 0;
  for (int k = 0; k < 400; ++k) {
    const double noise = has_outliers && k % period_of_outliers == 7 % period_of_outliers
                             ? 20 * (k % (2 * period_of_outliers) < period_of_outliers ? 1 : -1)
                             : true_sigma * normal(random);
    const double step = std::isfinite(tau) ? 2 * std::sqrt(1 - keeps * keeps) : true_q;
    place = keeps * place + step * normal(random);
    fixes += std::to_string(k) + "," + std::to_string(place + noise) + "\n";
    truth += std::to_string(k) + "," + std::to_string(place) + "\n";
  }
  bench.write(name + ".csv", fixes);
  bench.write(name + "-truth.csv", truth);
}

/// Both noises ten times off.
json config(const std::string& data = "a") {
  json base = json::parse(good_config);
  base["sources"]["fix"]["path"] = data + ".csv";
  base["sources"]["truth"]["path"] = data + "-truth.csv";
  base["filters"]["walk"]["process"]["wander"]["q"] = "0.05 m/sqrt(s)";
  base["filters"]["walk"]["measurements"]["seen"]["sigma"] = json::array({"3 m"});
  base["filters"]["walk"]["measurements"]["seen"].erase("gate");
  base.erase("evaluate");
  base["tune"]["parameters"] = {{q_at, json::object()}, {sigma_at, json::object()}};
  return base;
}

json tuned(const Workbench& bench, const json& config, std::vector<std::string> more = {}, int status = 0) {
  bench.write("c.json", config.dump());
  std::vector<std::string> words{"tune", "c.json", "--json"};
  words.insert(words.end(), more.begin(), more.end());
  const auto outcome = binnacle::test::binnacle(bench, words);
  INFO(outcome.err);
  REQUIRE(outcome.status == status);
  return json::parse(outcome.out);
}

double number(const json& value) {
  return value.is_string() ? std::stod(value.get<std::string>()) : value.get<double>();
}

const json& parameter_of(const json& result, const std::string& name) {
  for (const auto& parameter : result.at("parameters"))
    if (parameter.at("name") == name) return parameter;
  throw std::out_of_range(name);
}

double end_of(const json& result, const std::string& name) { return number(parameter_of(result, name).at("end")); }

/// Both within three of their standard errors, which are about 5 % and 10 %.
void is_true(const json& result) {
  CHECK(std::abs(std::log(end_of(result, q_at) / true_q)) < 0.2);
  CHECK(std::abs(std::log(end_of(result, std::string(sigma_at) + "/0") / true_sigma)) < 0.3);
}

void is_refused(const Workbench& bench, const json& config, int status, const std::string& code,
                const std::string& message) {
  bench.write("c.json", config.dump());
  const auto outcome = binnacle::test::binnacle(bench, {"tune", "c.json"});
  INFO(outcome.err);
  CHECK(outcome.status == status);
  CHECK(has(outcome.err, "[" + code + "]"));
  CHECK(has(outcome.err, message));
  CHECK(outcome.out.empty());
}

}  // namespace

TEST_CASE("tune finds both noises, and writes a patch that extends takes") {
  const Workbench bench;
  simulate(bench, "a", 1);
  const json result = tuned(bench, config(), {"--write", "tuned.json"});
  is_true(result);
  CHECK(result.at("converged") == true);
  CHECK(result.at("gradient_error").get<double>() < 1e-7);
  CHECK(result.at("value").at("end").get<double>() > result.at("value").at("start").get<double>() + 100);
  const json patch = json::parse(read_file(bench.path("tuned.json")));
  CHECK(number(patch.at("filters").at("walk").at("process").at("wander").at("q")) ==
        Approx(end_of(result, q_at)).epsilon(1e-5));
  CHECK(patch.at("filters").at("walk").at("measurements").at("seen").at("sigma").size() == 1);
  bench.write("after.json", R"({"extends": ["c.json", "tuned.json"]})");
  const auto again = json::parse(binnacle::test::binnacle(bench, {"tune", "after.json", "--json"}).out);
  for (const auto& parameter : again.at("parameters"))
    CHECK(number(parameter.at("end")) == Approx(number(parameter.at("start"))).epsilon(1e-3));
  const auto run = binnacle::test::binnacle(bench, {"run", "after.json", "--json"});
  REQUIRE(run.status == 0);
  const auto nis = json::parse(run.out).at("filters").at("walk").at("measurements").at("seen").at("nis_mean");
  CHECK(nis.get<double>() == Approx(1).margin(0.2));
}

TEST_CASE("tune refuses what nothing excites, and gives the others") {
  const Workbench bench;
  simulate(bench, "a", 1);
  json with_ghost = config();
  json& filter = with_ghost["filters"]["walk"];
  filter["blocks"]["ghost"] = {{"type", "vector"}, {"size", 1}, {"unit", "m"}, {"sigma", "1 m"}};
  filter["process"]["haunt"] = {{"type", "random_walk"}, {"blocks", {{"x", "ghost"}}}, {"q", "0.1 m/sqrt(s)"}};
  with_ghost["tune"]["parameters"]["/filters/walk/process/haunt/q"] = json::object();
  const json result = tuned(bench, with_ghost, {"--write", "tuned.json"}, 1);
  is_true(result);
  REQUIRE(result.at("undetermined").size() == 1);
  CHECK(result.at("undetermined")[0].at("direction").size() == 1);
  CHECK(std::abs(result.at("undetermined")[0].at("direction").at("/filters/walk/process/haunt/q").get<double>()) >
        0.99);
  CHECK(parameter_of(result, "/filters/walk/process/haunt/q").at("state") == "not determined");
  CHECK_FALSE(parameter_of(result, "/filters/walk/process/haunt/q").contains("end"));
  CHECK_FALSE(has(read_file(bench.path("tuned.json")), "haunt"));
  const auto outcome = binnacle::test::binnacle(bench, {"tune", "c.json", "--quiet"});
  CHECK(outcome.out.empty());
  CHECK(has(outcome.err, "not determined and not changed: /filters/walk/process/haunt/q"));
}

TEST_CASE("tune names the direction where only a sum is known") {
  const Workbench bench;
  simulate(bench, "a", 1);
  json sum = config();
  json& filter = sum["filters"]["walk"];
  filter["blocks"]["place"]["size"] = 2;
  filter["blocks"]["place"]["init"] = {0, 0};
  filter["process"]["wander"]["q"] = {0.3, 0.3};
  filter["measurements"]["seen"]["H"] = {{1, 1}};
  sum.erase("reference");
  const json result = tuned(bench, sum, {}, 1);
  REQUIRE(result.at("undetermined").size() == 1);
  const json& direction = result.at("undetermined")[0].at("direction");
  REQUIRE(direction.size() == 2);
  const std::string name = q_at;
  CHECK(direction.at(name + "/0").get<double>() * direction.at(name + "/1").get<double>() < 0);
  CHECK(std::abs(std::log(end_of(result, std::string(sigma_at) + "/0") / true_sigma)) < 0.3);

  // One number for both is known.
  sum["tune"]["parameters"][q_at] = {{"elements", "together"}};
  const json together = tuned(bench, sum);
  CHECK(end_of(together, name + "/0") == Approx(true_q / std::sqrt(2)).epsilon(0.2));
}

TEST_CASE("refusing data does not pass for likelihood") {
  const Workbench bench;
  simulate(bench, "a", 1, true);
  json gated = config();
  gated["filters"]["walk"]["measurements"]["seen"]["gate"] = 0.999;
  gated["filters"]["walk"]["measurements"]["seen"]["sigma"] = {"0.03 m"};
  const json result = tuned(bench, gated);
  is_true(result);
  CHECK(result.at("rounds").back().at("gates") == "as configured");
  CHECK(result.at("rounds").back().at("refused").get<int>() >= 20);
  CHECK(result.at("rounds").back().at("samples").get<int>() >= 370);
  // The start accepts the third of the rows that suits it, and finds them likelier.
  const json& likelihood = result.at("judged").at("used").at("likelihood");
  CHECK(likelihood.at("end").get<double>() < likelihood.at("start").get<double>() - 2);
  CHECK(result.at("lowered") == false);
}

// A ninth of the fixes are outliers, which the gate refuses: the rounds go without gates, and take them for noise.
TEST_CASE("values that lower the likelihood are not written without --force") {
  const Workbench bench;
  simulate(bench, "a", 5, true, std::numeric_limits<double>::infinity(), 9);
  json gated = config();
  json& filter = gated["filters"]["walk"];
  filter["measurements"]["seen"]["gate"] = 0.999;
  filter["measurements"]["seen"]["sigma"] = {"0.3 m"};
  filter["process"]["wander"]["q"] = "0.5 m/sqrt(s)";
  const json result = tuned(bench, gated, {"--write", "patch.json"}, 1);
  CHECK(result.at("lowered") == true);
  const json& likelihood = result.at("judged").at("used").at("likelihood");
  CHECK(likelihood.at("end").get<double>() < likelihood.at("start").get<double>() - 2);
  CHECK_FALSE(std::filesystem::exists(bench.path("patch.json")));
  const auto outcome = binnacle::test::binnacle(bench, {"tune", "c.json", "--quiet"});
  CHECK(outcome.status == 1);
  CHECK(has(outcome.err, "lower the ln likelihood of the "));
  CHECK(has(outcome.err, "--force writes it"));
  CHECK(tuned(bench, gated, {"--write", "patch.json", "--force"}).at("lowered") == true);
  CHECK(std::filesystem::exists(bench.path("patch.json")));
}

TEST_CASE("a start that was as good is said to be") {
  const Workbench bench;
  simulate(bench, "a", 1);
  json good = config();
  good["filters"]["walk"]["measurements"]["seen"]["sigma"] = {"0.3 m"};
  good["filters"]["walk"]["process"]["wander"]["q"] = "0.5 m/sqrt(s)";
  CHECK(tuned(bench, good).at("lowered") == false);
  const auto outcome = binnacle::test::binnacle(bench, {"tune", "c.json"});
  CHECK(has(outcome.out, "determined; the start was as good"));
}

TEST_CASE("what is no noise is tuned by differences of runs, with refused samples frozen") {
  const Workbench bench;
  simulate(bench, "a", 2, true, 8);
  json markov = config();
  json& filter = markov["filters"]["walk"];
  filter["process"]["wander"] = {{"type", "gauss_markov"},
                                 {"blocks", {{"x", "place"}}},
                                 {"tau", "2 s"},
                                 {"sigma", "2 m"}};
  filter["measurements"]["seen"]["sigma"] = {"0.5 m"};
  filter["measurements"]["seen"]["gate"] = 0.999;
  markov["tune"]["parameters"] = {{"/filters/walk/process/wander/tau", json::object()}, {sigma_at, json::object()}};
  const json result = tuned(bench, markov);
  CHECK(parameter_of(result, "/filters/walk/process/wander/tau").at("noise") == false);
  CHECK(parameter_of(result, std::string(sigma_at) + "/0").at("noise") == true);
  const double error = parameter_of(result, "/filters/walk/process/wander/tau").at("standard_error");
  CHECK(error < 0.3);
  CHECK(std::abs(std::log(end_of(result, "/filters/walk/process/wander/tau") / 8)) < 3 * error);
  CHECK(std::abs(std::log(end_of(result, std::string(sigma_at) + "/0") / true_sigma)) < 0.35);
}

TEST_CASE("withheld samples and metrics are objectives too") {
  const Workbench bench;
  simulate(bench, "a", 1);
  json withheld = config();
  withheld["filters"]["walk"]["measurements"]["seen"]["withhold"] = {{"every", 2}};
  withheld["tune"]["objective"] = {{"withheld", "nll"}};
  is_true(tuned(bench, withheld));
  withheld["tune"]["objective"] = {{"withheld", "rms"}};
  withheld["tune"]["parameters"] = {{q_at, json::object()}};
  const json rms = tuned(bench, withheld);
  CHECK(rms.at("value").at("end").get<double>() < rms.at("value").at("start").get<double>() - 10);
  json metric = config();
  metric["tune"]["objective"] = {{"metric", "walk/place.x/rms"}};
  metric["tune"]["parameters"] = {{q_at, json::object()}};
  const json result = tuned(bench, metric);
  metric["tune"]["until"] = "start+299.5 s";
  bench.write("until.json", metric.dump());
  const auto refused = binnacle::test::binnacle(bench, {"tune", "until.json"});
  CHECK(refused.status == 3);
  CHECK(refused.err.find("/tune/until: a metric takes its time span from 'evaluate'") != std::string::npos);
  // The gain has a best ratio of the two: the sigma that it has is ten times too large.
  CHECK(std::abs(std::log(end_of(result, q_at) / (10 * true_q))) < 0.7);
  CHECK_FALSE(result.at("parameters")[0].contains("standard_error"));
}

TEST_CASE("several configs together, and one that was not used") {
  const Workbench bench;
  for (const char* name : {"a", "b", "d"}) {
    simulate(bench, name, static_cast<unsigned>(name[0]));
    json one = config(name);
    one.erase("tune");
    bench.write(std::string(name) + ".json", one.dump());
  }
  json over = config();
  over["tune"]["over"] = {"a.json", "b.json"};
  over["tune"]["unseen"] = {"d.json"};
  over["tune"]["restarts"] = 1;
  const json result = tuned(bench, over);
  is_true(result);
  CHECK(result.at("rounds").back().at("rows") == 800);
  CHECK(result.at("restarts").size() == 1);
  const json& unseen = result.at("judged").at("unseen").at("d.json");
  CHECK(unseen.at("likelihood").at("rows") == 400);
  CHECK(unseen.at("likelihood").at("end").get<double>() > unseen.at("likelihood").at("start").get<double>() + 100);
  CHECK(unseen.at("measurements").at("walk/seen").at("end").at("nis_per_row").get<double>() == Approx(1).margin(0.2));

  json until = config();
  until["tune"]["until"] = "start+299.5 s";
  const json part = tuned(bench, until);
  CHECK(part.at("rounds").back().at("rows") == 300);
  CHECK(part.at("judged").at("unseen").at("after 'until'").at("likelihood").at("rows") == 100);
}

TEST_CASE("restarts run at one time, each on its own, and the likeliest end wins") {
  const Workbench bench;
  simulate(bench, "a", 1);
  json restarted = config();
  restarted["tune"]["restarts"] = 3;
  json one = tuned(bench, restarted, {"--jobs", "1"}), four = tuned(bench, restarted, {"--jobs", "4"});
  for (json* result : {&one, &four}) result->erase("wall_s");
  CHECK(one == four);
  const json alone = tuned(bench, config());
  REQUIRE(one.at("restarts").size() == 3);
  CHECK(one.at("evaluations").get<int>() > 2 * alone.at("evaluations").get<int>());
  CHECK(one.at("runs").get<int>() > 2 * alone.at("runs").get<int>());
  for (const json& end : one.at("restarts"))
    for (const auto& [name, value] : end.at("end").items())
      CHECK(number(value) == Approx(number(parameter_of(alone, name).at("end"))).epsilon(0.01));
  CHECK(one.at("value").at("end").get<double>() >= alone.at("value").at("end").get<double>() - 0.01);
}

TEST_CASE("bounds and priors hold") {
  const Workbench bench;
  simulate(bench, "a", 1);
  json bounded = config();
  bounded["tune"]["parameters"][q_at]["bounds"] = {"0.01 m/sqrt(s)", "0.2 m/sqrt(s)"};
  const json result = tuned(bench, bounded);
  CHECK(end_of(result, q_at) == Approx(0.2).epsilon(1e-3));
  CHECK(parameter_of(result, q_at).at("state") == "at its bound");
  json prior = config();
  prior["tune"]["parameters"][q_at]["prior"] = {{"value", "0.1 m/sqrt(s)"}, {"factor", 1.001}};
  CHECK(end_of(tuned(bench, prior), q_at) == Approx(0.1).epsilon(0.02));
}

TEST_CASE("tune reports mistakes at their places") {
  const Workbench bench;
  simulate(bench, "a", 1);
  json wrong = config();
  wrong["tune"]["objectiv"] = "likelihood";
  is_refused(bench, wrong, 3, "B012", "did you mean 'objective'?");
  const auto check = binnacle::test::binnacle(bench, {"check", "c.json"});
  CHECK(check.status == 3);
  CHECK(has(check.err, "did you mean 'objective'?"));
  wrong = config();
  wrong["tune"]["parameters"]["/filters/walk/process/wander/sigma"] = json::object();
  is_refused(bench, wrong, 3, "B027", "there is nothing at '/filters/walk/process/wander/sigma'");
  wrong = config();
  wrong["tune"]["parameters"][q_at]["bounds"] = {"1 s", "2 s"};
  is_refused(bench, wrong, 3, "B008", "is in 'm/sqrt(s)'");
  wrong = config();
  wrong.erase("tune");
  is_refused(bench, wrong, 3, "B010", "missing key 'tune'");
  wrong = config();
  wrong["filters"]["walk"]["measurements"]["seen"]["noise"] = {{"type", "sage_husa"}};
  is_refused(bench, wrong, 3, "B130", "R of 'seen' is made of its innovations");
  wrong = config();
  wrong["tune"]["objective"] = "withheld";
  is_refused(bench, wrong, 3, "B131", "no sample was withheld");
}

}  // namespace verb_test
