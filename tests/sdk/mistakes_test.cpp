// SPDX-License-Identifier: Apache-2.0
// What people get wrong, and word for word the error they get.
#include "catch.hpp"

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace mistakes_test {

using namespace binnacle::test;

namespace {

struct Mistake {
  const char* name;
  const char* from;
  const char* to;
  int status;
  const char* message;  // FOLDER stands for the bench's
};

const Mistake mistakes[] = {
    {"unknown key", R"~("q":)~", R"~("qq":)~", 3,
     "bad.json:14:72: error[B012] /filters/walk/process/wander/qq: unknown key of 'random_walk'; did you mean 'q' (1 "
     "value, m/sqrt(s), >= 0)?\n"
     "1 error\n"},
    {"unknown section", R"~("evaluate")~", R"~("evalaute")~", 3,
     "bad.json:24:3: error[B012] /evalaute: unknown key of the config; did you mean 'evaluate'?\n"
     "1 error\n"},
    {"wrong unit", R"~("0.1 m/sqrt(s)")~", R"~("0.1 m/s")~", 3,
     "bad.json:14:77: error[B007] /filters/walk/process/wander/q: '0.1 m/s' is a velocity; 'q' is a position random "
     "walk (m/sqrt(s), >= 0), for example \"1 m/sqrt(s)\"\n"
     "1 error\n"},
    {"unknown unit", R"~("1 m")~", R"~("1 metre")~", 3,
     "bad.json:11:95: error[B008] /filters/walk/blocks/place/sigma: 'sigma': unknown unit 'metre'; did you mean "
     "'m'?\n"
     "1 error\n"},
    {"missing block", R"~({ "x": "place" }, "q")~", R"~({ "x": "plaice" }, "q")~", 3,
     "bad.json:14:61: error[B015] /filters/walk/process/wander/blocks/x: there is no block 'plaice'; did you mean "
     "'place'? (blocks: place)\n"
     "1 error\n"},
    {"two process models on one block", R"~("wander": {)~",
     R"~("stay": { "type": "random_constant", "blocks": { "x": "place" } },
        "wander": {)~",
     3,
     "bad.json:15:61: error[B019] /filters/walk/process/wander/blocks/x: block 'place' is advanced by 'stay' already; "
     "exactly one process model advances a block\n1 error\n"},
    {"block without process model",
     R"~("wander": { "type": "random_walk", "blocks": { "x": "place" }, "q": "0.1 m/sqrt(s)" })~", "", 3,
     "bad.json:11:9: error[B018] /filters/walk/blocks/place: block 'place' is advanced by no process model; a constant "
     "is {\"type\": \"random_constant\", \"blocks\": {\"x\": \"place\"}}\n"
     "1 error\n"},
    {"duplicate key", R"~("size": 1,)~", R"~("size": 1, "size": 2,)~", 3,
     "bad.json:11:49: error[B002] /filters/walk/blocks/place/size: duplicate key 'size'; the first is at line 11, "
     "column 38\n1 error\n"},
    {"comma missing", R"~("size": 1,)~", R"~("size": 1)~", 3,
     "bad.json:11:47: error[B001]: expected ',' or '}' after the value, found '\"'\n"
     "1 error\n"},
    {"a type that moved to another plugin", R"~("type": "vector")~", R"~("type": "phi_error/position")~", 3,
     "bad.json:11:28: error[B011] /filters/walk/blocks/place/type: 'phi_error/position' is now called "
     "'navigation/position'\n"
     "1 error\n"},
    {"unknown type", R"~("random_walk")~", R"~("random_wlak")~", 3,
     "bad.json:14:29: error[B011] /filters/walk/process/wander/type: unknown process model 'random_wlak'; did you mean "
     "'random_walk'?\n"
     "1 error\n"},
    {"type of another role", R"~("random_walk")~", R"~("vector")~", 3,
     "bad.json:14:29: error[B011] /filters/walk/process/wander/type: 'vector' is a state block, not a process model\n"
     "1 error\n"},
    {"unknown channel", R"~("channel": "fix")~", R"~("channel": "fixes")~", 3,
     "bad.json:18:52: error[B020] /filters/walk/measurements/seen/channel: there is no channel 'fixes'; did you mean "
     "'fix'? (channels: fix, truth, walk)\n"
     "1 error\n"},
    {"undefined variable", R"~("fix.csv")~", R"~("${data}/fix.csv")~", 3,
     "bad.json:5:37: error[B005] /sources/fix/path: unknown variable 'data'; define it under /vars or give --var "
     "data=VALUE\n"
     "1 error\n"},
    {"no initial sigma", R"~("sigma": "1 m")~", R"~("hold": false)~", 3,
     "bad.json:11:9: error[B026] /filters/walk/blocks/place: 'sigma' of block 'place' is missing for 'x' (m)\n"
     "1 error\n"},
    {"out of range", R"~("gate": 0.999)~", R"~("gate": 1.5)~", 3,
     "bad.json:18:115: error[B009] /filters/walk/measurements/seen/gate: 'gate' is 1.5, out of range (> 0, < 1)\n"
     "1 error\n"},
    {"window that ends first", R"~(["0 s", "2 s"])~", R"~(["2 s", "0 s"])~", 3,
     "bad.json:24:39: error[B024] /evaluate/windows/early: the window ends before it begins\n"
     "1 error\n"},
    {"format of another version", R"~("binnacle": 1)~", R"~("binnacle": 2)~", 3,
     "bad.json:2:15: error[B028] /binnacle: this program reads configs of version 1; found the number 2\n"
     "1 error\n"},
    {"missing plugin", R"~("title")~", R"~("plugins": ["sonar.so"], "title")~", 4,
     "bad.json:3:15: error[B040] /plugins/0: there is no plugin file or folder 'FOLDER/sonar.so'\n"
     "1 error\n"},
    {"a plugin that is none", R"~("title")~", R"~("plugins": ["fix.csv"], "title")~", 4,
     "FOLDER/fix.csv: error[B041]: not a plugin for this program: it is not a shared library (too short)\n1 error\n"},
    {"missing file", R"~("fix.csv")~", R"~("fixes.csv")~", 5,
     "FOLDER/fixes.csv: error[B060] /sources/fix: cannot be opened: No such file or directory\n"
     "1 error\n"},
};

std::string in_folder(std::string text, const Workbench& bench) {
  const std::string mark = "FOLDER";
  for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos;)
    text.replace(at, mark.size(), bench.folder());
  return text;
}

}  // namespace

