// SPDX-License-Identifier: Apache-2.0
#include "typed_elsewhere.hpp"

namespace binnacle::test {

const std::vector<TypedElsewhere>& typed_elsewhere() {
  static const std::vector<TypedElsewhere> all{
      // What builds, tests, installs and packs.
      {R"(tests/run\b)", "CONTRIBUTING.md", "CI is `.ci/run`: `tests/run`"},
      {R"(sdk/run\b)", "tests/docs/first_command.sh", "sdk/run configs/quickstart.json"},
      {R"((cmake|cmake --build) )", "tests/package/consume.sh", "\"$cmake\" --build"},
      {R"(ninja )", "sdk/setup.sh", "ninja -C \"$binnacle_build\""},
      {R"(ctest --test-dir )", "tests/package/consume.sh", "\"$ctest\" --test-dir"},
      {R"(tar -xzf binnacle-)", "tests/package/tarball.sh", "tar -xzf"},
      {R"(sdk/dist/(build|release)\b)", "tests/package/dist_pack.sh",
       "sdk/dist/pack"},  // build packs in a clean system, as root
      {R"((python3 -m venv |env/bin/))", "tests/package/dist.sh", "pip install --no-index"},
      {R"((export PATH=\$PWD/binnacle-|binnacle run binnacle-0|man -M binnacle-))", "tests/package/dist.sh",
       "install_tarball"},
      {R"(apt-get install )", "tests/package/install_page.sh", "apt-get -s install"},
      {R"(apt-get purge )", "tests/package/install_page.sh",
       "says 'apt-get purge binnacle'"},  // is only read: nothing is installed
      {R"(xargs rm < build/release/install_manifest\.txt)", "tests/package/install_page.sh", "xargs rm <"},
      {R"(binnacle run /usr/share/binnacle/configs/)", "tests/package/install_page.sh",
       "share/binnacle/configs/quickstart.json >"},
      {R"(man binnacle)", "tests/help/man_pages.sh", "man "},
      {R"(source PREFIX/share/bash-completion/)", "tests/package/install_page.sh", "(source share/bash-completion"},
      // The folder of a new plugin: templates, and the guide that repeats one.
      {R"(binnacle run config\.json)", "tests/package/consume.sh", "run_config"},
      {R"(cd battery && binnacle run battery\.json)", "tests/package/examples.sh", "for example in battery"},
      // Tests with a command of their own.
      {R"(build/release/bin/[a-z]+_tests ")", "tests/tiers.cmake", "binnacle_add_catch_test"},
      {R"(configs/benchmarks/run\b)", "tests/docs/benchmarks_test.py", "test_its_commands_are_understood"},
      {R"(tests/faults_matrix/run\b)", "tests/faults_matrix/CMakeLists.txt", "/run\" --study"},
      {R"(tests/faults_matrix/outliers\b)", "tests/faults_matrix/CMakeLists.txt", "/outliers\""},
      {R"(tests/faults_matrix/loops\b)", "tests/faults_matrix/CMakeLists.txt", "/loops\""},
      {R"(tests/faults_matrix/draws\b)", "tests/faults_matrix/CMakeLists.txt", "/draws\""},
      {R"(tests/inspect/planted\.py )", "tests/inspect/CMakeLists.txt", "planted.py"},
      {R"(tests/bench/run\b)", "tests/bench/CMakeLists.txt", "/run\""},
      {R"(tests/bench/budget\.py )", "tests/bench/CMakeLists.txt", "budget.py"},
      {R"(tests/fuzz/run\b)", "tests/run", "tests/fuzz/run\" --seconds 10"},
      {R"(tests/compare/run\b)", "tests/compare/CMakeLists.txt", "compare_test.py"},
      {R"((binnacle run live\.json &|gpsd -N ))", "tests/nmea/gpsd_test.cpp", "gpsd"},
  };
  return all;
}

const TypedElsewhere* typed_elsewhere(const std::string& command) {
  for (const auto& entry : typed_elsewhere())
    if (std::regex_search(command, std::regex("^" + entry.pattern))) return &entry;
  return nullptr;
}

}  // namespace binnacle::test
