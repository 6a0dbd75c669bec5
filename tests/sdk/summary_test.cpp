// SPDX-License-Identifier: Apache-2.0
// What the summary of a run shows of gates, and of blocks that have no reference.
#include "catch.hpp"

#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace summary_test {

using namespace binnacle::test;

namespace {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// The good config's summary over 200 fixes.
template <class Value>
std::string summary_of(Value&& value, const std::vector<std::string>& options = {}) {
  const Workbench bench;
  std::string fixes = "t,place\n";
  for (int i = 0; i < 200; ++i) fixes += std::to_string(i) + "," + std::to_string(value(i)) + "\n";
  bench.write("fix.csv", fixes);
  std::vector<std::string> arguments{"run", "good.json"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  return binnacle::test::binnacle(bench, arguments).out;
}

/// A short stand of the quickstart, half of its fixes withheld.
Outcome stand(const std::string& reference, const std::vector<std::string>& options) {
  const Workbench bench;
  std::vector<std::string> arguments{"run", BINNACLE_TEST_PROJECT "/configs/quickstart.json"};
  for (const std::string& set :
       {std::string("/sources/drive/segments=[{\"do\": \"still\", \"duration\": \"20 s\"}]"),
        std::string("/filters/ins/measurements/fix/withhold={\"every\": 2}"),
        std::string("/evaluate/windows={\"late\": [\"start+10 s\", \"start+19 s\"]}"), "/reference=" + reference})
    arguments.insert(arguments.end(), {"--set", set});
  arguments.insert(arguments.end(), options.begin(), options.end());
  return binnacle::test::binnacle(bench, arguments);
}

}  // namespace

TEST_CASE("a gate that refuses far more than its probability says is a note with the figures") {
  const auto jitter = [](int i) { return i % 2 ? 0.15 : -0.15; };
  CHECK_FALSE(has(summary_of(jitter), "note:"));
  CHECK_FALSE(has(summary_of([&](int i) { return i == 50 ? 50.0 : jitter(i); }), "note:"));
  const auto text = summary_of([&](int i) { return i % 10 == 5 ? 50.0 : jitter(i); });
  INFO(text);
  CHECK(has(text, "  note: the gate of 'seen' refused 10 % (20 of 200 samples) where 0.1 % was expected\n"));
}

TEST_CASE("a gate that no sample came near is a note with the figure") {
  const auto text = summary_of([](int i) { return i % 2 ? 0.001 : -0.001; });
  INFO(text);
  CHECK(has(text, "  note: the gate of 'seen' was never near: the largest NIS of 200 samples is "));
  const auto by_row =
      summary_of([](int i) { return i % 2 ? 0.001 : -0.001; },
                 {"--set", R"(/filters/walk/measurements/seen/gate={"probability": 0.999, "by": "row"})"});
  CHECK(has(by_row, "  note: the gate of 'seen' was never near: the largest NIS of 200 samples is "));
}

TEST_CASE("a first sample that contradicts the initial sigma is a note with the row, and later outliers are none") {
  const auto jitter = [](int i) { return i % 2 ? 0.15 : -0.15; };
  const std::vector<std::string> open{"--set", "/filters/walk/measurements/seen/gate=null"};
  const std::string begin = "  note: the first sample of 'seen', ";
  CHECK_FALSE(has(summary_of(jitter, open), begin));
  CHECK_FALSE(has(summary_of([&](int i) { return i == 1 ? 50.0 : jitter(i); }, open), begin));
  const auto text = summary_of([&](int i) { return i == 0 ? 50.0 : jitter(i); }, open);
  INFO(text);
  CHECK(has(text, begin));
  CHECK(has(text, "contradicts the initial values and their sigmas: row seen 0 is 50 m from its prediction, "));
  CHECK_FALSE(has(text, "derived block"));
}

TEST_CASE("errors far beyond P are a note, which names the state or block that is farthest out") {
  const std::string reference = R"([{"channel": "drive.truth", "blocks": {"ins/position": ["lat", "lon", "height"],
    "ins/velocity": ["vn", "ve", "vd"], "ins/attitude": ["roll", "pitch", "yaw"]}}])";
  const std::string begin = "  note: NEES of '";
  const auto right = stand(reference, {}),
             wrong = stand(reference, {"--set", R"(/sources/drive/gnss/lever_arm=["20 m", 0, 0])"});
  INFO(right.out << wrong.out);
  CHECK(has(right.out, "NEES"));
  CHECK_FALSE(has(right.out, begin));
  CHECK(has(wrong.out, begin + "position' is "));
  CHECK(has(wrong.out,
            " over 3 degrees of freedom: P is too small for these errors, or the reference is less accurate than the "
            "filter\n"));
}

