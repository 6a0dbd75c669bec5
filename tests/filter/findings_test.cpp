// SPDX-License-Identifier: Apache-2.0
// What components find out while they are bound: figures in the explanation, notes among the warnings.
#include <cstdlib>
#include <string>

#include <nlohmann/json.hpp>

#include "binnacle/composition.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace findings_test {

using namespace binnacle;

namespace {

std::shared_ptr<const Composition> composed(const std::string& parameters) {
  return filter_tests::composition_of(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1}},
      "process": {"p": {"type": "breaking", "blocks": {"x": "x"})" +
                                      parameters + R"(}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [1]}}}}})");
}

}  // namespace

TEST_CASE("a component's note is a warning at its place, its figures are explained") {
  const auto composition = composed(R"(, "after": "3 s")");
  REQUIRE(composition->warnings().items().size() == 1);
  const Diagnostic& warning = composition->warnings().items().front();
  CHECK(warning.severity == Severity::warning);
  CHECK(warning.code == "B032");
  CHECK(warning.pointer == "/filters/f/process/p");
  CHECK(warning.message == "it breaks without a word");
  CHECK(warning.origin.line == 5);
  REQUIRE(composition->found().size() == 1);
  const FoundInfo& found = composition->found().front();
  CHECK(found.pointer == "/filters/f/process/p");
  REQUIRE(found.figures.size() == 1);
  CHECK(found.figures.front().name == "breaks after");
  CHECK(found.figures.front().value == 3);
  CHECK(found.figures.front().unit == "s");
}

TEST_CASE("a component that has no note is none of the warnings") {
  CHECK(composed(R"(, "politely": true)")->warnings().empty());
}

}  // namespace findings_test
