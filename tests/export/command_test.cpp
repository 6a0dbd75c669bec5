// SPDX-License-Identifier: Apache-2.0
// The verb: a run's folder to files, exit status, nothing half-written, spoilt folders.
#include <filesystem>
#include <fstream>
#include <functional>

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "command.hpp"

namespace command_test {

using namespace binnacle::test;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

const std::string quickstart = std::string(BINNACLE_TEST_PROJECT) + "/configs/quickstart.json";

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::size_t files_in(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

/// A bench with the quickstart's results in out.
struct Results {
  Results() {
    const auto run = binnacle::test::binnacle(bench, {"run", quickstart, "--out", "out", "--quiet"});
    if (run.status != 0) throw std::runtime_error(run.err);
  }
  Outcome to(const std::string& format, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"export", "out", "--to", format};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return binnacle::test::binnacle(bench, arguments);
  }
  Workbench bench;
};

}  // namespace

TEST_CASE("export writes each format beside the results, says what is in it, and leaves the results alone") {
  const Results results;
  const std::string csv = read_file(results.bench.path("out/ins.csv")),
                    nc = read_file(results.bench.path("out/run.nc"));
  for (const std::string format : {"kml", "gpx", "pos", "nmea", "csv"}) {
    INFO(format);
    const auto outcome = results.to(format, {"--week", "2400", "--rate", "1 Hz", "--json"});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    const json said = json::parse(outcome.out);
    const std::string file = said.at("file");
    CHECK(file == (format == "csv" ? "out/ins.export.csv" : "out/ins." + format));
    CHECK(said.at("filter") == "ins");
    CHECK(said.at("of") == 972);
    CHECK(said.at("records") == 195);  // 194.2 s, one a second, the first of them at 0
    CHECK(said.at("left_out") == 0);
    CHECK(said.at("bytes") == fs::file_size(results.bench.path(file)));
    if (format != "csv") CHECK(said.at("time").at("from") == "--week");
  }
  CHECK(read_file(results.bench.path("out/ins.csv")) == csv);
  CHECK(read_file(results.bench.path("out/run.nc")) == nc);
  const auto text = results.to("gpx", {"-o", "here.gpx"});
  CHECK(text.status == 0);
  CHECK(text.out == "here.gpx: 972 records of filter 'ins', of 972\n");
  CHECK(contains(text.err, "note: the file has no times: the run does not give the origin of its time"));
  CHECK(contains(text.err, "note: the file has no heights: gpx needs heights above sea level"));
  const auto piped = results.to("csv", {"-o", "/dev/stdout", "--columns", "position", "--every", "971"});
  CHECK(piped.status == 0);
  CHECK(piped.out.starts_with("t[s],position.lat[deg],position.lon[deg],position.height[m]\n0,48.13"));
  CHECK(std::count(piped.out.begin(), piped.out.end(), '\n') == 3);
}

TEST_CASE("export refuses by exit status 2 what is asked wrongly, and writes nothing") {
  const Results results;
  const std::size_t files = files_in(results.bench.path("out"));
  const auto refused = [&](const std::string& format, const std::vector<std::string>& more,
                           const std::string& message) {
    const auto outcome = results.to(format, more);
    INFO(format << ": " << outcome.err);
    CHECK(outcome.status == 2);
    CHECK(outcome.out.empty());
    CHECK(contains(outcome.err, message));
    CHECK(files_in(results.bench.path("out")) == files);
  };
  refused("pos", {}, "--week N (GPS time from the start of a week");
  refused("shp", {}, "--to");
  refused("kml", {"--filter", "inz"}, "the run has no filter 'inz'; it has 'ins'");
  refused("kml", {"--rate", "0"}, "--rate takes a rate above 0");
  refused("kml", {"--rate", "5 m"}, "--rate takes a quantity in Hz; found '5 m'");
  refused("kml", {"--every", "0"}, "--every takes 1 or more; found 0");
  refused("csv", {"--columns", "positron"}, "there is no column 'positron'; did you mean 'position");
  refused("csv", {"--local", "--origin", "48,11"},
          "--origin takes LAT,LON,HEIGHT in degrees and metres; found '48,11'");
  refused("csv", {"--local", "--origin", "148,11,0"}, "'148' is none of these");
  refused("kml", {"-o", "out/run.nc"}, "'out/run.nc' is one of the results that are exported");
  refused("csv", {"-o", "out/ins.csv"}, "'out/ins.csv' is one of the results that are exported");
  refused("kml", {"-o", "no/folder.kml"}, "cannot write 'no/folder.kml'");
  refused("kml", {"--epoch", "soon"}, "'soon' is not an instant of UTC (--epoch)");
}

TEST_CASE("export of a spoilt folder: exit status 5, what to do, and no file") {
  const Results results;
  const auto spoilt = [&](const std::function<void(const fs::path&)>& spoil, const std::string& message) {
    const fs::path copy = results.bench.path("copy");
    fs::remove_all(copy);
    fs::copy(results.bench.path("out"), copy);
    spoil(copy);
    const std::size_t files = fs::exists(copy) ? files_in(copy.string()) : 0;
    const auto outcome = binnacle::test::binnacle(results.bench, {"export", "copy", "--to", "kml"});
    INFO(outcome.err);
    CHECK(outcome.status == 5);
    CHECK(outcome.out.empty());
    CHECK(contains(outcome.err, message));
    CHECK((fs::exists(copy) ? files_in(copy.string()) : 0) == files);
  };
  spoilt([](const fs::path& copy) { fs::remove_all(copy); }, "'copy' is not a folder");
  spoilt([](const fs::path& copy) { fs::remove(copy / "run.nc"); }, "holds neither run.nc nor study.nc");
  spoilt([](const fs::path& copy) { fs::remove(copy / "summary.json"); }, "make it again with 'binnacle run");
  spoilt([](const fs::path& copy) { std::ofstream(copy / "summary.json") << "{"; }, "it is not a JSON object");
  spoilt([](const fs::path& copy) { fs::resize_file(copy / "run.nc", fs::file_size(copy / "run.nc") / 2); },
         "copy/run.nc' cannot be read");
  spoilt([](const fs::path& copy) { std::ofstream(copy / "run.nc") << "no NetCDF"; },
         "it is damaged, or no NetCDF file");
}

TEST_CASE("export to a full disk: exit status 5") {
  if (!fs::exists("/dev/full")) return;
  const Results results;
  const auto outcome = results.to("kml", {"-o", "/dev/full"});
  CHECK(outcome.status == 5);
}

}  // namespace command_test