TEST_CASE("every mistake in a config gives this message") {
  const Workbench bench;
  for (const auto& mistake : mistakes) {
    INFO(mistake.name);
    bench.spoil(mistake.from, mistake.to);
    for (const char* verb : {"check", "run"}) {
      const auto outcome = binnacle::test::binnacle(bench, {verb, "bad.json"});
      CHECK(outcome.err == in_folder(mistake.message, bench));
      CHECK(outcome.status == mistake.status);
      CHECK(outcome.out.empty());
    }
  }
}

TEST_CASE("a port takes only blocks of its kind") {
  const Workbench bench;
  bench.write("bad.json", R"~({
  "binnacle": 1,
  "sources": { "fix": { "type": "csv", "path": "fix.csv", "columns": { "z0": { "column": "place", "unit": "m" } } } },
  "filters": { "walk": {
    "blocks": { "place": { "type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1 },
                "speed": { "type": "vector", "size": 1, "unit": "m/s", "init": 0, "sigma": 1 },
                "turn":  { "type": "attitude", "init": { "roll": 0, "pitch": 0, "yaw": 0 }, "sigma": 1 } },
    "process": { "stay":   { "type": "random_constant", "blocks": { "x": "place" } },
                 "cruise": { "type": "random_constant", "blocks": { "x": "speed" } },
                 "aim":    { "type": "random_constant", "blocks": { "x": "turn" } } },
    "measurements": { "seen": { "type": "linear_measurement", "channel": "fix",
                                "blocks": { "x": "turn" }, "sigma": [1] } } } }
}
)~");
  const auto outcome = binnacle::test::binnacle(bench, {"check", "bad.json"});
  CHECK(outcome.err ==
        "bad.json:12:50: error[B016] /filters/walk/measurements/seen/blocks/x: port 'x' of 'linear_measurement' takes "
        "a block of kind 'vector:*:*'; 'turn' is of kind 'attitude'\n"
        "1 error\n");
  CHECK(outcome.status == 3);
}

