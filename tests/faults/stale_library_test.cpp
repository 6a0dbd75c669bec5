// SPDX-License-Identifier: Apache-2.0
// A library in a searched folder that cannot be loaded: a warning, unless the config needs what it may bring.
#include <filesystem>

#include "catch.hpp"
#include "command.hpp"

namespace stale_library_test {

using namespace binnacle::test;
namespace fs = std::filesystem;

namespace {

/// BINNACLE_PLUGIN_PATH with a file that is no library.
Start with_stale(const Workbench& bench) {
  fs::create_directory(bench.path("plugins"));
  bench.write("plugins/stale.so", std::string(200, 'x'));
  Start start;
  start.environment["BINNACLE_PLUGIN_PATH"] = bench.path("plugins");
  return start;
}

const char* const why = "not a plugin for this program: it is not a shared library (not ELF)";

}  // namespace

TEST_CASE("a stale library in a plugin folder stops neither a config nor list") {
  const Workbench bench;
  const Start start = with_stale(bench);
  const std::string warning = bench.path("plugins/stale.so") + ": warning[B047]: not loaded: " + why + "\n1 warning\n";
  for (const auto& arguments :
       {std::vector<std::string>{"run", "good.json"}, {"check", "good.json"}, {"list"}, {"describe", "core/vector"}}) {
    const auto outcome = binnacle::test::binnacle(bench, arguments, start);
    INFO(arguments.front());
    CHECK(outcome.status == 0);
    CHECK(outcome.err == warning);
  }
}

TEST_CASE("a type that a stale library may bring is an error that names the file and the reason") {
  const Workbench bench;
  const Start start = with_stale(bench);
  bench.spoil(R"("type": "random_walk")", R"("type": "wandering")");
  const auto outcome = binnacle::test::binnacle(bench, {"check", "bad.json"}, start);
  CHECK(outcome.status == 4);
  CHECK(outcome.err.find("error[B047] /filters/walk/process/wander/type: unknown process model 'wandering'; '" +
                         bench.path("plugins/stale.so") + "' may contain it, but is not loaded: " + why) !=
        std::string::npos);
}

}  // namespace stale_library_test
