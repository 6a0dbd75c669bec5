// SPDX-License-Identifier: Apache-2.0
// Two processes that write results into one folder: one of them does, the other reads who has it; nothing is mixed.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "command.hpp"

namespace writers_test {

using namespace binnacle::test;
namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// But for figures of time.
Json without_times(Json json) {
  for (const char* key : {"wall_s", "filter_s"})
    if (json.is_object()) json.erase(key);
  if (json.is_structured())
    for (auto& item : json) item = without_times(item);
  return json;
}

/// All that a run leaves, in one text.
std::string results_in(const Workbench& bench, const std::string& folder) {
  return read_file(bench.path(folder + "/walk.csv")) + read_file(bench.path(folder + "/config.json")) +
         without_times(Json::parse(read_file(bench.path(folder + "/summary.json")))).dump();
}

/// 10 in a test; BINNACLE_PAIRS=100 for more.
int pairs() {
  const char* const text = std::getenv("BINNACLE_PAIRS");
  return text ? std::atoi(text) : 10;
}

}  // namespace

TEST_CASE("pairs of runs that write into one folder: its results are those of one of them") {
  const Workbench bench;
  bench.spoil("\"0.1 m\"", "\"0.3 m\"");
  REQUIRE(binnacle::test::binnacle(bench, {"run", "good.json", "--out", "good"}).status == 0);
  REQUIRE(binnacle::test::binnacle(bench, {"run", "bad.json", "--out", "bad"}).status == 0);
  const std::string good = results_in(bench, "good"), bad = results_in(bench, "bad");
  REQUIRE(good != bad);
  int refused = 0;
  for (int k = 0; k < pairs(); ++k) {
    fs::remove_all(bench.path("out"));
    Command one(bench, {"run", "good.json", "--out", "out"}), other(bench, {"run", "bad.json", "--out", "out"});
    for (const Outcome& outcome : {one.wait(), other.wait()}) {
      INFO(outcome.err);
      CHECK((outcome.status == 0 || outcome.status == 2));
      CHECK((outcome.status == 0 || has(outcome.err, " is writing there; wait until it ends, or give another --out")));
      refused += outcome.status == 2;
    }
    const std::string left = results_in(bench, "out");
    CHECK((left == good || left == bad));
    CHECK_FALSE(fs::exists(bench.path("out/.binnacle.lock")));
  }
  std::printf("%d pairs of runs, %d refused\n", pairs(), refused);
  CHECK(refused <= pairs());
}

TEST_CASE("a folder that another process writes into is refused, with that process, by run and study") {
  const Workbench bench;
  bench.spoil("\"evaluate\"", R"("study": {"runs": 2, "metrics": ["walk/place.x/final"]}, "evaluate")");
  fs::create_directory(bench.path("out"));
  bench.write("out/.binnacle.lock", "process 4711 on elsewhere");
  const int lock = ::open(bench.path("out/.binnacle.lock").c_str(), O_RDWR | O_CLOEXEC);
  REQUIRE(::flock(lock, LOCK_EX) == 0);
  for (const char* verb : {"run", "study"}) {
    const auto outcome = binnacle::test::binnacle(bench, {verb, "bad.json", "--out", "out"});
    CAPTURE(verb);
    CHECK(outcome.status == 2);
    CHECK(outcome.err ==
          "error: cannot write into 'out': process 4711 on elsewhere is writing there; wait until it ends, or give "
          "another --out\n");
    CHECK(std::distance(fs::directory_iterator(bench.path("out")), fs::directory_iterator()) == 1);
  }
  ::close(lock);
  // What a killed process left means nothing.
  CHECK(binnacle::test::binnacle(bench, {"run", "good.json", "--out", "out"}).status == 0);
  CHECK_FALSE(fs::exists(bench.path("out/.binnacle.lock")));
}

TEST_CASE("records of filters that an earlier run into the folder had are removed with it, and nothing else") {
  const Workbench bench;
  REQUIRE(binnacle::test::binnacle(bench, {"run", "good.json", "--out", "out"}).status == 0);
  bench.write("out/mine.csv", "t[s],x\n1,2\n");
  std::string renamed = read_file(bench.path("good.json"));
  for (const char* name : {"\"walk\"", "\"walk/"}) renamed.replace(renamed.find(name) + 1, 4, "march");
  bench.write("renamed.json", renamed);
  const auto outcome = binnacle::test::binnacle(bench, {"run", "renamed.json", "--out", "out"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  CHECK(fs::exists(bench.path("out/march.csv")));
  CHECK_FALSE(fs::exists(bench.path("out/walk.csv")));
  CHECK(fs::exists(bench.path("out/mine.csv")));
}

}  // namespace writers_test
