// SPDX-License-Identifier: Apache-2.0
// conform: hands over to the conformance suite, which is a program of its own.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "output.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

int hand_over(const CLI::App& app) {
  const auto suite = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "binnacle-conform";
  std::vector<std::string> words = {suite.string()};
  for (const auto& word : app.remaining()) words.push_back(word);
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  flush_stdout();
  ::execv(suite.c_str(), arguments.data());
  throw UsageError(
      fmt::format("the conformance suite {} cannot be run ({}); it comes with the package binnacle, and tests/run of a "
                  "clone builds it",
                  suite.string(), std::strerror(errno)));
}

}  // namespace

Verb conform_verb(CLI::App& command) {
  CLI::App* app =
      command.add_subcommand("conform", "Test a plugin library against the plugin contract (details: conform --help)");
  app->prefix_command();  // everything that follows is the suite's
  app->set_help_flag();
  return {app, [app] { return hand_over(*app); }};
}

}  // namespace binnacle::command
