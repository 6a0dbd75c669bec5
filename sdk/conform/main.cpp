// SPDX-License-Identifier: Apache-2.0
// binnacle-conform: the conformance suite of a plugin library, behind `binnacle conform`.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <thread>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "driver.hpp"
#include "results.hpp"

namespace binnacle::conform {

namespace {

enum ExitStatus { ok = 0, failed = 1, usage = 2, data = 5 };

struct CommandLine {
  Options options;
  std::string library, json, junit;
  bool verbose = false, strict = false, list = false, in_process = false;
};

void list_checks() {
  for (const auto& check : all_checks()) fmt::print("{:<32} level {}  {}\n", check.id, check.level, check.text);
}

int write(const std::string& file, const std::string& text) {
  if (file == "-") {
    std::fputs(text.c_str(), stdout);
    return ok;
  }
  const std::string temporary = file + ".part";
  std::ofstream out(temporary, std::ios::binary);
  out << text;
  out.close();
  if (!out || std::rename(temporary.c_str(), file.c_str()) != 0) {
    std::remove(temporary.c_str());
    fmt::print(stderr, "error: cannot write {}\n", file);
    return data;
  }
  return ok;
}

int carry_out(const CommandLine& line) {
  if (line.list) return list_checks(), ok;
  if (line.json == "-" && line.junit == "-") {
    fmt::print(stderr, "error: --json and --junit cannot both go to stdout\n");
    return usage;
  }
  if (!std::filesystem::exists(line.library)) {
    fmt::print(stderr, "error: there is no file {}\n", line.library);
    return usage;
  }
  Options options = line.options;
  options.library = std::filesystem::canonical(line.library);
  if (line.in_process) return run_in_process(options) == 0 ? ok : failed;
  const bool prints = line.json != "-" && line.junit != "-";
  if (prints) fmt::print("{}  level {}  seed {}\n", line.library, options.level, options.seed);
  const Verdict verdict = run_checks(options, [&](const Outcome& outcome) {
    if (prints && line.verbose) fmt::print("{}", one_line(outcome)), std::fflush(stdout);
  });
  if (prints) fmt::print("{}", summary(verdict, options, line.strict, line.verbose));
  int status = ok;
  if (!line.json.empty()) status = std::max(status, write(line.json, to_json(verdict, options, line.strict)));
  if (!line.junit.empty()) status = std::max(status, write(line.junit, to_junit(verdict, options, line.strict)));
  return status != ok ? status : verdict.passes(line.strict) ? ok : failed;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Tests a plugin library against the plugin contract: each check of each component in its own process"};
  app.name("binnacle conform");
  app.footer("Exit status: 0 it conforms, 1 it does not (or nothing ran), 2 usage, 5 a report could not be written.");
  CommandLine line;
  line.options.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  app.add_option("LIBRARY", line.library, "Plugin library, NAME.so");
  app.add_option("--level", line.options.level, "Checks and trials: 1 (quick) to 10 (thorough)")
      ->check(CLI::Range(1, 10))
      ->capture_default_str();
  app.add_option("--seed,--reproduce", line.options.seed, "Seed of all random numbers")->capture_default_str();
  app.add_option("--only", line.options.filters,
                 "Checks to run, TYPE:CHECK with * and ?, such as '*:numbers.*', with their prerequisites");
  app.add_option("--time-limit", line.options.time_limit, "Time limit of one check in seconds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--jobs", line.options.jobs, "Checks at once")->check(CLI::Range(1, 256));
  app.add_option("--json", line.json, "Write the results as JSON to this file; - for stdout");
  app.add_option("--junit", line.junit, "Write the results as JUnit XML to this file; - for stdout");
  app.add_flag("--in-process", line.in_process,
               "Run the one check that --only names in this process, without time limit: for gdb and valgrind");
  app.add_flag("--strict", line.strict, "Warnings fail");
  app.add_flag("--verbose", line.verbose, "Print every check, not only those with findings");
  app.add_flag("--list", line.list, "List the checks");
  try {
    app.parse(argc, argv);
    if (line.library.empty() && !line.list) throw CLI::RequiredError("LIBRARY");
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    fmt::print(stderr, "error: {}\nRun 'binnacle conform --help' for the list.\n", error.what());
    return usage;
  }
  try {
    return carry_out(line);
  } catch (const std::invalid_argument& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return usage;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return failed;
  }
}

}  // namespace binnacle::conform

int main(int argc, char** argv) { return binnacle::conform::main(argc, argv); }
