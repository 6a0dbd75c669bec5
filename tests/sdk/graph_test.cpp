// SPDX-License-Identifier: Apache-2.0
// binnacle graph --sparsity: what the drawing says of Φ, Qd and H holds of the numbers of a run.
#include "catch.hpp"

#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include <Eigen/Dense>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>

#include "binnacle/eigen.hpp"
#include "command.hpp"
#include "score/run.hpp"

namespace graph_test {

using namespace binnacle::test;
using Eigen::MatrixXd;
namespace xml = boost::property_tree;

namespace {

using Filled = Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic>;

/// The rectangles of a drawing of one filter.
class Drawing {
 public:
  Drawing(const std::string& path, int n) : phi(Filled::Constant(n, n, false)), qd(phi), identity(phi), n_(n) {
    xml::read_xml(path, tree_);  // throws where it is not well-formed
    for (const auto& [name, node] : tree_.get_child("svg"))
      if (name == "rect") take(node);
    for (const auto& [name, node] : tree_.get_child("svg"))
      if (name == "text") texts.insert(node.get_value<std::string>());
  }
  int count(const std::string& kind) const {
    const auto found = counts_.find(kind);
    return found == counts_.end() ? 0 : found->second;
  }

  Filled phi, qd, identity;
  std::map<std::string, std::vector<bool>> h;  // columns by measurement
  std::set<std::string> texts;

 private:
  void take(const xml::ptree& rectangle) {
    const auto attribute = [&](const char* name) { return rectangle.get<int>("<xmlattr>." + std::string(name)); };
    const auto kind = rectangle.get<std::string>("<xmlattr>.class", "");
    ++counts_[kind];
    const std::string matrix = kind.substr(0, kind.find(' '));
    if (matrix == "h") {
      auto& columns = h[rectangle.get<std::string>("<xmlattr>.data-measurement")];
      columns.resize(static_cast<std::size_t>(n_));
      for (int c = 0; c < attribute("data-columns"); ++c)
        columns[static_cast<std::size_t>(attribute("data-column") + c)] = true;
    }
    if (matrix != "phi" && matrix != "qd") return;
    auto& filled = kind == "phi identity" ? identity : matrix == "phi" ? phi : qd;
    filled.block(attribute("data-row"), attribute("data-column"), attribute("data-rows"), attribute("data-columns"))
        .setConstant(true);
  }

  int n_;
  xml::ptree tree_;
  std::map<std::string, int> counts_;
};

/// Where Φ, Qd and H were ever anything but zero, and Φ anything but the identity.
class Seen final : public binnacle::score::RunObserver, public binnacle::StepObserver {
 public:
  explicit Seen(const binnacle::FilterInfo& info)
      : info_(info), phi(Filled::Constant(info.dof, info.dof, false)), qd(phi) {}
  bool wants_records() const override { return false; }
  binnacle::Wants wants() const override { return binnacle::Wants::everything; }
  binnacle::StepObserver* step_observer(int) override { return this; }
  void stepped(const binnacle::StepRecord& record) override {
    ++steps;
    const MatrixXd Phi = record.Phi.as(), P0 = record.P0.as(), P1 = record.P1.as();
    const MatrixXd Q = P1 - Phi * P0 * Phi.transpose();
    for (int i = 0; i < info_.dof; ++i)
      for (int j = 0; j < info_.dof; ++j) {
        if (Phi(i, j) != (i == j ? 1.0 : 0.0)) phi(i, j) = true;
        if (std::abs(Q(i, j)) > 1e-12 * std::sqrt(P1(i, i) * P1(j, j))) qd(i, j) = true;  // more than rounding
      }
  }
  void offered(const binnacle::UpdateRecord& record) override {
    if (!record.H) return;
    const MatrixXd H = record.H.as();
    auto& columns = h[info_.measurements[static_cast<std::size_t>(record.measurement)].name];
    columns.resize(static_cast<std::size_t>(info_.dof));
    for (int j = 0; j < info_.dof; ++j)
      if (!H.col(j).isZero(0)) columns[static_cast<std::size_t>(j)] = true;
  }

 private:
  const binnacle::FilterInfo& info_;

