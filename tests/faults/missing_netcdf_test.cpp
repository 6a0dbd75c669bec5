// SPDX-License-Identifier: Apache-2.0
// The NetCDF library is not to be had: what needs it says so before any work and leaves nothing, all else works.
#include <filesystem>

#include "catch.hpp"
#include "command.hpp"

namespace missing_netcdf_test {

using namespace binnacle::test;
namespace fs = std::filesystem;

namespace {

const std::string refusal = "the NetCDF library cannot be loaded: ";
const std::string advice = "; install the Debian package " BINNACLE_NETCDF_PACKAGE "\n";

/// The loader finds in this folder, before any other, a library of that name.
Start with_library_in(const std::string& folder) {
  Start start;
  start.environment["LD_LIBRARY_PATH"] = folder;
  return start;
}

/// One that is no library at all.
Start with_no_library(const Workbench& bench) {
  fs::create_directory(bench.path("libraries"));
  bench.write("libraries/" BINNACLE_NETCDF_FILE, "no library");
  return with_library_in(bench.path("libraries"));
}

}  // namespace

TEST_CASE("without NetCDF a run that is to leave results ends before it begins") {
  const Workbench bench;
  const auto outcome = binnacle::test::binnacle(bench, {"run", "good.json", "--out", "out"}, with_no_library(bench));
  INFO(outcome.err);
  CHECK(outcome.status == 5);
  CHECK(outcome.err.starts_with("error: 'out/run.nc' could not be written: " + refusal));
  CHECK(outcome.err.find(BINNACLE_NETCDF_FILE) != std::string::npos);
  CHECK(outcome.err.ends_with(advice));
  CHECK_FALSE(fs::exists(bench.path("out")));
}

TEST_CASE("a NetCDF library that lacks a function is refused by the function") {
  const Workbench bench;
  const auto outcome =
      binnacle::test::binnacle(bench, {"run", "good.json", "--out", "out"}, with_library_in(BINNACLE_EMPTY_LIBRARY));
  CHECK(outcome.status == 5);
  CHECK(outcome.err == "error: 'out/run.nc' could not be written: " + refusal +
                           "'" BINNACLE_NETCDF_FILE "' has no function H5dont_atexit" + advice);
  CHECK_FALSE(fs::exists(bench.path("out")));
}

TEST_CASE("without NetCDF a study ends before its first run") {
  const Workbench bench;
  std::string text = good_config;
  text.insert(text.rfind('}'), ",\n  \"study\": { \"runs\": 2, \"metrics\": [\"walk/place.x/rms\"] }\n");
  bench.write("study.json", text);
  const Start start = with_no_library(bench);
  const auto outcome = binnacle::test::binnacle(bench, {"study", "study.json", "--out", "out"}, start);
  INFO(outcome.err);
  CHECK(outcome.status == 5);
  CHECK(outcome.err.starts_with("error: 'out/study.nc' could not be written: " + refusal));
  CHECK(outcome.err.ends_with(advice));
  CHECK_FALSE(fs::exists(bench.path("out")));

  CHECK(binnacle::test::binnacle(bench, {"study", "study.json"}, start).status == 0);
}

TEST_CASE("without NetCDF results cannot be read, which does not blame the file") {
  const Workbench bench;
  REQUIRE(binnacle::test::binnacle(bench, {"run", "good.json", "--out", "out"}).status == 0);
  const auto outcome = binnacle::test::binnacle(bench, {"report", "out"}, with_no_library(bench));
  INFO(outcome.err);
  CHECK(outcome.status == 5);
  CHECK(outcome.err.starts_with("error: 'out/run.nc' cannot be read: " + refusal));
  CHECK(outcome.err.ends_with(advice));
}

TEST_CASE("what neither writes nor reads results works without NetCDF") {
  const Workbench bench;
  const Start start = with_no_library(bench);
  for (const auto& arguments :
       {std::vector<std::string>{"version"}, {"check", "good.json"}, {"list"}, {"run", "good.json"}}) {
    const auto outcome = binnacle::test::binnacle(bench, arguments, start);
    INFO(arguments.front() << ": " << outcome.err);
    CHECK(outcome.status == 0);
    CHECK(outcome.err.empty());
  }
}

}  // namespace missing_netcdf_test