TEST_CASE("a position that starts at the antenna's fixes with a sigma below the lever arm is noted") {
  const auto stand_with = [](const std::string& sigma) {
    const std::string fixes = R"(["2 cm", "2 cm", "4 cm"])", lever_arm = R"(["-1.5 m", "0 m", "-0.8 m"])";
    const auto run = stand("[]", {"--set", "/sources/drive/gnss/lever_arm=" + lever_arm, "--set",
                                  "/sources/drive/gnss/position_sigma=" + fixes, "--set",
                                  R"(/filters/ins/derived={"antenna": {"type": "lever_arm", "blocks": {"position": )"
                                  R"("position", "attitude": "attitude"}, "lever_arm": )" +
                                      lever_arm + "}}",
                                  "--set", "/filters/ins/measurements/fix/stack/position/blocks/position=antenna",
                                  "--set", "/filters/ins/measurements/fix/stack/position/sigma=" + fixes, "--set",
                                  R"(/filters/ins/blocks/position/init={"channel": "drive.gnss"})", "--set",
                                  "/filters/ins/blocks/position/sigma=" + sigma});
    return run.out + run.err;
  };
  const auto tight = stand_with(R"("2 cm")"), wide = stand_with(R"("2 m")");
  INFO(tight);
  CHECK(has(tight, "  note: the first sample of 'fix', "));
  CHECK(has(tight,
            "'fix' measures a derived block, but a state block starts at samples of the same channel as they "
            "are: its initial 'sigma' must cover the difference, such as a lever arm\n"));
  INFO(wide);
  CHECK_FALSE(has(wide, "the first sample of 'fix'"));
  CHECK(has(wide, "verdict: ins ok"));
}

namespace {

/// Fixes with a pattern in place of noise of 0.1 m, which a filter without a gate believes in.
nlohmann::json verdict_over(double (*pattern)(int), const std::string& q, const std::string& trust = "{}") {
  const auto json =
      summary_of(pattern, {"--json", "--set", "/filters/walk/measurements/seen/gate=null", "--set",
                           "/filters/walk/process/wander/q=" + q, "--set", "/filters/walk/blocks/place/sigma=0.02 m",
                           "--set", "/filters/walk/trust=" + trust});
  return nlohmann::json::parse(json).at("filters").at("walk").at("verdict");
}

/// Neighbours are as often equal as opposite.
double white(int i) { return i / 2 % 2 ? 0.02 : -0.02; }
double alternating(int i) { return i % 2 ? 0.02 : -0.02; }
double persisting(int i) { return i / 20 % 2 ? 0.02 : -0.02; }

}  // namespace

TEST_CASE("a measurement far more precise than specified is a note with the likely intent, and stands at the verdict") {
  const auto verdict = verdict_over(white, "1e-6 m/sqrt(s)");
  INFO(verdict.dump());
  CHECK(verdict.at("state") == "ok");
  REQUIRE(verdict.at("notes").size() == 1);
  const auto& note = verdict.at("notes").at(0);
  CHECK(note.at("code") == "B128");
  CHECK(note.at("measurement") == "seen");
  CHECK(note.at("likely") == "sigma");
  CHECK(note.at("text") ==
        "'seen' has a mean NIS of 0.04 over 200 samples, and 1 is expected; likely intent: standard "
        "deviations of about 0.2 of those specified");
  const auto text = summary_of(white, {"--set", "/filters/walk/measurements/seen/gate=null", "--set",
                                       "/filters/walk/process/wander/q=1e-6 m/sqrt(s)"});
  INFO(text);
  CHECK(has(text, "  note: B128 'seen' has a mean NIS of 0.0"));
  CHECK(has(text, "verdict: walk ok (conservative: seen)\n"));
}

TEST_CASE("where innovations persist or alternate, the note has another likely cause") {
  CHECK(verdict_over(persisting, "1e-6 m/sqrt(s)").at("notes").at(0).at("likely") == "persisting_errors");
  CHECK(verdict_over(alternating, "1 m/sqrt(s)").at("notes").at(0).at("likely") == "process_noise");
  const auto text = summary_of(persisting, {"--set", "/filters/walk/measurements/seen/gate=null", "--set",
                                            "/filters/walk/process/wander/q=1e-6 m/sqrt(s)"});
  INFO(text);
  CHECK(has(text, "are those of errors that persist: the sigmas may be right\n"));
  CHECK(has(text, "verdict: walk ok\n"));
}

TEST_CASE("no note is made of what trust excepts, nor of innovations as large as specified") {
  CHECK_FALSE(verdict_over(white, "1e-6 m/sqrt(s)", R"({"except": ["seen"]})").contains("notes"));
  CHECK_FALSE(has(summary_of([](int i) { return i / 2 % 2 ? 0.1 : -0.1; },
                             {"--set", "/filters/walk/measurements/seen/gate=null", "--set",
                              "/filters/walk/process/wander/q=1e-6 m/sqrt(s)"}),
                  "B128"));
}

