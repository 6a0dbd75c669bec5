// SPDX-License-Identifier: Apache-2.0
// Several runs: what differs, as JSON and on a page in headless Chromium, and from the command.
#include "../catch.hpp"

#include <algorithm>
#include <cstdlib>

#include <sys/wait.h>

#include "browser.hpp"
#include "fixture.hpp"
#include "page_checks.hpp"
#include "report/comparison.hpp"
#include "track.hpp"

namespace comparison_test {

using namespace binnacle;
using namespace binnacle::test;
using report::Comparison;
using report::NamedRun;

namespace {

NamedRun named(const std::string& name, const std::string& filter = "ins", std::size_t samples = 3000) {
  NamedRun run{name, "folder/" + name, *run_results(filter, samples).run};
  run.run.summary["filters"][filter]["verdict"] = {{"state", "ok"}, {"reasons", Json::array()}};
  return run;
}

/// The first as it is; of the second the rms is larger, a key of the config another, one is missing, and it is doubtful.
std::vector<NamedRun> two_runs() {
  std::vector<NamedRun> runs{named("before"), named("after")};
  Json& summary = runs[1].run.summary["filters"]["ins"];
  summary["reference"]["position.north"]["rms"] = 0.9571;
  summary["reference"].erase("position.east");
  summary["verdict"] = {{"state", "doubtful"}, {"reasons", Json::array({{{"code", "B101"}, {"text", "NIS"}}})}};
  runs[1].run.config["evaluate"]["windows"]["outage"][1] = "60 s";
  runs[1].run.config["study"] = {{"runs", 3}};
  return runs;
}

Json metric(const Comparison& comparison, const std::string& name) {
  for (const auto& entry : comparison.json()["metrics"])
    if (entry["name"] == name) return entry;
  return nullptr;
}

bool lacks(const Comparison& comparison, const std::string& text) {
  const auto& list = comparison.json()["lacks"];
  return std::any_of(list.begin(), list.end(),
                     [&](const Json& entry) { return entry.get<std::string>().find(text) != std::string::npos; });
}

}  // namespace

TEST_CASE("Comparison: a difference is a run's less the first's, in one unit, and nothing where one has none") {
  auto runs = two_runs();
  runs[1].run.summary["filters"]["ins"]["windows"]["outage"]["position.horizontal"]["unit"] = "km";
  const Comparison comparison(runs, {});
  const Json north = metric(comparison, "ins/position.north/rms");
  CHECK(north["unit"] == "m");
  CHECK(north["values"] == Json({0.7071, 0.9571}));
  CHECK(north["differences"][0].is_null());
  CHECK(std::abs(north["differences"][1].get<double>() - 0.25) < 1e-12);
  const Json east = metric(comparison, "ins/position.east/rms");
  CHECK(east["values"][1].is_null());
  CHECK(east["differences"][1].is_null());
  const Json window = metric(comparison, "ins/windows/outage/position.horizontal/rms");
  CHECK(window["values"].size() == 2);
  CHECK(window["differences"][1].is_null());
  CHECK(window["unit"] == "each its own");
  CHECK(metric(comparison, "ins/fix/nis_mean")["differences"][1] == 0.0);
  CHECK(metric(comparison, "ins/position/nees_mean")["values"][0] == 2.0001);
  // What the computer took, and a seed, are no figures.
  CHECK(metric(comparison, "ins/filter_s").is_null());
  CHECK(metric(comparison, "wall_s").is_null());
}

TEST_CASE("Comparison: configs differ by pointer, verdicts by state and code") {
  const auto runs = two_runs();
  const Comparison comparison(runs, {});
  const Json& config = comparison.json()["config"];
  REQUIRE(config.size() == 2);
  CHECK(config[0] == Json({{"pointer", "/evaluate/windows/outage/1"}, {"values", {"50 s", "60 s"}}}));
  CHECK(config[1] == Json({{"pointer", "/study"}, {"values", {nullptr, {{"runs", 3}}}}}));
  const Json& verdict = comparison.json()["verdicts"][0];
  CHECK(verdict["states"] == Json({"ok", "doubtful"}));
  CHECK(verdict["codes"][1] == Json({"B101"}));
}

TEST_CASE("Comparison: filters by name, by pair, and what has no counterpart is listed") {
  const std::vector<NamedRun> runs{named("a", "ins"), named("b", "other")};
  const Comparison apart(runs, {});
  REQUIRE(apart.json()["filters"].size() == 2);
  CHECK(apart.json()["filters"][0]["of"] == Json({"ins", nullptr}));
  CHECK(apart.json()["filters"][1]["of"] == Json({nullptr, "other"}));
  CHECK(lacks(apart, "'b' has no filter 'ins'"));
  CHECK(lacks(apart, "'a' has no filter 'other'"));
  const Comparison paired(runs, {{"ins", "other"}});
  REQUIRE(paired.json()["filters"].size() == 1);
  CHECK(paired.json()["filters"][0]["of"] == Json({"ins", "other"}));
  CHECK(metric(paired, "ins/position.north/rms")["differences"][1] == 0.0);
  CHECK(paired.json()["lacks"].empty());
  CHECK_THROWS_WITH(Comparison(runs, {{"inz", "other"}}), "--pair inz=other: 'a', the first run, has no filter 'inz'");
  CHECK_THROWS_WITH(Comparison(runs, {{"ins", "inz"}}),
                    "--pair ins=inz: none of the runs after the first has a filter 'inz'");
}

TEST_CASE("Comparison: a quantity that one run lacks, and times that do not overlap, are listed") {
  auto runs = two_runs();
  auto& filter = runs[1].run.filters[0];
  filter.errors.erase(filter.errors.begin());  // position.north
  filter.updates.clear();
  for (auto& t : filter.t) t += 1e6;
  const Comparison comparison(runs, {});
  CHECK(lacks(comparison, "'after': filter 'ins' has no error position.north, which others have"));
  CHECK(lacks(comparison, "'after': filter 'ins' has no measurement fix, which others have"));
  CHECK(lacks(comparison, "is of another time"));
}

TEST_CASE("Track about another origin: the same places") {
  const auto runs = two_runs();
  const auto& filter = runs[0].run.filters[0];
  const auto own = report::track_of(filter);
  const auto shifted = report::track_of(filter, report::TrackOrigin{own->lat - 1e-5, own->lon + 2e-5});
  // A radian of the meridian and of the parallel at 0.8 rad: 6 368 and 4 452 km, to a part in a thousand.
  CHECK(std::abs((shifted->estimate.north[0] - own->estimate.north[0]) / (1e-5 * 6368e3) - 1) < 1e-3);
  CHECK(std::abs((shifted->estimate.east[0] - own->estimate.east[0]) / (-2e-5 * 4451.5e3) - 1) < 1e-3);
}

TEST_CASE("Page of two runs: every figure, curves of both over each other, nothing fetched") {
  const auto chromium = browser();
  if (!chromium) return;
  const Folder folder;
  auto runs = two_runs();
  runs[1].name = "</script><b>after";
  for (auto& lat : runs[1].run.filters[0].estimates[0].values) lat += 1e-6;  // 6.4 m to the north
  const Comparison comparison(runs, {});
  chromium->open(folder.write("page.html", comparison.page()));
  // That both are on it, with their own figures too.
  require_figures(*chromium, {{"metrics", comparison.json()["metrics"]}}, "/comparison");
  for (const auto& run : runs)
    require_figures(
        *chromium, run.run.summary["filters"]["ins"], "/run/filters/" + [&] {
          std::string token;
          for (const char c : run.name + ": ins") token += c == '/' ? "~1" : std::string(1, c);
          return token;
        }());
  const auto plot = [&](const std::string& name) {
    const std::string element = "document.querySelector(`[data-name=\"" + name + "\"]`)";
    chromium->wait_for("(() => { const e = " + element +
                       "; e.scrollIntoView({ block: 'center' }); return !!e.item.curves && !!e.dataset.points; })()");
    return chromium->value_of(element + ".item.curves.map((c) => [c.t.length > 100, c.rows.length > 100, !!c.s])");
  };
  CHECK(plot("ins position.north error of all") == Json({{true, true, true}, {true, true, true}}));
  CHECK(plot("ins position.lat sigma of all") == Json({{true, true, false}, {true, true, false}}));
  CHECK(plot("ins gyro_bias.x of all") == Json({{true, true, false}, {true, true, false}}));
  CHECK(plot("ins position.nees of all").size() == 2);
  CHECK(plot("ins fix.nis of all").size() == 2);
  CHECK(chromium->value_of(
            "document.querySelectorAll('figure[data-name=\"ins of all runs track\"] [data-run]').length") == Json(2));
  // North is up: the second lies above, by what it was moved.
  const Json up = chromium->value_of(
      "(() => { const map = document.querySelector('figure[data-name=\"ins of all runs track\"]'); const [a, b] = "
      "[...map.querySelectorAll('[data-run] polyline')].map((line) => Number(line.getAttribute('points').split(' "
      "')[0].split(',')[1])); return a - b; })()");
  CHECK(up.get<double>() > 1);
  CHECK(chromium->value_of("document.body.textContent.includes('/evaluate/windows/outage/1')") == Json(true));
  CHECK(chromium->value_of("document.body.textContent.includes('doubtful (B101)')") == Json(true));
  CHECK(chromium->value_of("document.querySelectorAll('main b > b, main script').length") == Json(0));
  for (const int width : {1400, 390}) {
    chromium->size(width, 900);
    chromium->value_of("scrollTo(0, 0)");
    chromium->wait_for(
        "(() => { scrollBy(0, 700); return scrollY + innerHeight >= document.documentElement.scrollHeight - 2; })()");
    CHECK(chromium->value_of("document.documentElement.scrollWidth <= innerWidth") == Json(true));
  }
  require_quiet(*chromium);
  require_alone(*chromium);
}

TEST_CASE("Page of runs of which one lacks errors, measurements and a track: still a page, and it is said") {
  const auto chromium = browser();
  if (!chromium) return;
  const Folder folder;
  std::vector<NamedRun> runs{named("a"), named("b"), named("c", "lone")};
  auto& filter = runs[1].run.filters[0];
  filter.errors.clear();
  filter.updates.clear();
  filter.estimates.erase(filter.estimates.begin(), filter.estimates.begin() + 2);
  const Comparison comparison(runs, {});
  chromium->open(folder.write("page.html", comparison.page()));
  chromium->wait_for(
      "(() => { scrollBy(0, 700); return scrollY + innerHeight >= document.documentElement.scrollHeight - 2; })()");
  CHECK(chromium->value_of("document.querySelectorAll('.lacks li').length") == Json(comparison.json()["lacks"].size()));
  CHECK(chromium->value_of(
            "document.querySelector('[data-name=\"ins position.north error of all\"]').item.spec.curves.length") ==
        Json(1));
  CHECK(chromium->value_of(
            "document.querySelector('[data-name=\"ins gyro_bias.x of all\"]').item.spec.curves.length") == Json(2));
  require_quiet(*chromium);
}

TEST_CASE("binnacle report of one folder has nothing of a comparison, and of several names what differs") {
  const Folder folder;
  const std::string command = BINNACLE_TEST_COMMAND, project = BINNACLE_TEST_PROJECT;
  const auto run = [&](const std::string& arguments) {
    const int status = std::system(
        ("cd '" + folder.path().string() + "' && '" + command + "' " + arguments + " > answer 2> said").c_str());
    return WEXITSTATUS(status);
  };
  const std::string config = "'" + project + "/configs/quickstart.json'";
  REQUIRE(run("run " + config + " --quiet --out a") == 0);
  REQUIRE(run("run " + config + " --quiet --out b --set '/filters/ins/process/strapdown/gyro_noise=3 deg/sqrt(h)'") ==
          0);
  CHECK(contents(folder.path() / "a/report.html").find("OverlayPlot") == std::string::npos);
  REQUIRE(run("report a b --json") == 0);
  const Json said = Json::parse(contents(folder.path() / "answer"));
  CHECK(said["page"] == "comparison.html");
  CHECK(said["bytes"] == fs::file_size(folder.path() / "comparison.html"));
  REQUIRE(said["config"].size() == 1);
  CHECK(said["config"][0] == Json({{"pointer", "/filters/ins/process/strapdown/gyro_noise"},
                                   {"values", {"0.3 deg/sqrt(h)", "3 deg/sqrt(h)"}}}));
  CHECK(said["runs"][1]["name"] == "b");
  CHECK(said["lacks"].empty());
  // A folder against itself: no difference at all; its two names are told apart.
  REQUIRE(run("report a a/ --output self.html --json") == 0);
  const Json self = Json::parse(contents(folder.path() / "answer"));
  CHECK(self["config"].empty());
  CHECK(self["runs"][0]["name"] != self["runs"][1]["name"]);
  for (const auto& entry : self["metrics"])
    if (!entry["values"][0].is_null()) CHECK(entry["differences"][1] == 0.0);
  fs::remove(folder.path() / "comparison.html");
  const auto refused = [&](const std::string& arguments, int status, const std::string& message) {
    INFO(arguments);
    CHECK(run(arguments) == status);
    CHECK(contents(folder.path() / "said").find(message) != std::string::npos);
    CHECK_FALSE(fs::exists(folder.path() / "comparison.html"));
  };
  refused("report a none", 5, "'none' is not a folder");
  refused("report a b --pair ins", 2, "--pair takes FIRST=OTHER");
  refused("report a b --pair ins=inz", 2, "none of the runs after the first has a filter 'inz'");
  refused("report a --pair ins=inz", 2, "one folder was given");
  fs::create_directory(folder.path() / "c");
  refused("report a c", 5, "holds neither run.nc nor study.nc");
  fs::resize_file(folder.path() / "b/run.nc", fs::file_size(folder.path() / "b/run.nc") / 2);
  refused("report a b", 5, "b/run.nc' cannot be read");
}

}  // namespace comparison_test
