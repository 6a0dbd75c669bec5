// SPDX-License-Identifier: Apache-2.0
// The page in headless Chromium: it renders, shows every figure as the JSON has it, and zooms.
#include "../catch.hpp"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include <sys/wait.h>
#include <unistd.h>

#include "browser.hpp"
#include "fixture.hpp"
#include "page_checks.hpp"
#include "report/page.hpp"

namespace page_test {

using namespace binnacle;
using namespace binnacle::test;

namespace {

/// Where a plot is, [left, top, width, height], scrolled into view.
Json place_of(Browser& browser, const std::string& plot) {
  browser.wait_for("(() => { const e = document.querySelector(`" + plot +
                   "`); e.scrollIntoView({ block: 'center' }); return !!e.dataset.from; })()");
  return browser.value_of("(() => { const r = document.querySelector(`" + plot +
                          " .plot`).getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()");
}

const std::string north = "[data-name=\"ins position.north error\"]", bias = "[data-name=\"ins gyro_bias.x\"]",
                  nis = "[data-name=\"ins fix.nis\"]", lanes = "[data-name=\"ins outcomes\"]";

/// [from, to] of a plot, once it has been drawn with the page's window.
Json window_of(Browser& browser, const std::string& plot) {
  const std::string element = "document.querySelector(`" + plot + "`)";
  const std::string bar = "document.getElementById('timebar')";
  browser.wait_for("(() => { const e = " + element +
                   "; e.scrollIntoView({ block: 'center' }); return !!e.dataset.from && e.dataset.from === " + bar +
                   ".dataset.from && e.dataset.to === " + bar + ".dataset.to; })()");
  return browser.value_of("[Number(" + element + ".dataset.from), Number(" + element + ".dataset.to)]");
}

}  // namespace

TEST_CASE("Page of a run: every figure of the summary, no word on the console, nothing fetched") {
  const auto chromium = browser();
  if (!chromium) return;
  const Folder folder;
  const std::string name = "</script><img src=x onerror=alert(1)> \"'&`${1}";
  const auto results = run_results(name, 5000);
  chromium->open(folder.write("page.html", report::page(results)));
  require_figures(*chromium, results.run->summary, "/run");
  REQUIRE(chromium->value_of("document.querySelectorAll('img').length") == Json(0));
  REQUIRE(chromium->value_of("document.body.textContent.includes('<b>min_speed</b>')") == Json(true));
  REQUIRE(chromium->value_of("document.body.textContent.includes('seed 18446744073709551615')") == Json(true));
  for (const int width : {1400, 390}) {
    chromium->size(width, 900);
    chromium->wait_for(
        "(() => { scrollBy(0, 700); return scrollY + innerHeight >= document.documentElement.scrollHeight - 2; })()");
    const Json too_wide = chromium->value_of(
        "[...document.querySelectorAll('main *')].filter((e) => e.getBoundingClientRect().right > innerWidth + 1 && "
        "!e.closest('.scroll')).map((e) => e.tagName + ' ' + (e.className.baseVal ?? e.className)).slice(0, 5)");
    INFO(width << ": " << too_wide);
    REQUIRE(chromium->value_of("document.documentElement.scrollWidth <= innerWidth") == Json(true));
    chromium->value_of("scrollTo(0, 0)");
  }
  chromium->wait_for(
      "(() => { document.querySelector('#states').scrollIntoView(); return document.querySelectorAll('.plot "
      "canvas').length > 3; })()");
  require_quiet(*chromium);
  require_alone(*chromium);
}

TEST_CASE("Page of a run: zoom by the mouse is that of all plots, and back") {
  const auto chromium = browser();
  if (!chromium) return;
  const Folder folder;
  chromium->open(folder.write("page.html", report::page(run_results("ins", 5000))));
  const Json all = window_of(*chromium, north);
  const Json place = place_of(*chromium, north);
  const double x = place[0], y = place[1], width = place[2], height = place[3];
  chromium->drag(x + 0.4 * width, y + height / 2, x + 0.6 * width, y + height / 2);
  chromium->wait_for("document.getElementById('timebar').dataset.from > " + all[0].dump());
  const Json zoomed = window_of(*chromium, north);
  REQUIRE(zoomed[0].get<double>() > all[0].get<double>() + 100);
  REQUIRE(zoomed[1].get<double>() < all[1].get<double>() - 100);
  for (const auto& plot : {bias, nis, lanes}) REQUIRE(window_of(*chromium, plot) == zoomed);
  REQUIRE(chromium->value_of("!!document.querySelector('.map .part')") == Json(true));
  const Json again = place_of(*chromium, north);
  chromium->double_click(again[0].get<double>() + 0.5 * width, again[1].get<double>() + height / 2);
  chromium->wait_for("Number(document.getElementById('timebar').dataset.from) === " + all[0].dump());
  for (const auto& plot : {bias, nis, lanes}) REQUIRE(window_of(*chromium, plot) == all);
  require_quiet(*chromium);
}

TEST_CASE("Page of a run: dark and light, by wish and by switch, and on paper") {
  const auto chromium = browser();
  if (!chromium) return;
  const Folder folder;
  chromium->open(folder.write("page.html", report::page(run_results("ins", 2000))));
  const std::string ground = "getComputedStyle(document.body).backgroundColor";
  chromium->prefer_dark(false);
  const Json light = chromium->value_of(ground);
  chromium->prefer_dark(true);
  const Json dark = chromium->value_of(ground);
  REQUIRE(light != dark);
  chromium->value_of("document.querySelector('.theme').click()");
  REQUIRE(chromium->value_of(ground) == light);
  chromium->value_of("document.querySelector('.theme').click()");
  chromium->prefer_dark(false);
  REQUIRE(chromium->value_of(ground) == dark);
  REQUIRE(chromium->printed().size() > 50'000);
  require_quiet(*chromium);
}

TEST_CASE("Page of a study: every figure, the paper's beside it, what broke") {
  const auto chromium = browser();
  if (!chromium) return;
  const Folder folder;
  const auto results = study_results();
  chromium->open(folder.write("page.html", report::page(results)));
  require_figures(*chromium, results.study->figures, "/study");
  REQUIRE(chromium->value_of("document.querySelectorAll('svg.distribution circle').length") == Json(59));
  REQUIRE(chromium->value_of("document.querySelector('td.paper').textContent") == Json("3.91"));
  REQUIRE(chromium->value_of("document.body.textContent.includes('the filter broke')") == Json(true));
  chromium->value_of("document.querySelectorAll('.controls input')[1].click()");
  REQUIRE(chromium->value_of("document.querySelectorAll('svg.distribution path').length") == Json(2));
  require_quiet(*chromium);
}

TEST_CASE("Page of a run and a study, with a filter that never started and a measurement without samples") {
  const auto chromium = browser();
  if (!chromium) return;
  const Folder folder;
  auto results = run_results("ins", 300);
  results.study = study_results().study;
  results::FilterResults idle;
  idle.name = "idle";
  idle.estimates = {{"position", "lat", "rad", "deg", true, {}, {}}, {"position", "lon", "rad", "deg", true, {}, {}}};
  idle.errors = {{"position.north", "m", "m", {}, {}, {}}};
  idle.updates.push_back({"fix", {{"position", "m"}}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}});
  results.run->filters.push_back(idle);
  results.run->summary["filters"]["idle"] = {{"steps", 0},
                                             {"filter_s", 0.0},
                                             {"reference", Json::object()},
                                             {"measurements", Json::object()}};
  chromium->open(folder.write("page.html", report::page(results)));
  chromium->wait_for(
      "(() => { scrollBy(0, 700); return scrollY + innerHeight >= document.documentElement.scrollHeight - 2; })()");
  REQUIRE(chromium->value_of("document.body.textContent.includes('never started')") == Json(true));
  require_figures(*chromium, results.run->summary, "/run");
  require_figures(*chromium, results.study->figures, "/study");
  require_quiet(*chromium);
}

TEST_CASE("Page of a million samples: usable") {
  const auto chromium = browser();
  if (!chromium) return;
  const Folder folder;
  const auto page = folder.write("page.html", report::page(run_results("ins", 1'000'000)));
  const auto begin = std::chrono::steady_clock::now();
  chromium->open(page);
  const Json all = window_of(*chromium, north);
  const double load = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const double zoom = chromium->value_of(
      "(async () => { const begin = performance.now(); const input = document.querySelector('#timebar input');"
      " input.value = 50000; input.dispatchEvent(new Event('change'));"
      " await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))); return "
      "performance.now() - begin; })()");
  REQUIRE(window_of(*chromium, north)[0] == Json(50000.0));
  WARN("a million samples: page of " << static_cast<double>(fs::file_size(page)) / 1e6 << " MB, loaded in " << load
                                     << " s, zoomed in " << zoom << " ms");
  REQUIRE(fs::file_size(page) < 6'000'000);  // what makes it usable; times are printed, and depend on the machine
  require_quiet(*chromium);
}

TEST_CASE("binnacle report: what the guide shows, and the quickstart's results as a page") {
  const Folder folder;
  const fs::path command = BINNACLE_TEST_COMMAND, project = BINNACLE_TEST_PROJECT;
  fs::create_directory_symlink(project / "configs", folder.path() / "configs");
  std::ifstream guide(project / "sdk/docs/report.md");
  std::string line,
      script = "cd '" + folder.path().string() + "' && PATH='" + command.parent_path().string() + "':\"$PATH\"",
      expected;
  while (std::getline(guide, line) && line != "```text") continue;
  while (std::getline(guide, line) && line != "```")
    if (line.starts_with("$ "))
      script += " && " + line.substr(2);
    else
      expected += line + "\n";
  INFO(script);
  REQUIRE(std::system(("{ " + script + "; } > '" + (folder.path() / "printed").string() + "'").c_str()) == 0);
  REQUIRE(contents(folder.path() / "printed") == expected);
  const std::string page = contents(folder.path() / "out/report.html");
  REQUIRE(std::system((command.string() + " report '" + (folder.path() / "out").string() + "' --json --output '" +
                       (folder.path() / "again.html").string() + "' > '" + (folder.path() / "answer").string() + "'")
                          .c_str()) == 0);
  REQUIRE(contents(folder.path() / "again.html") == page);
  REQUIRE(Json::parse(contents(folder.path() / "answer")) ==
          Json({{"page", (folder.path() / "again.html").string()}, {"bytes", page.size()}}));
  const auto chromium = browser();
  if (!chromium) return;
  chromium->open(folder.path() / "out/report.html");
  require_figures(*chromium, Json::parse(contents(folder.path() / "out/summary.json")), "/run");
  require_quiet(*chromium);
}

TEST_CASE("binnacle observe --out: the page shows what is seen, what is not, and what the filter only thinks so") {
  const Folder folder;
  const std::string command = BINNACLE_TEST_COMMAND, project = BINNACLE_TEST_PROJECT;
  const std::string out = (folder.path() / "out").string();
  REQUIRE(std::system((command + " observe '" + project +
                       "/configs/quickstart.json' --window :20 --window 40:60 --quiet --out '" + out + "'")
                          .c_str()) == 0);
  Json summary = Json::parse(contents(folder.path() / "out/summary.json"));
  auto& windows = summary["filters"]["ins"]["observability"];
  REQUIRE(windows.size() == 2);
  REQUIRE(windows[0]["inconsistent"].empty());
  const auto chromium = browser();
  if (!chromium) return;
  chromium->open(folder.path() / "out/report.html");
  require_figures(*chromium, summary, "/run");
  const std::string section = "document.querySelector('#observability').textContent";
  const Json text = chromium->value_of(section);
  for (const auto& window : windows)
    for (const auto& direction : window["weak"])
      REQUIRE(text.get<std::string>().find(direction["name"]) != std::string::npos);
  REQUIRE(chromium->value_of(section + ".includes('consistent')") == Json(true));
  require_quiet(*chromium);
}

TEST_CASE("binnacle run --smooth --out: what is smoothed is drawn over its filter, and has its own figures") {
  const Folder folder;
  const std::string command = BINNACLE_TEST_COMMAND, project = BINNACLE_TEST_PROJECT;
  const std::string out = (folder.path() / "out").string();
  REQUIRE(std::system((command + " run '" + project + "/configs/quickstart.json' --smooth --quiet --out '" + out + "'")
                          .c_str()) == 0);
  const auto chromium = browser();
  if (!chromium) return;
  chromium->open(folder.path() / "out/report.html");
  require_figures(*chromium, Json::parse(contents(folder.path() / "out/summary.json")), "/run");
  const auto is_overlaid = [&](const std::string& plot) {
    return chromium->value_of("!!document.querySelector(`[data-name=\"" + plot + "\"]`).item.spec.moving");
  };
  for (const char* name : {"position.north error", "attitude.down error", "gyro_bias.x"}) {
    CHECK(is_overlaid("ins " + std::string(name)) == Json(true));
    CHECK(is_overlaid("ins.smoothed " + std::string(name)) == Json(false));
  }
  const std::string plot = "document.querySelector(`[data-name=\"ins position.north error\"]`)";
  chromium->wait_for("(() => { " + plot + ".scrollIntoView(); return " + plot + ".item.moving?.t.length > 100; })()");
  CHECK(chromium->value_of("document.body.textContent.includes('The dark line is ins.smoothed.')") == Json(true));
  require_quiet(*chromium);
}

TEST_CASE("binnacle run --smooth --out: a table has the errors and NEES of filter and smoothed side by side") {
  const Folder folder;
  const std::string command = BINNACLE_TEST_COMMAND, project = BINNACLE_TEST_PROJECT;
  const std::string out = (folder.path() / "out").string();
  REQUIRE(std::system((command + " run '" + project + "/configs/quickstart.json' --smooth --quiet --out '" + out + "'")
                          .c_str()) == 0);
  const auto chromium = browser();
  if (!chromium) return;
  chromium->open(folder.path() / "out/report.html");
  const auto cells = [&](const std::string& table, const std::string& name) {
    return chromium->value_of("[...[...[...document.querySelectorAll('#filter-and-smoothed .table')][" + table +
                              "].querySelectorAll('tbody tr')].find((e) => e.firstChild.textContent === '" + name +
                              "').querySelectorAll('td')].map((e) => e.dataset.value || e.textContent)");
  };
  const Json filters = Json::parse(contents(folder.path() / "out/summary.json")).at("filters");
  const Json &before = filters.at("ins"), &after = filters.at("ins.smoothed");
  const auto is = [](const Json& cell, const Json& figure) {
    return std::stod(cell.get<std::string>()) == figure.get<double>();
  };
  for (const std::string name : {"position.horizontal", "attitude.yaw"}) {
    const Json shown = cells("0", name), &from = before["reference"][name], &to = after["reference"][name];
    INFO(name << ": " << shown);
    REQUIRE(shown.size() == 7);
    std::size_t at = 0;
    for (const char* key : {"rms", "max"}) {
      CHECK(is(shown[at], from[key]));
      CHECK(is(shown[at + 1], to[key]));
      const double ratio = to[key].get<double>() / from[key].get<double>();
      CHECK(std::abs(std::stod(shown[at + 2].get<std::string>()) - ratio) < 0.051 * ratio);
      at += 3;
    }
  }
  const Json shown = cells("1", "state");
  INFO(shown);
  CHECK(is(shown[0], before["consistency"]["state"]["nees_mean"]));
  CHECK(is(shown[4], after["consistency"]["state"]["nees_mean"]));
  // Of a filter by itself there is none.
  CHECK(chromium->value_of("[...document.querySelectorAll('h3')].filter((e) => e.textContent === 'Filter and "
                           "smoothed').length") == Json(1));
  require_quiet(*chromium);
}

TEST_CASE("Page of a run: a verdict's note stands under it") {
  const auto chromium = browser();
  if (!chromium) return;
  const Folder folder;
  auto results = run_results("ins", 300);
  results.run->summary["filters"]["ins"]["verdict"] = {
      {"state", "ok"},
      {"reasons", Json::array()},
      {"notes", {{{"code", "B128"}, {"measurement", "fix"}, {"text", "'fix' has a mean NIS"}}}}};
  chromium->open(folder.write("page.html", report::page(results)));
  CHECK(chromium->value_of("document.querySelector('.verdicts').textContent") ==
        Json("ins: okB128 'fix' has a mean NIS"));
  require_quiet(*chromium);
}

TEST_CASE("binnacle report: a folder without results is an error that states what to do") {
  const Folder folder;
  const std::string command = BINNACLE_TEST_COMMAND, answer = (folder.path() / "answer").string();
  const int status = std::system((command + " report '" + folder.path().string() + "' 2> '" + answer + "'").c_str());
  REQUIRE(WEXITSTATUS(status) == 5);
  REQUIRE(contents(answer).find("make one with 'binnacle run") != std::string::npos);
  REQUIRE(!fs::exists(folder.path() / "report.html"));
}

}  // namespace page_test