TEST_CASE("a filter that starts late says since when there are estimates, and what it waited for") {
  const Workbench bench;
  bench.write("fix.csv", "t,place\n1,0.1\n2,0.2\n3,0.15\n4,0.3\n5,0.25\n");
  bench.write("truth.csv", "t,place\n3.5,0.2\n4.5,0.3\n");
  std::vector<std::string> arguments{"run", "good.json"};
  const auto text = [&] { return binnacle::test::binnacle(bench, arguments).out; };
  CHECK_FALSE(has(text(), "first estimate"));
  arguments.insert(arguments.end(), {"--set", R"(/filters/walk/blocks/place/init={"channel": "truth"})"});
  INFO(text());
  CHECK(has(text(), "\n  first estimate at 3.500 s, 2.5 s after the data begin: it waited for truth\n"));
  arguments.push_back("--json");
  const auto walk = nlohmann::json::parse(text()).at("filters").at("walk");
  CHECK(walk.at("waited") == nlohmann::json({{"seconds", 2.5}, {"for", {"truth"}}}));
}

TEST_CASE("blocks without reference are shown where withheld samples are one") {
  const auto json = nlohmann::json::parse(stand(R"({"withheld": "fix"})", {"--json"}).out);
  const auto& unscored = json.at("filters").at("ins").at("unscored");
  CHECK(unscored.at("attitude.yaw").at("unit") == "deg");
  CHECK(unscored.at("attitude.yaw").at("sigma") > 0.01);
  CHECK(unscored.contains("gyro_bias.x"));
  CHECK_FALSE(unscored.contains("position.lat"));
  const auto text = stand(R"({"withheld": "fix"})", {}).out;
  INFO(text);
  CHECK(has(text, "without reference"));
  CHECK(has(text, "attitude.roll"));
}

TEST_CASE("windows show a block that is scored without its norm") {
  // Roll and pitch alone give no tilt.
  const auto text = stand(R"([{"withheld": "fix"}, {"channel": "drive.truth",
    "blocks": {"ins/attitude": {"roll": "roll", "pitch": "pitch"}}}])",
                          {})
                        .out;
  INFO(text);
  std::istringstream lines(text);
  bool is_shown = false;
  for (std::string line; std::getline(lines, line);)
    is_shown = is_shown || (has(line, "position.horizontal") && has(line, "attitude.roll") && has(line, "[deg]"));
  CHECK(is_shown);
}

TEST_CASE("the verdict names what was not watched") {
  const auto jitter = [](int i) { return i % 2 ? 0.15 : -0.15; };
  CHECK(has(summary_of(jitter), "verdict: walk ok\n"));
  CHECK(has(summary_of(jitter, {"--set", "/filters/walk/trust=false"}), "verdict: walk ok (not watched: seen)\n"));
  const auto json =
      nlohmann::json::parse(summary_of(jitter, {"--json", "--set", R"(/filters/walk/trust={"except": ["seen"]})"}));
  CHECK(json.at("filters").at("walk").at("verdict").at("unwatched") == std::vector<std::string>{"seen"});
}

TEST_CASE("a span of evaluate without a sample of a reference is reported") {
  const std::string reference = R"({"withheld": "fix"})";
  const auto late = stand(reference, {"--set", R"(/evaluate/after="start+1000 s")"});
  INFO(late.err);
  CHECK(late.status == 0);
  CHECK(has(late.err, "B121"));
  CHECK(has(late.err, "'ins' lies in 'after' to 'until'"));
  const auto window = stand(reference, {"--set", R"(/evaluate/windows={"never": ["start+10 h", "start+11 h"]})"});
  CHECK(has(window.err, "'ins' lies in 'never'"));
  CHECK_FALSE(has(stand(reference, {}).err, "B121"));
}

TEST_CASE("an 'after' that is meant from the start, where times are seconds of the week, is found") {
  const std::string reference = R"([{"channel": "drive.truth", "blocks": {"ins/position": ["lat", "lon", "height"]}}])";
  const auto with_after = [&](const std::string& after, const std::string& start_time) {
    return stand(reference, {"--set", "/sources/drive/start_time=" + start_time, "--set", "/evaluate/after=" + after})
        .err;
  };
  const auto early = with_after("5 s", "345600 s");
  INFO(early);
  CHECK(
      has(early,
          "warning[B129] /evaluate/after: 'after' is 5.0 s, long before 'ins' starts at 345600.0 s, so nothing is left "
          "out; likely intent: \"start+5 s\""));
  CHECK_FALSE(has(with_after("start+5 s", "345600 s"), "B129"));
  CHECK_FALSE(has(with_after("345605 s", "345600 s"), "B129"));
  CHECK_FALSE(has(with_after("5 s", "0 s"), "B129"));
}

}  // namespace summary_test
