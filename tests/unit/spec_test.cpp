// SPDX-License-Identifier: Apache-2.0
// Parameters against their specs: exact messages, values in SI, defaults, kinds.
#include "spec/check.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "binnacle/eigen.hpp"
#include "binnacle/local_axes.hpp"
#include "catch.hpp"

namespace spec_test {

using namespace binnacle;
using namespace binnacle::internal::spec;
using binnacle::test::Contains;
using Lines = std::vector<std::string>;

namespace {

Document document(const std::string& text) {
  Diagnostics diagnostics;
  Document result = Document::load("c.json", {}, diagnostics, text);
  REQUIRE(diagnostics.text() == "");
  return result;
}

std::vector<ParameterSpec> gauss_markov() {
  return {parameter::vector("tau", "s").sized_by("x").above(0).required().about("correlation time"),
          parameter::vector("sigma", "@x").sized_by("x").at_least(0).required().about("steady state"),
          parameter::choice("form", {"first", "second"}).defaults("\"first\"")};
}

PortUnits port_x(const std::string& unit, int dof) { return {{"x", PortMeasure{parse_unit(unit)->dimension, dof}}}; }

struct Checked {
  ParameterValue value;
  std::string text;
};

Checked check(const std::vector<ParameterSpec>& specs, const std::string& text, const PortUnits& ports = {}) {
  Diagnostics diagnostics;
  const Document config = document(text);
  Checked result;
  result.value = Reader(config, diagnostics).parameters(specs, "gauss_markov", {"type", "blocks"}, ports);
  result.text = diagnostics.text();
  return result;
}

/// What is said of a gauss_markov on a block of three rad/s.
std::string said(const std::string& text) { return check(gauss_markov(), text, port_x("rad/s", 3)).text; }

std::string said_of(ParameterSpec spec, const std::string& value) {
  return check({std::move(spec)}, "{\"v\": " + value + "}").text;
}

ParameterValue value_of(ParameterSpec spec, const std::string& value) {
  const Checked checked = check({std::move(spec)}, "{\"v\": " + value + "}");
  CHECK(checked.text == "");
  REQUIRE(checked.value.members.size() == 1);
  return checked.value.members[0].second;
}

using namespace binnacle::parameter;

}  // namespace

TEST_CASE("what is right arrives in SI, with defaults filled in", "[spec]") {
  const Checked checked =
      check(gauss_markov(), R"({"type": "x", "blocks": {}, "tau": "1 h", "sigma": ["1 deg/h", 2, "3 rad/s"]})",
            port_x("rad/s", 3));
  CHECK(checked.text == "");
  const Parameters parameters(checked.value);
  CHECK(parameters.vector("tau").size() == 3);
  CHECK(parameters.vector("tau")(2) == 3600);
  CHECK(std::abs(parameters.vector("sigma")(0) - 4.84813681109536e-6) < 1e-18);
  CHECK(parameters.vector("sigma")(1) == 2);
  CHECK(parameters.text("form") == "first");
}

TEST_CASE("a wrong key is reported with what was meant", "[spec]") {
  CHECK(said(R"({"tua": "1 h", "sigma": 1})") ==
        "c.json:1:2: error[B012] /tua: unknown key of 'gauss_markov'; did you mean 'tau' (3 values, s, > 0)?");
  CHECK(said(R"({"tau": 1, "sigma": 1, "sigm": 2})") ==
        "c.json:1:24: error[B012] /sigm: unknown key of 'gauss_markov'; did you mean 'sigma' (3 values, rad/s, >= 0)?");
  CHECK(said(R"({"tau": 1, "sigma": 1, "wobble": 2})") ==
        "c.json:1:24: error[B012] /wobble: unknown key of 'gauss_markov'; it takes 'type', 'blocks', 'tau', 'sigma', "
        "'form'");
  CHECK(check({number("tau", "s").above(0)}, R"({"tua": 2})").text ==
        "c.json:1:2: error[B012] /tua: unknown key of 'gauss_markov'; did you mean 'tau' (s, > 0)?");
}

TEST_CASE("a missing key is reported with what it is", "[spec]") {
  CHECK(said(R"({"sigma": 1})") ==
        "c.json:1:1: error[B010]: missing key 'tau' of 'gauss_markov': correlation time (3 values, s, > 0), for "
        "example \"1 h\"");
  CHECK(check({path("file").required().about("the data")}, "{}").text ==
        "c.json:1:1: error[B010]: missing key 'file' of 'gauss_markov': the data (file or folder)");
}

TEST_CASE("a wrong unit is reported with the right one", "[spec]") {
  CHECK(said_of(number("v", "s").above(0), "\"5 deg\"") ==
        "c.json:1:7: error[B007] /v: '5 deg' is an angle; 'v' is a time (s, > 0), for example \"1 h\"");
  CHECK(said_of(number("v", "s").above(0).at_most(60), "\"5\"") ==
        "c.json:1:7: error[B007] /v: '5' has no unit; 'v' is a time (s, > 0, <= 60), for example \"30 s\"");
  CHECK(said_of(number("v", "1"), "\"5 m\"") ==
        "c.json:1:7: error[B007] /v: '5 m' is a length; 'v' is a plain number, for example 1");
  CHECK(said(R"({"tau": "1 h", "sigma": [1, "2 m", 3]})") ==
        "c.json:1:29: error[B007] /sigma/1: '2 m' is a length; 'sigma' is an angular rate (rad/s, >= 0), for example "
        "\"0.2 deg/h\"");
  CHECK(said_of(number("v", "rad/s"), "\"0.2 deg/hr\"") ==
        "c.json:1:7: error[B008] /v: 'v': unknown unit 'deg/hr'; did you mean 'deg/h'?");
  CHECK(said_of(time("v"), "\"2 m\"") ==
        "c.json:1:7: error[B007] /v: '2 m' is a length; 'v' is a time (s), for example \"1 s\"");
}

TEST_CASE("a wrong type is reported with the right one", "[spec]") {
  CHECK(
      said_of(number("v", "s").above(0), "true") ==
      "c.json:1:7: error[B006] /v: 'v' must be a number or text with a unit (s, > 0), for example \"1 h\"; found true");
  CHECK(said_of(number("v", "1"), "{}") ==
        "c.json:1:7: error[B006] /v: 'v' must be a number, for example 1; found an empty object");
  CHECK(said_of(integer("v").at_least(1), "1.5") ==
        "c.json:1:7: error[B006] /v: 'v' must be an integer (>= 1); found the number 1.5");
  CHECK(said_of(boolean("v"), "\"yes\"") ==
        "c.json:1:7: error[B006] /v: 'v' must be true or false; found the text \"yes\"");
  CHECK(said_of(text("v"), "3") == "c.json:1:7: error[B006] /v: 'v' must be a text; found the number 3");
  CHECK(said_of(vector("v", "m"), "3") ==
        "c.json:1:7: error[B006] /v: 'v' must be a list of numbers or texts with a unit (list, m); found the number 3");
  CHECK(said_of(matrix("v", "1", 2, 2), "[1, 2]") ==
        "c.json:1:7: error[B006] /v: 'v' must be a list of rows, each a list (2 by 2); found a list of 2");
  CHECK(said_of(list("v", text("name")), "\"a\"") ==
        "c.json:1:7: error[B006] /v: 'v' must be a list; found the text \"a\"");
  CHECK(said_of(text("v"), "[1]") == "c.json:1:7: error[B006] /v: 'v' must be a text; found a list of 1");
}

TEST_CASE("a number out of range is reported as it was written", "[spec]") {
  CHECK(said_of(number("v", "s").above(0), "\"-5 min\"") ==
        "c.json:1:7: error[B009] /v: 'v' is -5 min, out of range (s, > 0)");
  CHECK(said_of(number("v", "s").above(0), "0") == "c.json:1:7: error[B009] /v: 'v' is 0 s, out of range (s, > 0)");
  CHECK(said_of(number("v", "1").at_least(0).below(1), "1") ==
        "c.json:1:7: error[B009] /v: 'v' is 1, out of range (>= 0, < 1)");
  CHECK(said_of(integer("v").at_most(3), "4") == "c.json:1:7: error[B009] /v: 'v' is 4, out of range (<= 3)");
  CHECK(said_of(time("v").above(0), "\"0 s\"") == "c.json:1:7: error[B009] /v: 'v' is 0 s, out of range (s, > 0)");
}

TEST_CASE("a number that no sensor has is let through with a warning", "[spec]") {
  const auto noise = [] { return vector("v", "rad/s/sqrt(Hz)", 2).at_least(0).plausible(1e-9, 1e-2).defaults("1"); };
  CHECK(said_of(noise(), "0.5") ==
        "c.json:1:7: warning[B111] /v: 'v' is 0.5 rad/sqrt(s), which is implausible; expected: between 1e-09 "
        "rad/sqrt(s) and 0.01 rad/sqrt(s); a number without unit is SI; did you mean \"0.5 deg/sqrt(h)\"?");
  CHECK(said_of(noise(), "[\"0.5 deg/sqrt(h)\", \"500 deg/sqrt(h)\"]") ==
        "c.json:1:27: warning[B111] /v/1: 'v' is 500 deg/sqrt(h) (0.145 rad/sqrt(s)), which is implausible; expected: "
        "between 1e-09 rad/sqrt(s) and 0.01 rad/sqrt(s); is its unit right?");
  CHECK(said_of(number("v", "m").plausible(0, 100), "-1200") ==
        "c.json:1:7: warning[B111] /v: 'v' is -1200 m, which is implausible; expected: at most 100 m; a number without "
        "unit is SI");
  // Nothing, the bounds themselves, and a default.
  for (const char* right : {"0", "1e-9", "1e-2", "[0, 1e-4]"}) CHECK(said_of(noise(), right) == "");
  CHECK(check({noise()}, "{}").text == "");
  Diagnostics diagnostics;
  const Document config = document(R"({"v": 0.5})");
  CHECK(Reader(config, diagnostics).parameters({noise()}, "x").members[0].second.numbers[0] == 0.5);
}

TEST_CASE("wrong lengths and words", "[spec]") {
  CHECK(said_of(vector("v", "m", 3), "[1, 2]") ==
        "c.json:1:7: error[B013] /v: 'v' has 2 elements; it takes 3 values, m");
  CHECK(said_of(matrix("v", "1", 2, 2), "[[1, 2], [3]]") ==
        "c.json:1:16: error[B013] /v/1: row 1 of 'v' has 1 element, the first has 2");
  CHECK(said_of(matrix("v", "1", 2, 2), "[[1, 2]]") == "c.json:1:7: error[B013] /v: 'v' is 1 by 2; it takes 2 by 2");
  CHECK(
      said(R"({"tau": 1, "sigma": 1, "form": "frist"})") ==
      "c.json:1:32: error[B014] /form: 'form' cannot be 'frist'; did you mean 'first'? It is one of 'first', 'second'");
  CHECK(said(R"({"tau": 1, "sigma": 1, "form": "quadratic"})") ==
        "c.json:1:32: error[B014] /form: 'form' cannot be 'quadratic'; it is one of 'first', 'second'");
}

TEST_CASE("everything that is wrong is reported at once", "[spec]") {
  Diagnostics diagnostics;
  const Document config = document(R"({"tau": -1, "sigma": "1 m", "from": 1})");
  Reader(config, diagnostics).parameters(gauss_markov(), "gauss_markov", {}, port_x("m/s", 1));
  CHECK(diagnostics.items().size() == 3);
}

TEST_CASE("values of every type", "[spec]") {
  CHECK(value_of(number("v", "rad"), "\"180 deg\"").number == 3.14159265358979323846);
  CHECK(value_of(number("v", "rad"), "2").text == "rad");
  CHECK(value_of(integer("v"), "3.0").integer == 3);
  CHECK(value_of(integer("v"), "-9223372036854775808").integer == std::numeric_limits<std::int64_t>::min());
  CHECK(value_of(boolean("v"), "true").boolean);
  CHECK(value_of(vector("v", "m", 3), "\"1 km\"").numbers == std::vector<double>{1000, 1000, 1000});
  const auto m = value_of(matrix("v", "1"), "[[1, 2, 3], [4, 5, 6]]");
  CHECK(m.rows == 2);
  CHECK(m.cols == 3);
  CHECK(m.numbers == std::vector<double>{1, 4, 2, 5, 3, 6});
  CHECK(value_of(time("v"), "\"0.1 s\"").integer == 100'000'000);
  CHECK(value_of(time("v"), "1.5").integer == 1'500'000'000);
  CHECK(value_of(time("v"), "\"1700000000.123456789 s\"").integer == 1'700'000'000'123'456'789);
  CHECK(value_of(list("v", number("e", "m")), "[1, \"2 km\"]").elements[1].number == 2000);
  const auto map_value = value_of(map("v", object("e", {number("a", "s").required(), boolean("b").defaults("true")})),
                                  R"({"q": {"a": 1}, "p": {"a": "2 s", "b": false}})");
  REQUIRE(map_value.members.size() == 2);
  CHECK(map_value.members[0].first == "q");
  CHECK(Parameters(map_value.members[0].second).boolean("b"));
  CHECK(Parameters(map_value.members[1].second).number("a") == 2);
}

TEST_CASE("a value of any unit brings its SI unit along", "[spec]") {
  CHECK(value_of(number("v", "*"), "\"2 deg/h\"").text == "rad/s");
  CHECK(value_of(number("v", "*"), "\"ms\"").number == 1e-3);
  CHECK(value_of(number("v", "*"), "\"ms\"").text == "s");
  CHECK(value_of(number("v", "*"), "3").text == "1");
  CHECK(said_of(number("v", "*"), "\"furlong\"").find("c.json:1:7: error[B008] /v: 'v': ") == 0);
}

TEST_CASE("units and sizes of a port", "[spec]") {
  const std::vector<ParameterSpec> specs{vector("q", "@x/sqrt(s)").sized_by("x"), matrix("F", "1/s").sized_by("x")};
  const auto checked = check(specs, R"x({"q": "60 deg/sqrt(h)", "F": [["1 1/s", 0], [0, "1 Hz"]]})x", port_x("rad", 2));
  CHECK(checked.text == "");
  CHECK(std::abs(Parameters(checked.value).vector("q")(1) - 3.14159265358979323846 / 180) < 1e-15);
  CHECK(check(specs, R"({"F": [[1]]})", port_x("rad", 2)).text ==
        "c.json:1:7: error[B013] /F: 'F' is 1 by 1; it takes 2 by 2, 1/s");
  CHECK(check(specs, R"({"q": "1 m"})", port_x("rad", 2)).text ==
        "c.json:1:7: error[B007] /q: '1 m' is a length; 'q' is an angle random walk (rad/sqrt(s)), for example "
        "\"0.05 deg/sqrt(h)\"");
  // A port left open lends nothing, and nothing is held against what is written.
  CHECK(check(specs, R"({"q": "1 m"})").text == "");
}

TEST_CASE("defaults go through the same check", "[spec]") {
  const auto given = check({vector("v", "m", 3).defaults("\"1 km\"")}, R"({"v": "1 km"})");
  const auto implied = check({vector("v", "m", 3).defaults("\"1 km\"")}, "{}");
  CHECK(Parameters(given.value).vector("v") == Parameters(implied.value).vector("v"));
  const std::vector<ParameterSpec> nested{object("v", {number("a", "s").defaults("\"1 min\"")}).defaults("{}")};
  CHECK(Parameters(check(nested, "{}").value).object("v").number("a") == 60);
  CHECK_FALSE(Parameters(check({number("v", "m")}, "{}").value).has("v"));
  CHECK(check({number("v", "s").above(0).defaults("-1")}, "{}").text ==
        "c.json:1:1: error[B009]: default of 'v': 'v' is -1 s, out of range (s, > 0)");
}

TEST_CASE("paths start at the file that names them", "[spec]") {
  Diagnostics diagnostics;
  const Document config =
      Document::load("/somewhere/configs/c.json", {}, diagnostics, R"({"file": "../data/imu.csv"})");
  const auto value =
      Reader(config, diagnostics).parameters({path("file").required(), path("other").defaults("\"x.csv\"")}, "csv");
  CHECK(diagnostics.text() == "");
  CHECK(Parameters(value).text("file") == "/somewhere/data/imu.csv");
  CHECK(Parameters(value).text("other") == "/somewhere/configs/x.csv");
}

TEST_CASE("members of objects and maps are named by their own key", "[spec]") {
  const auto columns = map("columns", object("field", {number("unit", "*").required(), text("column")}));
  CHECK(check({columns}, R"({"columns": {"lat": {"unit": "deg", "colum": "a"}}})").text ==
        "c.json:1:37: error[B012] /columns/lat/colum: unknown key of 'lat'; did you mean 'column' (text)?");
  CHECK(check({columns}, R"({"columns": {"lat": {}}})").text ==
        "c.json:1:21: error[B010] /columns/lat: missing key 'unit' of 'lat' (any unit), for example 1");
}

TEST_CASE("instants and windows", "[spec]") {
  const Document config = document(R"({"a": "228 s", "b": "start+60 s", "c": "start", "d": "start - 1 min", "e": 2.5,
    "f": "strat+60 s", "g": ["3 s", "1 s"], "h": ["1 s", "start+1 s"], "i": ["1 s"], "j": true, "k": "-5 s"})");
  Diagnostics diagnostics;
  const Reader at(config, diagnostics);
  const auto when = [&](const char* key) { return at[key].when(); };
  CHECK(when("a")->time == 228'000'000'000);
  CHECK_FALSE(when("a")->from_start);
  CHECK(when("b")->time == 60'000'000'000);
  CHECK(when("b")->from_start);
  CHECK(when("c")->time == 0);
  CHECK(when("d")->time == -60'000'000'000);
  CHECK(when("e")->time == 2'500'000'000);
  CHECK(when("k")->time == -5'000'000'000);
  CHECK(at["h"].span()->to_is_relative);
  CHECK(diagnostics.empty());
  when("f");
  when("j");
  at["g"].span();
  at["i"].span();
  CHECK_FALSE(when("none"));
  REQUIRE(diagnostics.items().size() == 4);
  CHECK(diagnostics.items()[0].message ==
        "'strat+60 s' does not begin with a number; expected something like '120 s'; "
        "write \"228 s\" or \"start+60 s\"");
  CHECK(diagnostics.items()[1].message == "true is not a time; write \"228 s\" or \"start+60 s\"");
  CHECK(diagnostics.items()[2].message == "the window ends before it begins");
  CHECK(diagnostics.items()[3].message ==
        "a window is [from, to], for example [\"228 s\", \"258 s\"]; found a list of 1");
}

TEST_CASE("keys that the kernel owns", "[spec]") {
  const Document config =
      document(R"({"evaluate": {"aftr": 1}, "sigma": ["1 deg", 2], "n": "three", "names": ["a", 1]})");
  Diagnostics diagnostics;
  const Reader at(config, diagnostics);
  at["evaluate"].check_keys({"after", "windows"}, "'evaluate'");
  CHECK_FALSE(at["evaluate"].require("after", "evaluate", "a time"));
  CHECK_FALSE(at["sigma"].children()[0].number(number("", "m")));
  CHECK(*Reader(config, diagnostics, "/sigma/1").number(number("", "m")) == 2);
  CHECK_FALSE(at["nothing"].number(number("", "m")));
  CHECK_FALSE(at["names"].names());
  CHECK_FALSE(at["n"].is_object("'n'"));
  Lines messages;
  for (const Diagnostic& item : diagnostics.items()) messages.push_back(item.pointer + ": " + item.message);
  CHECK(messages == Lines{"/evaluate/aftr: unknown key of 'evaluate'; did you mean 'after'?",
                          "/evaluate: missing key 'after' of 'evaluate': a time",
                          "/sigma/0: '1 deg' is an angle; '0' is a length (m), for example \"0.5 m\"",
                          "/names: 'names' must be a name or a list of names; found a list of 2",
                          "/n: 'n' must be an object; found the text \"three\""});
}

TEST_CASE("a default may stand elsewhere in the config", "[spec]") {
  const auto read = [](const std::string& text) {
    Diagnostics diagnostics;
    const Document config = document(text);
    Checked result;
    result.value = Reader(config, diagnostics, "/c").parameters({parameter::origin()}, "csv", {"type"});
    result.text = diagnostics.text();
    return result;
  };
  const std::string at_the_top = R"({"origin": {"lat": "49 deg", "lon": 0.1, "height": "115 m"}, "c": )";
  const auto shared = read(at_the_top + R"({"type": "csv"}})");
  CHECK(shared.text == "");
  REQUIRE(Parameters(shared.value).has("origin"));
  CHECK(lla_of(Parameters(shared.value).object("origin"))[2] == 115);
  const auto own = read(at_the_top + R"({"type": "csv", "origin": {"lat": 0.2, "lon": 0.1, "height": "3 m"}}})");
  CHECK(own.text == "");
  CHECK(lla_of(Parameters(own.value).object("origin")) == Eigen::Vector3d(0.2, 0.1, 3));

  const auto none = read(R"({"c": {"type": "csv"}})");
  CHECK(none.text == "");
  CHECK_FALSE(Parameters(none.value).has("origin"));
  CHECK_THROWS_WITH(local_axes_of(Parameters(none.value), "local columns"),
                    Contains("local columns need an origin") && Contains("here or at the top of the config (/origin)"));

  CHECK(read(R"({"origin": {"lat": "49 deg", "height": 3, "long": 1}, "c": {"type": "csv"}})").text ==
        "c.json:1:43: error[B012] /origin/long: unknown key of 'origin'; did you mean 'lon' (rad, >= -6.28319, <= "
        "6.28319)?\n"
        "c.json:1:60: error[B010] /c: 'origin' of 'csv' is that of the config, in which something is wrong (/origin)");
  CHECK_THAT(read(R"({"origin": {"lat": 49, "lon": 8.4, "height": 115}, "c": {"type": "csv"}})").text,
             Contains("/origin/lat: 'lat' is 49 rad, out of range (rad, >= -1.5708, <= 1.5708)"));
  CHECK_THAT(read(R"({"c": {"type": "csv", "origin": "KIT"}})").text,
             Contains("/c/origin: 'origin' must be an object; found the text \"KIT\""));
}

TEST_CASE("a spec that contradicts itself is found out", "[spec]") {
  ComponentSpec spec;
  spec.type = "x";
  CHECK(spec_defects(spec).empty());
  spec.parameters = {number("a", "deg"),
                     number("a", "m"),
                     vector("b", "@y"),
                     choice("c", {}),
                     number("d", "m").required().defaults("1"),
                     number("e", "parsec")};
  CHECK(spec_defects(spec) == Lines{"parameter 'a': the unit 'deg' is not SI", "parameter 'a' appears twice",
                                    "parameter 'b' has the unit of the port 'y', which it lacks",
                                    "parameter 'c' has nothing to choose from",
                                    "parameter 'd' is required and has a default",
                                    "parameter 'e': unknown unit 'parsec'; did you mean 'arcsec'?"});
  spec.parameters = {number("a", "m").defaults("\"1 s\""), integer("b").defaults("{"),
                     choice("c", {"x"}).defaults("\"y\"")};
  CHECK(spec_defects(spec) == Lines{"default of 'a': '1 s' is a time; 'a' is a length (m), for example \"0.5 m\"",
                                    "default of 'b': no JSON: {",
                                    "default of 'c': 'c' cannot be 'y'; it is one of 'x'"});
}

TEST_CASE("kinds and their patterns", "[spec]") {
  CHECK(kind_matches("attitude", "attitude"));
  CHECK_FALSE(kind_matches("attitude", "position"));
  CHECK(kind_matches("*", "vector:3:m"));
  CHECK(kind_matches("vector:*:m", "vector:7:km"));
  CHECK(kind_matches("vector:3:rad/s", "vector:3:deg/h"));
  CHECK_FALSE(kind_matches("vector:3:rad/s", "vector:3:rad"));
  CHECK_FALSE(kind_matches("vector:3:rad/s", "vector:2:rad/s"));
  CHECK_FALSE(kind_matches("vector:3", "vector:3:m"));
  CHECK(kind_matches("*:3:*", "vector:3:m"));
  CHECK_FALSE(kind_matches("velocity.ned", "velocity.ecef"));
  CHECK(*canonical_kind("attitude") == "attitude");
  CHECK(*canonical_kind("vector:3:1/s*rad") == "vector:3:rad/s");
  CHECK(canonical_kind("vector:3:deg/s").error() ==
        "a block's values are SI, so its unit cannot be 'deg/s'; write 'rad/s'");
}

}  // namespace spec_test
