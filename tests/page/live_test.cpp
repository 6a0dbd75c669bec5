// SPDX-License-Identifier: Apache-2.0
// The page of a run that goes on, in headless Chromium.
#include "../catch.hpp"

#include "paced_run.hpp"
#include "page_checks.hpp"

namespace live_test {

using namespace binnacle::test;

namespace {

const std::string latitude = "document.querySelector('[data-name=\"ins position.lat\"]')",
                  residual = "document.querySelector('[data-name=\"ins fix.position 0 residual\"]')";

/// Whether the page shows data up to t [s].
std::string shows(double t) { return "Number(document.getElementById('timebar').dataset.to) >= " + std::to_string(t); }

/// Scrolled to, so that it is drawn.
std::string drawn_until(const std::string& element, double t) {
  return "(() => { const e = " + element +
         "; if (!e) return false; e.scrollIntoView({ block: 'center' }); return Number(e.dataset.to) >= " +
         std::to_string(t) + " && Number(e.dataset.points) > 20; })()";
}

double number(Browser& browser, const std::string& expression) { return browser.value_of(expression).get<double>(); }

std::string ledger(const std::string& column) {
  return "Number(document.querySelector('[data-path=\"/run/filters/ins/measurements/fix/" + column +
         "\"]').dataset.value)";
}

const std::string track_length =
    "[...document.querySelectorAll('.map polyline')].reduce((n, l) => n + l.points.length, 0)";

}  // namespace

TEST_CASE("page: states, track, innovations and ledger grow while the run goes on, and the verdict comes at its end") {
  const auto chromium = browser();
  if (!chromium) return;
  PacedRun run({"--summary", "summary.json"});
  chromium->visit(run.url());
  run.open_until(60);
  chromium->wait_for(shows(60));
  REQUIRE(chromium->value_of("document.documentElement.dataset.live") == Json("goes on"));
  chromium->wait_for(drawn_until(latitude, 60));
  chromium->wait_for(drawn_until(residual, 60));
  const double fixes = number(*chromium, ledger("accepted")), track = number(*chromium, track_length);
  REQUIRE(fixes > 50);
  REQUIRE(fixes < 70);
  REQUIRE(track > 20);
  REQUIRE(chromium->value_of("!!document.querySelector('.verdicts .ok')") == Json(true));
  chromium->value_of("window.first = " + latitude + "; true");

  run.open_until(120);
  chromium->wait_for(shows(120));
  chromium->wait_for(drawn_until(latitude, 120));
  REQUIRE(number(*chromium, ledger("accepted")) >= fixes + 55);
  REQUIRE(number(*chromium, track_length) > track);

  run.open();
  chromium->wait_for("document.documentElement.dataset.live === 'over'");
  const auto outcome = run.wait();
  REQUIRE(outcome.status == 0);
  const Json summary = Json::parse(read_file(run.bench().path("summary.json")))["filters"]["ins"];
  REQUIRE(chromium->value_of("document.querySelector('.verdicts dt').textContent") ==
          Json("ins: " + summary["verdict"]["state"].get<std::string>()));
  REQUIRE(number(*chromium, ledger("accepted")) == summary["measurements"]["fix"]["accepted"].get<double>());
  REQUIRE(number(*chromium,
                 "Number(document.querySelector('[data-path=\"/run/filters/ins/reference/position.horizontal/"
                 "rms\"]').dataset.value)") == summary["reference"]["position.horizontal"]["rms"].get<double>());

  // The server is gone, and what it left can be used.
  chromium->wait_for(drawn_until(latitude, summary["end_s"].get<double>() - 0.5));
  REQUIRE(chromium->value_of("window.first === " + latitude) == Json(true));
  chromium->value_of("[...document.querySelectorAll('#timebar button')].find((b) => b.title === 'Zoom in').click()");
  chromium->wait_for("Number(document.getElementById('timebar').dataset.from) > 40");
  chromium->wait_for("(() => { const e = " + latitude +
                     "; e.scrollIntoView({ block: 'center' }); return Number(e.dataset.from) > 40; })()");
  require_quiet(*chromium);
}

TEST_CASE("page: what is opened and zoomed stays while data come") {
  const auto chromium = browser();
  if (!chromium) return;
  const PacedRun run;
  chromium->visit(run.url());
  run.open_until(60);
  chromium->wait_for(shows(60));
  chromium->value_of(
      "[...document.querySelectorAll('#timebar button')].find((b) => b.title === 'Zoom in').click();"
      "[...document.querySelectorAll('main details')].find((d) => d.textContent.includes('Config as run')).open = true;"
      "document.querySelector('main summary').focus(); window.focused = document.activeElement; true");
  chromium->wait_for("Number(document.getElementById('timebar').dataset.from) > 10");
  const std::string window =
      "[document.getElementById('timebar').dataset.from, document.getElementById('timebar').dataset.to].join()";
  const Json zoomed = chromium->value_of(window);
  const double fixes = number(*chromium, ledger("accepted"));
  run.open_until(100);
  chromium->wait_for(ledger("accepted") + " >= " + std::to_string(fixes + 35));
  REQUIRE(chromium->value_of(window) == zoomed);
  REQUIRE(
      chromium->value_of(
          "[...document.querySelectorAll('main details')].find((d) => d.textContent.includes('Config as run')).open") ==
      Json(true));
  REQUIRE(chromium->value_of("document.activeElement === window.focused && document.activeElement.isConnected") ==
          Json(true));
  require_quiet(*chromium);
}

TEST_CASE("page: a run that is gone is no run that goes on") {
  const auto chromium = browser();
  if (!chromium) return;
  PacedRun run;
  chromium->visit(run.url());
  run.open_until(30);
  chromium->wait_for(shows(30));
  run.kill();
  run.wait();
  chromium->wait_for(
      "document.documentElement.dataset.live === 'lost' && document.querySelector('.kind .badge').textContent === "
      "'connection lost'");
  REQUIRE(chromium->value_of(shows(30)) == Json(true));
}

TEST_CASE("page: it fetches nothing but itself and its events, and may fetch nothing else") {
  const auto chromium = browser();
  if (!chromium) return;
  const PacedRun run;
  chromium->visit(run.url());
  run.open_until(30);
  chromium->wait_for(shows(30));
  for (const auto& address : chromium->requests()) {
    INFO(address);
    REQUIRE((address == run.url() || address == run.url() + "events" || address.starts_with("data:")));
  }
  require_quiet(*chromium);
  REQUIRE(chromium->value_of("fetch('http://127.0.0.1:1/').then(() => 'fetched', () => 'refused')") == Json("refused"));
  REQUIRE(!chromium->console().empty());
  for (const auto& line : chromium->console()) {
    INFO(line);
    REQUIRE(line.find("Content Security Policy") != std::string::npos);
  }
}

TEST_CASE("page: a million instants, as fast as they go") {
  const auto chromium = browser();
  if (!chromium) return;
  PacedRun run({"--json", "--set", R"(/sources/drive/segments=[{"do": "still", "duration": "10000 s"}])"});
  chromium->visit(run.url());
  chromium->wait_for("document.documentElement.dataset.live === 'goes on'");
  run.open();
  const auto outcome = run.wait();
  chromium->wait_for("document.documentElement.dataset.live === 'over'");
  REQUIRE(outcome.status == 0);
  const Json summary = Json::parse(outcome.out)["filters"]["ins"];
  REQUIRE(summary["steps"].get<int>() > 999'000);
  REQUIRE(number(*chromium, ledger("accepted")) == summary["measurements"]["fix"]["accepted"].get<double>());
  chromium->wait_for(drawn_until(latitude, 9999));
  chromium->wait_for(drawn_until(residual, 9990));
  REQUIRE(number(*chromium, "Number(" + latitude + ".dataset.points)") < 2100);
  REQUIRE(number(*chromium, "document.getElementById('payload').textContent.length") < 100'000);
  require_quiet(*chromium);
}

}  // namespace live_test