 public:
  Filled phi, qd;
  std::map<std::string, std::vector<bool>> h;
  int steps = 0;
};

int outside(const Filled& seen, const Filled& drawn) {
  return static_cast<int>((seen.array() && !drawn.array()).count());
}

struct Case {
  std::string config;
  std::vector<std::string> sets;
};

/// Draws a config, runs it, and compares.
Drawing check(const Case& what) {
  const Workbench bench;
  const std::string config = std::string(BINNACLE_TEST_PROJECT) + "/configs/" + what.config;
  std::vector<std::string> words{"graph", config, "--sparsity", "sparsity.svg"};
  binnacle::LoadOptions options;
  options.sets = what.sets;
  options.sets.push_back("/plugins=[\"" BINNACLE_TEST_PLUGINS "\"]");
  for (const auto& set : what.sets) words.insert(words.end(), {"--set", set});
  const auto drawn = binnacle::test::binnacle(bench, words);
  INFO(drawn.err);
  REQUIRE(drawn.status == 0);
  CHECK(drawn.out.empty());

  const auto composition = binnacle::score::load(config, options);
  const auto& info = composition->filters().at(0);
  const Drawing drawing(bench.path("sparsity.svg"), info.dof);
  Seen seen(info);
  binnacle::score::RunOptions run;
  run.observer = &seen;
  binnacle::score::run(composition, run);
  REQUIRE(seen.steps >= 60);
  CHECK(outside(seen.phi, drawing.phi) == 0);
  CHECK(outside(seen.qd, drawing.qd) == 0);
  CHECK((drawing.identity.array() && drawing.phi.array()).count() == 0);
  CHECK(drawing.qd == drawing.qd.transpose());
  REQUIRE(seen.h.size() == drawing.h.size());
  for (const auto& [name, columns] : seen.h) {
    INFO(name);
    CHECK(columns == drawing.h.at(name));
  }
  // And little is drawn that is not there: blocks are whole, so a few zeros lie inside of them.
  CHECK(4 * seen.phi.count() > 3 * drawing.phi.count());
  return drawing;
}

const std::string short_drive =
    "/sources/drive/segments=[{\"do\":\"still\",\"duration\":\"2 s\"},{\"do\":\"accelerate\",\"to\":\"8 m/s\","
    "\"acceleration\":\"2 m/s^2\"},{\"do\":\"turn\",\"angle\":\"60 deg\",\"rate\":\"12 deg/s\"}]";

}  // namespace

TEST_CASE("the sparsity that is drawn of a phi-error filter is that of its numbers") {
  const auto drawing = check({"quickstart.json", {short_drive}});
  CHECK(drawing.count("phi dense") == 14);    // strapdown: 3 rows of 5 blocks, less position of gyro_bias
  CHECK(drawing.count("phi diagonal") == 6);  // two Gauss-Markov processes
  CHECK(drawing.count("phi identity") == 0);
  CHECK(drawing.count("qd dense") == 9);
  CHECK(drawing.count("qd diagonal") == 6);
  CHECK(drawing.count("h dense") == 2);
  CHECK(drawing.texts.contains("Filter ins: 15 rows in the covariance"));
  CHECK(drawing.texts.contains("strapdown (phi_error/phi_error)"));
  CHECK(drawing.texts.contains("gnss_fix/position_fix, on drive.gnss, up to 6 rows"));
}

TEST_CASE("the sparsity that is drawn of a psi-error filter with frozen components is that of its numbers") {
  const auto drawing = check({"transfer_alignment/base.json", {}});
  CHECK(drawing.count("phi dense") == 3);
  CHECK(drawing.count("phi identity") == 3);  // the mounting stays
  CHECK(drawing.count("qd dense") == 4);
  CHECK(drawing.count("h dense") == 3);
  CHECK(drawing.texts.contains("Frozen, without a row: position (north, east, down), velocity (down)"));
}

TEST_CASE("what a measurement sees through a derived block is drawn") {
  const auto drawing =
      check({"quickstart.json",
             {short_drive,
              "/filters/ins/derived={\"antenna\":{\"type\":\"lever_arm\",\"blocks\":{\"position\":\"position\","
              "\"attitude\":\"attitude\"},\"lever_arm\":[\"0.6 m\",\"-0.1 m\",\"-1.2 m\"]}}",
              "/filters/ins/measurements/fix/stack/position/blocks/position=antenna"}});
  CHECK(drawing.count("h dense") == 3);
}

TEST_CASE("processes that are discretized together fill what none of them declares") {
  const auto drawing = check({"ship_motion/monte_carlo.json", {}});
  CHECK(drawing.phi.count() == 7);
  CHECK(drawing.qd.count() == 8);
}

TEST_CASE("a filter whose components are all frozen has nothing to draw") {
  const Workbench bench;
  const std::string project = BINNACLE_TEST_PROJECT;
  REQUIRE(binnacle::test::binnacle(bench, {"graph", project + "/configs/attitude/base.json", "--sparsity", "it.svg"})
              .status == 0);
  const Drawing drawing(bench.path("it.svg"), 0);
  CHECK(drawing.texts.contains("Filter body: 0 rows in the covariance"));
  CHECK(drawing.count("panel") == 0);
}

TEST_CASE("the drawing in the guide is the one that is made") {
  const Workbench bench;
  const std::string project = BINNACLE_TEST_PROJECT;
  REQUIRE(binnacle::test::binnacle(bench, {"graph", project + "/configs/quickstart.json", "--sparsity", "made.svg"})
              .status == 0);
  CHECK(read_file(bench.path("made.svg")) == read_file(project + "/sdk/docs/sparsity.svg"));
}

TEST_CASE("considered components are called so, and names are what they are in a drawing") {
  const auto drawing = check({"quickstart.json", {short_drive, "/filters/ins/blocks/gyro_bias/consider=[\"x\"]"}});
  CHECK(drawing.texts.contains("x [rad/s], considered"));

  const Workbench bench;
  bench.spoil("\"walk\": {", "\"<walk> & \\\"more\\\"\": {");
  REQUIRE(
      binnacle::test::binnacle(bench, {"graph", "bad.json", "--set", "/reference=[]", "--sparsity", "it.svg"}).status ==
      0);
  CHECK(Drawing(bench.path("it.svg"), 1).texts.contains("Filter <walk> & \"more\": 1 row in the covariance"));
}

}  // namespace graph_test
