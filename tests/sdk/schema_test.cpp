// SPDX-License-Identifier: Apache-2.0
// The exported JSON Schema and the checker say the same of a config, as far as a schema can see.
#include "catch.hpp"

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "command.hpp"

namespace schema_test {

using namespace binnacle::test;
using nlohmann::json;

namespace {

class SchemaCheck {
 public:
  explicit SchemaCheck(const Workbench& bench) : text_(json::parse(binnacle::test::binnacle(bench, {"schema"}).out)) {
    valijson::SchemaParser(valijson::SchemaParser::kDraft7)
        .populateSchema(valijson::adapters::NlohmannJsonAdapter(text_), schema_);
  }
  bool accepts(const std::string& config) const {
    const json parsed = json::parse(config, nullptr, true, true);
    return valijson::Validator().validate(schema_, valijson::adapters::NlohmannJsonAdapter(parsed), nullptr);
  }

 private:
  json text_;
  valijson::Schema schema_;
};

struct Change {
  const char* from;
  const char* to;
};

}  // namespace

TEST_CASE("schema and checker agree on good configs") {
  const Workbench bench;
  const SchemaCheck schema(bench);
  const Change changes[] = {
      {"\"binnacle\": 1", "\"binnacle\": 1"},
      {R"~("type": "vector")~", R"~("type": "core/vector")~"},
      {R"~("init": { "x": "0 m" })~", R"~("init": 0)~"},
      {R"~("init": { "x": "0 m" })~", R"~("init": ["0 m"])~"},
      {R"~("init": { "x": "0 m" })~", R"~("init": { "channel": "truth", "max_age": "1 s" })~"},
      {R"~("sigma": "1 m")~", R"~("sigma": { "x": "100 cm" })~"},
      {R"~("sigma": "1 m")~", R"~("sigma": [1])~"},
      {R"~("sigma": "1 m")~", R"~("sigma": 1, "estimate": ["x"])~"},
      {R"~("sigma": "1 m")~", R"~("sigma": 1, "consider": ["x"])~"},
      {R"~("q": "0.1 m/sqrt(s)")~", R"~("q": ["0.1 m/sqrt(s)"])~"},
      {R"~("gate": 0.999)~", R"~("withhold": { "every": 2 })~"},
      {R"~("gate": 0.999)~", R"~("withhold": [["1 s", "2 s"]])~"},
      {R"~("gate": 0.999)~", R"~("gate": 0.9, "recover": { "after": 5, "inflate": { "place.x": "10 m" } })~"},
      {R"~("gate": 0.999)~", R"~("fields": { "z0": "z0" })~"},
      {R"~(["0 s", "2 s"])~", R"~(["start+0.5 s", 2])~"},
      {R"~("evaluate": {)~", R"~("record": { "every": "0.2 s" }, "evaluate": { "after": "start+1 s",)~"},
      {R"~("title":)~", R"~("vars": { "a": "b" }, "title":)~"},
      {R"~(["x"])~", R"~({ "x": "x" })~"},
      {R"~("process": {)~",
       R"~("implied_states": { "direct": { "measurement": "seen", "block": "place" } }, "process": {)~"},
  };
  for (const auto& change : changes) {
    bench.spoil(change.from, change.to);
    INFO(change.to);
    const auto checked = binnacle::test::binnacle(bench, {"check", "bad.json"});
    INFO(checked.err);
    CHECK(checked.status == 0);
    CHECK(schema.accepts(read_file(bench.path("bad.json"))));
  }
}

TEST_CASE("schema and checker agree on bad configs") {
  const Workbench bench;
  const SchemaCheck schema(bench);
  const Change changes[] = {
      {"\"binnacle\": 1", "\"binnacle\": 2"},
      {R"~("evaluate")~", R"~("evalaute")~"},
      {R"~("q":)~", R"~("qq":)~"},
      {R"~("type": "vector")~", R"~("type": "vectro")~"},
      {R"~("type": "random_walk", )~", ""},
      {R"~("type": "random_walk")~", R"~("type": "vector")~"},
      {R"~("size": 1)~", R"~("size": 0)~"},
      {R"~("size": 1)~", R"~("size": "one")~"},
      {R"~("size": 1, )~", ""},
      {R"~("sigma": "1 m")~", R"~("sigma": true)~"},
      {R"~("sigma": "1 m")~", R"~("sigma": "wide")~"},
      {R"~("q": "0.1 m/sqrt(s)")~", R"~("q": -1)~"},
      {R"~("q": "0.1 m/sqrt(s)")~", R"~("q": {})~"},
      {R"~("channel": "fix", )~", ""},
      {R"~("gate": 0.999)~", R"~("gate": 1.5)~"},
      {R"~("gate": 0.999)~", R"~("gate": true)~"},
      {R"~("gate": 0.999)~", R"~("gates": 0.9)~"},
      {R"~("gate": 0.999)~", R"~("recover": { "after": 0, "inflate": {} })~"},
      {R"~("gate": 0.999)~", R"~("withhold": { "every": "2" })~"},
      {R"~({ "x": "place" }, "q")~", R"~({ "y": "place" }, "q")~"},
      {R"~({ "x": "place" }, "q")~", R"~("place", "q")~"},
      {R"~(["0 s", "2 s"])~", R"~(["0 s"])~"},
      {R"~("path": "fix.csv", )~", ""},
      {R"~("unit": "m" } } },
    "truth")~",
       R"~("units": "m" } } },
    "truth")~"},
      {R"~("evaluate": {)~", R"~("record": { "evry": "0.2 s" }, "evaluate": {)~"},
      {R"~("channel": "truth", )~", ""},
  };
  for (const auto& change : changes) {
    bench.spoil(change.from, change.to);
    INFO(change.from << " -> " << change.to);
    CHECK(binnacle::test::binnacle(bench, {"check", "bad.json"}).status == 3);
    CHECK_FALSE(schema.accepts(read_file(bench.path("bad.json"))));
  }
}

}  // namespace schema_test
