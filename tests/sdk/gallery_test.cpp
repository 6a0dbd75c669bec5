// SPDX-License-Identifier: Apache-2.0
// The gallery: each config runs, is short, and holds what its page and its picture show.
#include "catch.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>
#include <sstream>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "gallery.hpp"

namespace gallery_test {

using namespace binnacle::test;
namespace fs = std::filesystem;

namespace {

/// RMS errors of each example stay below these, in the units of its table: some two times what its run gives.
const std::map<std::string, std::map<std::string, double>> rms_bounds{
    {"attitude-magnetometer", {{"attitude.tilt", 0.1}, {"attitude.yaw", 0.25}, {"hard_iron.norm", 0.05}}},
    {"battery", {{"cell.charge", 0.01}, {"cell.pair", 0.003}}},
    {"car-wheels",
     {{"position.horizontal", 1.5}, {"position.height", 1.5}, {"attitude.yaw", 0.25}, {"mounting.z", 0.15}}},
    {"foot-zupt", {{"position.horizontal", 2.5}, {"position.height", 0.03}, {"attitude.tilt", 0.1}}},
    {"loose-ins-gnss",
     {{"position.horizontal", 1}, {"position.height", 1.2}, {"attitude.tilt", 0.1}, {"attitude.yaw", 0.5}}},
    {"ship-motion", {{"pitch.angle", 0.49}, {"error.error", 0.5}}},
    {"target-tracking", {{"position.norm", 30}, {"velocity.norm", 5}}},
    {"tight-ins-gnss",
     {{"position.horizontal", 1.5}, {"position.height", 1}, {"attitude.yaw", 0.5}, {"clock.bias", 1}}},
    {"transfer-alignment", {{"attitude.tilt", 0.05}, {"attitude.yaw", 0.05}, {"mounting.z", 0.8}}},
    {"underwater-dvl", {{"position.horizontal", 6}, {"position.height", 0.1}, {"attitude.yaw", 1}}},
    {"uwb-indoors", {{"position.horizontal", 0.08}, {"position.height", 0.12}, {"attitude.yaw", 1}}},
};

/// Without either in a failure's message.
bool is_same(const fs::path& one, const fs::path& other) { return read_file(one) == read_file(other); }

}  // namespace

TEST_CASE("each config of the gallery runs, is consistent, and errs by no more than its bounds") {
  const Workbench bench;
  REQUIRE(examples().size() == rms_bounds.size());
  for (const auto& name : examples()) {
    INFO(name);
    const auto filter = summary_of(bench, (gallery / (name + ".json")).string());
    CHECK(filter.at("verdict").at("state") == "ok");
    REQUIRE(rms_bounds.count(name) == 1);
    for (const auto& [error, bound] : rms_bounds.at(name)) {
      INFO(error);
      const double rms = filter.at("reference").at(error).at("rms");
      CHECK(rms < bound);
      CHECK(rms > bound / 5);  // a bound that nothing reaches bounds nothing
    }
    // Of one run, whose errors are correlated in time: a band for what is neither overconfident nor asleep.
    const auto& consistency = filter.at("consistency");
    const auto& all = consistency.contains("state") ? consistency.at("state") : consistency.begin().value();
    const double per_dof = all.at("nees_mean").get<double>() / all.at("dof").get<double>();
    CHECK(per_dof > 0.4);
    CHECK(per_dof < 1.6);
  }
}

TEST_CASE("configs of the gallery are short, begin with what they show, and have a section and a picture") {
  const std::string page = read_file(gallery / "README.md");
  for (const auto& name : examples()) {
    INFO(name);
    const std::string text = read_file(gallery / (name + ".json"));
    CHECK(std::count(text.begin(), text.end(), '\n') <= 60);
    CHECK(begins(text, "{\n  // "));
    CHECK(text.find("// States (") != std::string::npos);
    CHECK(text.find("// Your own data: ") != std::string::npos);
    std::size_t widest = 0;
    for (std::size_t at = 0, end; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
      widest = std::max(widest, end - at);
    CHECK(widest <= 180);
    CHECK(page.find("\n## " + name + "\n") != std::string::npos);
    CHECK(page.find("](" + name + ".svg)") != std::string::npos);
    CHECK(fs::file_size(gallery / (name + ".svg")) <= 40'000);
  }
}

TEST_CASE("figures in the gallery's table are those that the command of their section prints") {
  std::map<std::string, std::string> printed;  // by section
  std::map<std::string, std::string> rows;     // of the table
  static const std::regex row(R"(\| \[([a-z-]+)\]\(#.*)"), number(R"([0-9]*\.[0-9]{3,})");
  std::istringstream lines(read_file(gallery / "README.md"));
  std::string section;
  std::smatch found;
  for (std::string line; std::getline(lines, line);) {
    if (begins(line, "## ")) section = line.substr(3);
    if (std::regex_match(line, found, row)) rows[found[1]] = line;
    if (begins(line, "  ")) printed[section] += line + " ";
  }
  REQUIRE(rows.size() == examples().size());
  int figures = 0;
  for (const auto& [name, line] : rows)
    for (std::sregex_iterator at(line.begin(), line.end(), number), end; at != end; ++at, ++figures) {
      INFO(at->str() << " in: " << line);
      CHECK(printed[name].find(" " + at->str() + " ") != std::string::npos);
    }
  CHECK(figures > 12);
}

TEST_CASE("pictures and the battery's data are what the scripts of the gallery make") {
  const Workbench bench;
  const std::string python = BINNACLE_TEST_PYTHON;
  const std::string draw = python + " '" + (gallery / "pictures.py").string() +
                           "' --binnacle '" BINNACLE_TEST_COMMAND "' --to '" + bench.folder() + "' > /dev/null";
  REQUIRE(std::system(draw.c_str()) == 0);
  for (const auto& name : examples()) {
    INFO(name);
    CHECK(is_same(bench.path(name + ".svg"), gallery / (name + ".svg")));
  }
  const std::string simulate =
      python + " '" + (gallery / "battery.py").string() + "' > '" + bench.path("battery.csv") + "'";
  REQUIRE(std::system(simulate.c_str()) == 0);
  CHECK(is_same(bench.path("battery.csv"), gallery / "battery.csv"));
}

}  // namespace gallery_test
