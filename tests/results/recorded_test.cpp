// SPDX-License-Identifier: Apache-2.0
// What run --out leaves: which formats, the page, and what is left of a run that does not end.
#include "catch.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "command.hpp"
#include "file_size_limit.hpp"
#include "results/results.hpp"

namespace recorded_test {

using namespace binnacle::test;
namespace fs = std::filesystem;
namespace results = binnacle::results;

namespace {

const std::string quickstart = std::string(BINNACLE_TEST_PROJECT) + "/configs/quickstart.json";
using Words = std::vector<std::string>;

Outcome run(const Workbench& bench, const std::string& out, Words more = {}) {
  Words words{"run", quickstart, "--quiet", "--out", out};
  words.insert(words.end(), more.begin(), more.end());
  return binnacle::test::binnacle(bench, words);
}

/// Every epoch of so many drives, and no reference: what scores it is kept whole.
Words long_run(int drives) {
  return {"--set",          "/record=null", "--set",
          "/evaluate=null", "--set",        "/sources/drive/repeat=" + std::to_string(drives)};
}

Words names_in(const fs::path& folder) {
  Words names;
  if (!fs::exists(folder)) return names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

bool are_same(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

}  // namespace

TEST_CASE("run --only leaves these formats alone, and none of an earlier run") {
  const Workbench bench;
  REQUIRE(run(bench, "out").status == 0);
  CHECK(names_in(bench.path("out")) == Words{"config.json", "ins.csv", "report.html", "run.nc", "summary.json"});
  REQUIRE(run(bench, "out", {"--only", "nc"}).status == 0);
  CHECK(names_in(bench.path("out")) == Words{"config.json", "run.nc", "summary.json"});
  REQUIRE(run(bench, "out", {"--only", "csv,page"}).status == 0);
  CHECK(names_in(bench.path("out")) == Words{"config.json", "ins.csv", "report.html", "summary.json"});
  REQUIRE(run(bench, "out", {"--only", "page"}).status == 0);
  CHECK(names_in(bench.path("out")) == Words{"config.json", "report.html", "summary.json"});
}

TEST_CASE("run --only says what a format is") {
  const Workbench bench;
  const auto wrong = run(bench, "out", {"--only", "nc,cvs"});
  CHECK(wrong.status == 2);
  CHECK(wrong.err ==
        "error: --only: 'cvs' is not a format; expected some of nc, csv, page, with commas between them; did you mean "
        "'csv'?\n");
  CHECK(run(bench, "out", {"--only", "nc,"}).err.find("a format is missing in 'nc,'") != std::string::npos);
  CHECK(run(bench, "out", {"--compress", "10"}).status == 2);
  CHECK(binnacle::test::binnacle(bench, {"run", quickstart, "--only", "nc"}).status == 2);
  CHECK(names_in(bench.path("out")).empty());
}

TEST_CASE("formats are the same bytes with others and without, and the page is that of binnacle report") {
  const Workbench bench;
  const Start start{{}, {{"SOURCE_DATE_EPOCH", "1700000000"}}};
  const auto run_at = [&](const std::string& out, const Words& more) {
    Words words{"run", quickstart, "--quiet", "--out", out};
    words.insert(words.end(), more.begin(), more.end());
    REQUIRE(binnacle::test::binnacle(bench, words, start).status == 0);
  };
  run_at("all", {});
  for (const auto& [only, name] : {std::pair{"nc", "run.nc"}, std::pair{"csv", "ins.csv"}}) {
    run_at("one", {"--only", only});
    CHECK(read_file(bench.path(std::string("one/") + name)) == read_file(bench.path(std::string("all/") + name)));
  }
  const std::string page = read_file(bench.path("all/report.html"));
  CHECK(page.size() > 500'000);
  REQUIRE(binnacle::test::binnacle(bench, {"report", "all"}).status == 0);
  const std::string again = read_file(bench.path("all/report.html"));
  const auto differs = std::mismatch(page.begin(), page.end(), again.begin(), again.end());
  INFO("at " << differs.first - page.begin() << " of " << page.size());
  CHECK((differs.first == page.end() && differs.second == again.end()));
}

TEST_CASE("what is compressed reads back the same, and is smaller") {
  const Workbench bench;
  const auto more = long_run(1);
  const auto with = [&](const char* level) {
    auto words = more;
    words.insert(words.end(), {"--only", "nc", "--compress", level});
    return words;
  };
  REQUIRE(run(bench, "plain", with("0")).status == 0);
  REQUIRE(run(bench, "small", with("1")).status == 0);
  const auto size_of = [&](const char* name) { return static_cast<double>(fs::file_size(bench.path(name))); };
  CHECK(size_of("small/run.nc") < 0.8 * size_of("plain/run.nc"));
  const auto plain = results::read(bench.path("plain")).run->filters.at(0),
             small = results::read(bench.path("small")).run->filters.at(0);
  REQUIRE(plain.t.size() > 19'000);  // more than two chunks
  CHECK(are_same(plain.t, small.t));
  REQUIRE(plain.estimates.size() == small.estimates.size());
  for (std::size_t i = 0; i < plain.estimates.size(); ++i) {
    CHECK(are_same(plain.estimates[i].values, small.estimates[i].values));
    CHECK(are_same(plain.estimates[i].sigma, small.estimates[i].sigma));
  }
}

TEST_CASE("no format that finds no room leaves anything, exit status 5") {
  const Workbench bench;
  REQUIRE(run(bench, "out", long_run(1)).status == 0);
  for (const auto& [only, name] :
       {std::pair{"nc", "run.nc"}, std::pair{"csv", "ins.csv"}, std::pair{"nc,csv,page", "ins.csv"}}) {
    const auto size = fs::file_size(bench.path(std::string("out/") + name));
    for (const auto limit : {size / 8, size / 2, size - 100}) {
      INFO(only << ", limit " << limit << " of " << size);
      const FileSizeLimit lowered(limit);
      auto more = long_run(1);
      more.insert(more.end(), {"--only", only});
      const auto outcome = run(bench, "full", more);
      CHECK(outcome.status == 5);
      CHECK(outcome.err.starts_with("error: 'full/"));
      CHECK(outcome.err.ends_with(
          " could not be written: File too large; raise the limit (ulimit -f), or write elsewhere\n"));
      CHECK_FALSE(fs::exists(bench.path("full")));
    }
  }
  const FileSizeLimit lowered(fs::file_size(bench.path("out/report.html")) / 2);
  auto more = long_run(1);
  more.insert(more.end(), {"--only", "page"});
  const auto outcome = run(bench, "full", more);
  CHECK(outcome.status == 5);
  CHECK(outcome.err.starts_with("error: 'full/report.html' could not be written: "));
  CHECK_FALSE(fs::exists(bench.path("full/report.html")));
}

TEST_CASE("a killed run leaves nothing that looks whole, and the next one tidies up") {
  const Workbench bench;
  std::mt19937 random(11);
  int killed = 0;
  for (int i = 0; i < 12; ++i) {
    Words words{"run", quickstart, "--quiet", "--out", "out"};
    const auto more = long_run(2);
    words.insert(words.end(), more.begin(), more.end());
    Command command(bench, words);
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + random() % 600));
    command.signal(SIGKILL);
    killed += command.wait().signal == SIGKILL;
    // Files come one after the other, summary.json last of the data: with it there, all are.
    const auto names = names_in(bench.path("out"));
    const bool is_whole = std::count(names.begin(), names.end(), "summary.json") > 0;
    if (is_whole) CHECK(results::read(bench.path("out")).run->filters.at(0).t.size() > 30'000);
    if (std::count(names.begin(), names.end(), "report.html") > 0) CHECK(is_whole);
    fs::remove(bench.path("out/summary.json"));
    for (const char* name : {"run.nc", "ins.csv", "config.json", "report.html"})
      fs::remove(bench.path("out") + "/" + name);
  }
  CHECK(killed > 0);
  REQUIRE(run(bench, "out").status == 0);
  CHECK(names_in(bench.path("out")) == Words{"config.json", "ins.csv", "report.html", "run.nc", "summary.json"});
}

TEST_CASE("memory does not grow with the rows, whatever is recorded") {
  const Workbench bench;
  Start start;
  int shadow = 1;
#if defined(__SANITIZE_ADDRESS__)
  // The address sanitizer keeps what was freed, 256 MB of it by default, and puts bytes about each block.
  const char* options = std::getenv("ASAN_OPTIONS");
  start.environment["ASAN_OPTIONS"] =
      std::string(options == nullptr ? "" : options) + ":quarantine_size_mb=1:thread_local_quarantine_size_kb=64";
  shadow = 2;
#elif defined(__SANITIZE_THREAD__)
  shadow = 5;  // the thread sanitizer keeps four bytes beside each
#endif
  // In a process of its own, as ctest runs it: the peak of a child counts what its parent had when it forked.
  const auto peak = [&](int drives, const Words& how) {
    Words words{"run", quickstart, "--quiet"};
    for (const auto& more : {long_run(drives), how}) words.insert(words.end(), more.begin(), more.end());
    const auto outcome = binnacle::test::binnacle(bench, words, start);
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    return outcome.peak_memory;
  };
  const int few = 5, many = 20;  // drives: 97 000 rows and 389 000, which are 28 MB and 109 MB
  const double few_alone = peak(few, {}), many_alone = peak(many, {});  // the drive is simulated before it begins
  for (const char* only : {"nc,csv,page", "page"}) {
    const Words how{"--out", "out", "--only", only};
    const double with_few = peak(few, how) - few_alone, with_many = peak(many, how) - many_alone;
    INFO(only << ": " << with_few / 1e6 << " MB and " << with_many / 1e6 << " MB more than without results");
    CHECK(with_many < with_few + 12e6);
    CHECK(with_many < 60e6 * shadow);
  }
}

}  // namespace recorded_test
