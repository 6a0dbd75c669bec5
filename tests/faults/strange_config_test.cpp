// SPDX-License-Identifier: Apache-2.0
// A config from a stranger: it runs no code that the user has not allowed, and its texts do nothing to a terminal.
#include <filesystem>

#include "catch.hpp"
#include "command.hpp"

namespace strange_config_test {

using namespace binnacle::test;
namespace fs = std::filesystem;

namespace {

/// bad.json, which names a plugin beside it, the way an archive brings one. Its tick's constructor would end the process.
void write_strange(const Workbench& bench) {
  fs::copy_file(SICK_PLUGIN, bench.path("sick.so"));
  bench.spoil(R"("title")", R"("plugins": ["sick.so"], "title")");
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("every verb that takes a config refuses a stranger's plugin, and repeats the command that would load it") {
  const Workbench bench;
  write_strange(bench);
  for (const auto& words : {std::vector<std::string>{"check", "bad.json"},
                            {"run", "bad.json", "--out", "it's out"},
                            {"explain", "bad.json"},
                            {"graph", "bad.json"},
                            {"study", "bad.json"},
                            {"observe", "bad.json"},
                            {"covariance", "bad.json"},
                            {"inspect", "bad.json"},
                            {"allan", "bad.json", "--channel", "fix"}}) {
    const auto outcome = binnacle::test::binnacle(bench, words);
    INFO(words.front() << ": " << outcome.err);
    CHECK(outcome.status == 4);
    CHECK(has(outcome.err, "bad.json:3:15: error[B048] /plugins/0: '" + bench.path("sick.so") + "' is not loaded: "));
    CHECK_FALSE(fs::exists(bench.path("it's out")));
    if (words.front() == "run")
      CHECK(has(outcome.err, "note: to run that code: binnacle run bad.json --out 'it'\\''s out' --allow-plugins\n"));
    if (words.front() == "check")
      CHECK(has(outcome.err, "note: to run that code: binnacle check bad.json --allow-plugins\n"));
  }
}

TEST_CASE("with --allow-plugins it is loaded") {
  const Workbench bench;
  write_strange(bench);
  for (const char* verb : {"check", "run"}) {
    const auto outcome = binnacle::test::binnacle(bench, {verb, "bad.json", "--allow-plugins"});
    INFO(outcome.err);
    CHECK(outcome.status == 0);
  }
}

TEST_CASE("a plugin that the user names on the command line needs no more") {
  const Workbench bench;
  fs::copy_file(SICK_PLUGIN, bench.path("sick.so"));
  CHECK(binnacle::test::binnacle(bench, {"check", "good.json", "--set", "/plugins=[\"sick.so\"]"}).status == 0);
}

TEST_CASE("control characters of a config do nothing to a terminal") {
  const Workbench bench;
  const std::string title = R"(A \u001b[31mplace\u001b[0m\u0007 \u009b2J\u007f\nverdict: all is well)";
  bench.spoil("A place that wanders", title);
  const std::string shown = R"(A \x1b[31mplace\x1b[0m\x07 \x9b2J\x7f\x0averdict: all is well)";
  const auto run = binnacle::test::binnacle(bench, {"run", "bad.json"});
  CHECK(run.out.starts_with(shown + "\n\n"));
  std::string in_dot = shown;
  for (std::size_t at = 0; (at = in_dot.find('\\', at)) != std::string::npos; at += 2) in_dot.insert(at, "\\");
  const auto graph = binnacle::test::binnacle(bench, {"graph", "bad.json"});
  CHECK(has(graph.out, "label=\"" + in_dot + "\";"));
  bench.spoil(R"("fix": { "type": "csv")", R"("f\u001b[2Jx": { "type": "csv")");
  for (const char* verb : {"run", "explain", "graph", "check", "list"}) {
    const auto outcome = binnacle::test::binnacle(bench, {verb, "bad.json"});
    for (const std::string& text : {outcome.out, outcome.err}) CHECK(text.find('\x1b') == std::string::npos);
  }
}

}  // namespace strange_config_test
