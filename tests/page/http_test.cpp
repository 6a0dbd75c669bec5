// SPDX-License-Identifier: Apache-2.0
// The page's server: what it serves, what it refuses, and clients that are slow, many, or gone.
#include "../catch.hpp"

#include <chrono>
#include <list>
#include <optional>
#include <thread>

#include <nlohmann/json.hpp>

#include "paced_run.hpp"

namespace http_test {

using namespace binnacle::test;
using Json = nlohmann::ordered_json;

namespace {

std::string get(const PacedRun& run, const std::string& target) {
  return "GET " + target + " HTTP/1.1\r\nHost: " + run.host() + "\r\n\r\n";
}

std::string with_host(const std::string& host) { return "GET / HTTP/1.1\r\nHost: " + host + "\r\n\r\n"; }

/// "404"
std::string status_of(const PacedRun& run, const std::string& request) {
  const std::string text = answer(run.port(), request);
  return text.size() > 12 ? text.substr(9, 3) : "none";
}

Json event(Client& viewer) {
  viewer.until("data: ");
  return Json::parse(viewer.until("\n\n"));
}

double end_of(const Json& payload) {
  const Json& span = payload["run"]["filters"][0]["span"];
  return span.is_null() ? 0 : span[1].get<double>();
}

/// The first event with data up to t [s].
Json event_until(Client& viewer, double t) {
  for (;;)
    if (Json payload = event(viewer); end_of(payload) >= t) return payload;
}

}  // namespace

TEST_CASE("page: nothing is served but the page, to GET, under the server's own address") {
  const PacedRun run;
  const std::string page = answer(run.port(), get(run, "/"));
  REQUIRE(page.starts_with("HTTP/1.1 200"));
  for (const char* part : {"<!doctype html>", "connect-src 'self'", "Quickstart: a simulated drive", "nosniff"}) {
    INFO(part);
    REQUIRE(page.find(part) != std::string::npos);
  }
  for (const char* target : {"/index.html", "/paced.json", "/../paced.json", "/%2e%2e/%2e%2e/etc/passwd", "//", "/?x",
                             "/events/", "/events?x", "http://127.0.0.1/", "*", "/favicon.ico"}) {
    INFO(target);
    REQUIRE(status_of(run, get(run, target)) == "404");
  }
  for (const char* method : {"POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PATCH"}) {
    INFO(method);
    REQUIRE(status_of(run, std::string(method) + " / HTTP/1.1\r\nHost: " + run.host() + "\r\n\r\n") == "405");
  }
  const std::string port = std::to_string(run.port());
  for (const auto& own : {"localhost:" + port, "LOCALHOST:" + port, "127.0.0.1:" + port, "[::1]:" + port})
    REQUIRE(status_of(run, with_host(own)) == "200");
  for (const std::string& other :
       {"evil.example:" + port, "localhost.evil.example:" + port, std::string("127.0.0.1"), std::string("127.0.0.1:1"),
        "127.0.0.1.nip.io:" + port, std::string(""), ":" + port}) {
    INFO(other);
    REQUIRE(status_of(run, with_host(other)) == "403");
  }
  REQUIRE(status_of(run, "GET / HTTP/1.0\r\n\r\n") == "403");
  REQUIRE(status_of(run, "GET /events HTTP/1.1\r\nHost: evil.example\r\n\r\n") == "403");
}

TEST_CASE("page: another site in the same browser gets no events, and takes no place of a page") {
  const PacedRun run;
  const auto from = [&](const std::string& origin) {
    return status_of(run, "GET /events HTTP/1.1\r\nHost: " + run.host() + "\r\nOrigin: " + origin + "\r\n\r\n");
  };
  REQUIRE(from("http://evil.example") == "403");
  REQUIRE(from("http://127.0.0.1:1") == "403");
  REQUIRE(from("https://" + run.host()) == "403");
  REQUIRE(from("null") == "403");
  Client own(run.port());
  own.send("GET /events HTTP/1.1\r\nHost: " + run.host() + "\r\nOrigin: http://" + run.host() + "\r\n\r\n");
  REQUIRE(own.until("\r\n").starts_with("HTTP/1.1 200"));
}

TEST_CASE("page: requests that are large or none are refused") {
  const PacedRun run;
  REQUIRE(status_of(run, "GET / HTTP/1.1\r\nHost: " + run.host() + "\r\nX: " + std::string(20'000, 'x') + "\r\n\r\n") ==
          "431");
  REQUIRE(status_of(run, "GET /" + std::string(20'000, 'x') + " HTTP/1.1\r\nHost: " + run.host() + "\r\n\r\n") ==
          "431");
  REQUIRE(status_of(run, "GET / HTTP/1.1\r\nHost: " + run.host() + "\r\nContent-Length: 5\r\n\r\nhello") == "413");
  REQUIRE(status_of(run, "hello\r\n\r\n") == "400");
  REQUIRE(status_of(run, std::string("\0\1\2\3\r\n\r\n", 8)) == "400");
  REQUIRE(status_of(run, get(run, "/")) == "200");
}

TEST_CASE("page: connections have a limit, and those that are closed make room") {
  const PacedRun run;
  std::list<Client> idle;
  while (idle.size() < 32) idle.emplace_back(run.port());
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  REQUIRE(status_of(run, get(run, "/")) == "none");
  idle.clear();
  std::string status;
  for (int i = 0; i < 100 && status != "200"; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    status = status_of(run, get(run, "/"));
  }
  REQUIRE(status == "200");

  std::list<Client> viewers;
  while (viewers.size() < 8) {
    viewers.emplace_back(run.port());
    viewers.back().send(get(run, "/events"));
    viewers.back().until("text/event-stream");
  }
  REQUIRE(status_of(run, get(run, "/events")) == "503");
}

TEST_CASE("page: events have the run so far, and the last one its verdict") {
  PacedRun run;
  Client viewer(run.port());
  viewer.send(get(run, "/events"));
  run.open_until(40);
  const Json early = event_until(viewer, 40);
  REQUIRE(early["live"] == "goes on");
  REQUIRE(early["run"]["filters"][0]["track"]["block"] == "position");
  REQUIRE(early["run"]["filters"][0]["measurements"][0]["residuals"].size() == 6);
  run.open();
  Json last;
  while (last.is_null() || last["live"] != "over") last = event(viewer);
  const auto outcome = run.wait();
  REQUIRE(outcome.status == 0);
  REQUIRE(end_of(last) > 190);
  REQUIRE(last["run"]["summary"]["filters"]["ins"]["verdict"]["state"] == "ok");
  REQUIRE(last["run"]["summary"]["filters"]["ins"]["reference"].contains("position.horizontal"));
  const Json& counts = last["run"]["filters"][0]["measurements"][0]["outcomes"]["counts"];
  REQUIRE(counts[0] == last["run"]["summary"]["filters"]["ins"]["measurements"]["fix"]["accepted"]);
}

TEST_CASE("page: one who comes late sees what there is from then on, and counts of all") {
  PacedRun run;
  run.open_until(60);
  run.wait_until_held(60);
  Client viewer(run.port());
  viewer.send(get(run, "/events"));
  run.open_until(80);
  const Json payload = event_until(viewer, 80);
  REQUIRE(payload["run"]["filters"][0]["span"][0].get<double>() >= 60);
  REQUIRE(payload["run"]["summary"]["filters"]["ins"]["measurements"]["fix"]["accepted"].get<int>() > 70);
  Client second(run.port());  // while the first looks on: what that one has seen
  second.send(get(run, "/events"));
  REQUIRE(event(second)["run"]["filters"][0]["span"][0] == payload["run"]["filters"][0]["span"][0]);
}

TEST_CASE("page: one who takes nothing is not waited for, and gets the newest when it does") {
  PacedRun run;
  Client slow(run.port(), 4096), quick(run.port());
  for (const Client* viewer : {&slow, &quick}) viewer->send(get(run, "/events"));
  run.open_until(60);
  int events = 0;
  for (double t = 60; t < 68; t += 0.4, ++events) {
    run.open_until(t);
    event_until(quick, t);
  }
  REQUIRE(events == 20);
  int taken = 0;
  while (end_of(event(slow)) < 67.6) ++taken;
  REQUIRE(taken <= 4);  // one under way, one that waited, and what the system had in its buffers
  run.open();
  while (event(quick)["live"] != "over") {
  }
  REQUIRE(run.wait().status == 0);  // `slow` never took its last
}

TEST_CASE("page: browsers that vanish leave the run alone") {
  PacedRun run({"--json"});
  run.open_until(20);
  for (int i = 0; i < 30; ++i) {
    Client viewer(run.port(), 4096);
    viewer.send(get(run, i % 3 == 0 ? "/events" : i % 3 == 1 ? "/" : "/nothing"));
    if (i % 2 == 0) viewer.until("HTTP/1.1");
  }
  REQUIRE(status_of(run, get(run, "/")) == "200");
  run.open();
  const auto outcome = run.wait();
  REQUIRE(outcome.status == 0);
  REQUIRE(Json::parse(outcome.out)["filters"]["ins"]["verdict"]["state"] == "ok");
}

TEST_CASE("page: the same figures with a page, looked at or not, as without") {
  const auto figures = [](const std::string& text) {
    Json summary = Json::parse(text);
    summary.erase("wall_s");
    summary["filters"]["ins"].erase("filter_s");
    return summary;
  };
  PacedRun watched({"--json"}), alone({"--json"});
  Client viewer(watched.port());
  viewer.send(get(watched, "/events"));
  viewer.until("text/event-stream");
  watched.open();
  alone.open();
  const auto seen = watched.wait(), unseen = alone.wait();
  const auto without = binnacle::test::binnacle(alone.bench(), {"run", "paced.json", "--json"});
  REQUIRE(seen.status == 0);
  REQUIRE(figures(seen.out) == figures(without.out));
  REQUIRE(figures(unseen.out) == figures(without.out));
}

TEST_CASE("page: an address that is none, or that is used, is a usage error that says so") {
  const PacedRun run;
  const auto refused = [&](const std::string& address, const std::string& why) {
    const auto outcome = binnacle::test::binnacle(run.bench(), {"run", "good.json", "--out", "out", "--page", address});
    INFO(address << ": " << outcome.err);
    CHECK(outcome.status == 2);
    CHECK(outcome.out.empty());
    CHECK(outcome.err.find(why) != std::string::npos);
    CHECK(outcome.err.find("expected") != std::string::npos);
  };
  refused(run.host(), "Address already in use");
  refused("8.8.8.8:8080", "8.8.8.8:8080: Cannot assign requested address");
  refused("8080x", "'8080x' is not a port");
  refused("65536", "'65536' is not a port");
  refused("-1", "'-1' is not a port");
  refused("", "'' is not a port");
  refused("localhost", "'localhost' is not a port");
  refused("example.com:8080", "'example.com' is not an address");
  refused("::1:8080", "'::1' is not an address");
  refused("[127.0.0.1]:8080", "'[127.0.0.1]' is not an address");
}

TEST_CASE("page: all the ways to name the loopback") {
  const Workbench bench;
  for (const char* address : {"0", ":0", "localhost:0", "127.0.0.1:0", "0.0.0.0:0"}) {
    const auto outcome = binnacle::test::binnacle(bench, {"run", "good.json", "--quiet", "--page", address});
    INFO(address << ": " << outcome.err);
    CHECK(outcome.status == 0);
    const std::string host = std::string(address) == "0.0.0.0:0" ? "0.0.0.0" : "127.0.0.1";
    CHECK(outcome.err.starts_with("page: http://" + host + ":"));
  }
}

}  // namespace http_test