TEST_CASE("several mistakes are reported at once, in the order of the files") {
  const Workbench bench;
  bench.spoil(R"~("sigma": "1 m")~", R"~("sgima": "1 m")~");
  const auto outcome = binnacle::test::binnacle(bench, {"check", "bad.json", "gone.json", "--set",
                                                        R"~(/evaluate/windows/early=["2 s", "0 s"])~"});
  CHECK(outcome.err ==
        "--set: error[B024] /evaluate/windows/early: the window ends before it begins\n"
        "bad.json:11:86: error[B012] /filters/walk/blocks/place/sgima: unknown key of 'vector'; did you mean "
        "'sigma'?\n"
        "gone.json: error[B003]: cannot read 'gone.json': No such file or directory\n"
        "3 errors\n");
  CHECK(outcome.status == 3);
}

namespace {

/// The good config on other fixes.
Outcome run_on(const Workbench& bench, const std::string& file) {
  bench.spoil("\"fix.csv\"", "\"" + file + "\"");
  return binnacle::test::binnacle(bench, {"run", "bad.json"});
}

}  // namespace

TEST_CASE("what is wrong with data is reported with file and line, exit status 5") {
  const Workbench bench;
  const auto is_reported = [&](const char* name, const std::string& text, const std::string& message) {
    INFO(name);
    bench.write("data.csv", text);
    const auto outcome = run_on(bench, "data.csv");
    CHECK(outcome.err == bench.path("data.csv") + message + "\n1 error\n");
    CHECK(outcome.status == 5);
    CHECK(outcome.out.empty());
  };
  is_reported("NaN in a column", "t,place\n0,1\n1,nan\n2,1\n", ":3: error[B064] /sources/fix: column 'place' is nan");
  is_reported("time running backwards", "t,place\n0,1\n2,1\n1,1\n",
              ":4: error[B063] /sources/fix: time does not increase: 1 s after 2 s");
  is_reported("wrong column count", "t,place\n0,1\n1\n",
              ":3: error[B062] /sources/fix: 1 column where the header has 2");
  is_reported("text for a number", "t,place\n0,1\n1,abc\n",
              ":3: error[B062] /sources/fix: column 'place': 'abc' is not a number");
  is_reported("no rows", "t,place\n", ": error[B066] /sources/fix: no rows after the header");
  is_reported("empty", "", ": error[B066] /sources/fix: the file is empty");
}

TEST_CASE("a .gz that ends in the middle is reported, exit status 5") {
  const Workbench bench;
  std::string text = "t,place\n";
  for (int i = 0; i < 4000; ++i) text += std::to_string(i) + "," + std::to_string(i * i % 997 * 1e-3) + "\n";
  bench.write_gzip("data.csv.gz", text);
  REQUIRE(run_on(bench, "data.csv.gz").status == 0);

  const std::string whole = read_file(bench.path("data.csv.gz"));
  bench.write("data.csv.gz", whole.substr(0, whole.size() / 2));
  const auto outcome = run_on(bench, "data.csv.gz");
  const std::string begin = bench.path("data.csv.gz") + ": error[B061] /sources/fix: gzip data are cut off at byte ";
  CHECK(outcome.err.substr(0, begin.size()) == begin);
  CHECK(outcome.err.find(" rows could be read before\n1 error\n") != std::string::npos);
  CHECK(outcome.status == 5);
}

TEST_CASE("check --json gives the diagnostics to programs") {
  const Workbench bench;
  bench.spoil(R"~("q":)~", R"~("qq":)~");
  const auto outcome = binnacle::test::binnacle(bench, {"check", "bad.json", "--json"});
  CHECK(outcome.status == 3);
  CHECK(outcome.err.empty());
  const auto reported = nlohmann::json::parse(outcome.out);
  REQUIRE(reported.size() == 1);
  CHECK(reported[0]["severity"] == "error");
  CHECK(reported[0]["code"] == "B012");
  CHECK(reported[0]["file"] == "bad.json");
  CHECK(reported[0]["line"] == 14);
  CHECK(reported[0]["column"] == 72);
  CHECK(reported[0]["pointer"] == "/filters/walk/process/wander/qq");
  CHECK(nlohmann::json::parse(binnacle::test::binnacle(bench, {"check", "good.json", "--json"}).out).empty());
}

TEST_CASE("a good config is passed over in silence") {
  const Workbench bench;
  const auto outcome = binnacle::test::binnacle(bench, {"check", "good.json"});
  CHECK(outcome.status == 0);
  CHECK(outcome.out.empty());
  CHECK(outcome.err.empty());
}

}  // namespace mistakes_test
