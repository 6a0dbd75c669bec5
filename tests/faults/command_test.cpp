// SPDX-License-Identifier: Apache-2.0
// A plugin that exits, loops or throws while the command runs: status 1 or 5, plugin, component, call and sample named,
// nothing half-written, finished results kept.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "catch.hpp"
#include "command.hpp"

namespace command_test {

using namespace binnacle::test;
namespace fs = std::filesystem;

namespace {

/// `sick`: the component that has the fault, "tick", "pass", "sink" or "move".
void write_config(const Workbench& bench, const std::string& sick, const std::string& fault, const std::string& call,
                  const std::string& after = "3 s") {
  const auto of = [&](const std::string& name) {
    return name == sick ? R"(, "fault": ")" + fault + R"(", "call": ")" + call + R"(", "after": ")" + after + R"(")"
                        : std::string();
  };
  bench.write("sick.json", R"({
  "binnacle": 1,
  "plugins": [")" SICK_PLUGIN R"("],
  "sources": { "tick": { "type": "ticking")" +
                               of("tick") + R"( } },
  "transforms": { "pass": { "type": "passing", "input": "tick")" +
                               of("pass") + R"( } },
  "filters": { "f": {
    "trust": false,
    "blocks": { "x": { "type": )" +
                               (sick == "x" ? "\"resting\", \"init\": 0" + of("x")
                                            : std::string(R"("vector", "size": 1, "unit": "m", "init": 0)")) +
                               R"(, "sigma": 1 } },
    "process": { "move": { "type": "moving", "blocks": { "x": "x" })" +
                               of("move") + R"( } },
    "measurements": { "z": { "type": "linear_measurement", "channel": "pass", "blocks": { "x": "x" }, "sigma": [1] } }
  } },
  "sinks": { "sink": { "type": "sinking", "input": "pass")" +
                               of("sink") + R"( } },
  "reference": [{ "channel": "tick", "blocks": { "f/x": ["z0"] } }],
  "study": { "runs": 2, "metrics": ["f/z/nis"] }
}
)");
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) names.push_back(entry.path().string());
  std::sort(names.begin(), names.end());
  return names;
}

Outcome run(const Workbench& bench) {
  return binnacle::test::binnacle(bench, {"run", "sick.json", "--out", "out", "--summary", "summary.json"});
}

void wait_until(Command& command, const std::string& path) {
  while (command.is_running() && !fs::exists(path)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
}

}  // namespace

TEST_CASE("the components of these tests work as long as they are not asked to fail") {
  const Workbench bench;
  write_config(bench, "none", "none", "");
  const auto outcome = run(bench);
  CHECK(outcome.err == "");
  CHECK(outcome.status == 0);
}

TEST_CASE("exit() in a plugin is exit status 1 and an error that names the call, and leaves nothing") {
  struct Case {
    const char *component, *call, *expected;
  };
  const Workbench bench;
  for (const auto& [component, call, expected] :
       {Case{"tick", "constructor", "component 'ticking': its constructor"},
        Case{"tick", "open", "component 'ticking': open"}, Case{"tick", "start", "component 'ticking': start"},
        Case{"tick", "next", "component 'ticking': next at 2 s"}, Case{"pass", "on", "component 'passing': on at 3 s"},
        Case{"move", "propagate", "component 'moving': propagate at 3 s"},
        Case{"sink", "on", "component 'sinking': on at 3 s"}, Case{"sink", "close", "component 'sinking': close"}})
    for (const char* fault : {"exit", "quick_exit"}) {
      write_config(bench, component, fault, call);
      const auto before = names_in(bench.folder());
      const auto outcome = run(bench);
      INFO(component << " " << call << " " << outcome.err);
      CHECK(outcome.status == 1);
      CHECK(outcome.out == "");
      CHECK(outcome.err.find(std::string("error: plugin 'sick', ") + expected) == 0);
      CHECK(outcome.err.find("ended the program by exit()") != std::string::npos);
      CHECK(names_in(bench.folder()) == before);
    }
}

TEST_CASE("exit() in a plugin leaves an earlier run's results as they are") {
  const Workbench bench;
  write_config(bench, "none", "none", "");
  REQUIRE(run(bench).status == 0);
  const auto record = read_file(bench.path("out/f.csv"));
  write_config(bench, "move", "exit", "propagate");
  const auto before = names_in(bench.folder());
  CHECK(run(bench).status == 1);
  CHECK(read_file(bench.path("out/f.csv")) == record);
  CHECK(names_in(bench.folder()) == before);
}

TEST_CASE("a study in which a plugin exits is exit status 1, and goes on from its journal") {
  const Workbench bench;
  write_config(bench, "move", "exit", "propagate");
  const auto outcome = binnacle::test::binnacle(bench, {"study", "sick.json", "--jobs", "2", "--out", "out"});
  CHECK(outcome.status == 1);
  CHECK(outcome.err.find("error: plugin 'sick', component 'moving': propagate at 3 s ended") != std::string::npos);
  CHECK(fs::exists(bench.path("out/study.journal")));
  CHECK_FALSE(fs::exists(bench.path("out/study.json")));
}

TEST_CASE("std::terminate() in a plugin names the call") {
  const Workbench bench;
  write_config(bench, "pass", "terminate", "on");
  const auto before = names_in(bench.folder());
  const auto outcome = run(bench);
  CHECK(outcome.signal == SIGABRT);
  CHECK(outcome.err == "error: plugin 'sick', component 'passing': on at 3 s ended the program by std::terminate()\n");
  CHECK(names_in(bench.folder()) == before);
}

TEST_CASE("a plugin that loops is ended within two seconds of the first signal, by name") {
  struct Case {
    const char *component, *call, *expected;
  };
  for (const auto& [component, call, expected] : {Case{"tick", "next", "component 'ticking': next at 2 s"},
                                                  Case{"move", "propagate", "component 'moving': propagate at 3 s"}})
    for (const int signal : {SIGTERM, SIGINT}) {
      const Workbench bench;
      write_config(bench, component, "loop", call);
      const auto before = names_in(bench.folder());
      Command command(bench, {"run", "sick.json", "--out", "out", "--summary", "summary.json"});
      wait_until(command, bench.path("out"));
      const auto begin = std::chrono::steady_clock::now();
      command.signal(signal);
      const auto outcome = command.wait();
      CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(2));
      CHECK(outcome.status == 1);
      CHECK(outcome.err == std::string("error: interrupted, but the run does not stop; under way: plugin 'sick', ") +
                               expected + "; nothing was written\n");
      CHECK(names_in(bench.folder()) == before);
    }
}

TEST_CASE("a second signal still ends a plugin that loops at once") {
  const Workbench bench;
  write_config(bench, "move", "loop", "propagate");
  Command command(bench, {"run", "sick.json", "--out", "out"});
  wait_until(command, bench.path("out"));
  command.signal(SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  command.signal(SIGTERM);
  CHECK(command.wait().signal == SIGTERM);
}

TEST_CASE("a study in which a plugin loops keeps its finished runs") {
  const Workbench bench;
  write_config(bench, "move", "none", "propagate");
  const std::vector<std::string> arguments{"study", "sick.json", "--jobs", "1", "--out", "out"};
  std::string text = read_file(bench.path("sick.json"));
  const std::string from = R"("metrics": ["f/z/nis"])";
  // Variants that share their samples advance together: these do not share.
  text.replace(text.find(from), from.size(),
               from + R"(, "variants": { "well": { "sources": { "tick": { "after": "9 s" } } },
    "ill": { "filters": { "f": { "process": { "move": { "fault": "loop" } } } } } })");
  bench.write("sick.json", text);
  Command command(bench, arguments);
  wait_until(command, bench.path("out/study.journal"));
  command.signal(SIGTERM);
  const auto outcome = command.wait();
  CHECK(outcome.status == 1);
  CHECK(outcome.err.find("component 'moving': propagate at 3 s; the same command continues from here") !=
        std::string::npos);
  const std::string journal = read_file(bench.path("out/study.journal"));
  CHECK(std::count(journal.begin(), journal.end(), '\n') == 2);  // its head and the first run, of "well"
  CHECK_FALSE(fs::exists(bench.path("out/study.json")));
}

TEST_CASE("a block that fails while it is scored is named with its call") {
  const Workbench bench;
  const std::string who = "plugin 'sick', component 'resting': minus at 0 s";
  write_config(bench, "x", "throw", "minus", "0 s");
  const auto thrown = run(bench);
  INFO(thrown.err);
  CHECK(thrown.status == 1);
  CHECK(thrown.err.find("block 'x': " + who + " threw: lost my marbles") != std::string::npos);
  write_config(bench, "x", "exit", "minus", "0 s");
  const auto ended = run(bench);
  CHECK(ended.status == 1);
  CHECK(ended.err.starts_with("error: " + who + " ended the program by exit()"));
}

TEST_CASE("a block that fails while its initial value is written is named with its place") {
  const Workbench bench;
  write_config(bench, "x", "throw", "write", "0 s");
  const auto thrown = run(bench);
  INFO(thrown.err);
  CHECK(thrown.status == 4);
  CHECK(
      thrown.err.find("sick.json:8:51: error[B045] /filters/f/blocks/x/init: plugin 'sick', component 'resting': write "
                      "threw: lost my marbles") != std::string::npos);
}

TEST_CASE("a constructor that loops is ended by the first signal, in run, check and study") {
  for (const char* verb : {"run", "check", "study"}) {
    const Workbench bench;
    write_config(bench, "tick", "loop", "constructor");
    Command command(bench, {verb, "sick.json"});
    std::this_thread::sleep_for(std::chrono::seconds(2));  // it has no file to wait for
    command.signal(SIGTERM);
    const auto outcome = command.wait();
    INFO(verb << " " << outcome.err);
    CHECK(outcome.status == 1);
    CHECK(outcome.err.find("under way: plugin 'sick', component 'ticking': its constructor") != std::string::npos);
  }
}

TEST_CASE("what a source, transform or sink throws names plugin, component, call and sample") {
  struct Case {
    const char *component, *call;
    int status;
    std::string expected;
  };
  const Workbench bench;
  for (const auto& [component, call, status, expected] :
       {Case{"tick", "start", 1, "/sources/tick: plugin 'sick', component 'ticking': start threw: "},
        Case{"tick", "next", 5, "/sources/tick: plugin 'sick', component 'ticking': next at 2 s threw: "},
        Case{"pass", "start", 1, "/transforms/pass: plugin 'sick', component 'passing': start threw: "},
        Case{"pass", "on", 1, "/transforms/pass: plugin 'sick', component 'passing': on at 3 s threw: "},
        Case{"sink", "open", 5, "/sinks/sink: plugin 'sick', component 'sinking': open threw: "},
        Case{"sink", "on", 5, "/sinks/sink: plugin 'sick', component 'sinking': on at 3 s threw: "},
        Case{"sink", "close", 5, "/sinks/sink: plugin 'sick', component 'sinking': close at 9 s threw: "}})
    for (const auto& [fault, what] : {std::pair("throw", "lost my marbles"), std::pair("refuse", "not today")}) {
      write_config(bench, component, fault, call);
      const auto before = names_in(bench.folder());
      const auto outcome = run(bench);
      INFO(outcome.err);
      CHECK(outcome.status == status);
      CHECK(outcome.err.find("error[B045] " + expected + what) != std::string::npos);
      CHECK(outcome.err.find("internal") == std::string::npos);
      CHECK(names_in(bench.folder()) == before);
    }
}

}  // namespace command_test
