// SPDX-License-Identifier: Apache-2.0
#include "command_main.hpp"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "binnacle/diagnostic.hpp"
#include "installation.hpp"
#include "output.hpp"
#include "sentinel.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

constexpr const char* exit_statuses =
    "Exit status: 0 ok, 1 a check failed or a filter broke, 2 usage, 3 config, 4 plugin, 5 data.\n"
    "Results go to stdout, errors to stderr. NO_COLOR disables colours.";

/// A program of the command: its own verbs, and its name among the modules.
struct Program {
  std::string_view module;
  std::span<const OwnVerb> own;

  const OwnVerb* find(std::string_view name) const {
    const auto found = std::ranges::find(own, name, &OwnVerb::name);
    return found == own.end() ? nullptr : &*found;
  }
};

/// A verb of a module, for the list of --help: named first it is handed over before, and words in front of it are refused.
Verb listed_verb(CLI::App& command, std::string_view name) {
  CLI::App* app = add_verb(command, name);
  app->prefix_command();  // everything that follows is the module's
  app->set_help_flag();
  return {app, nullptr};
}

/// The verb that is named first, and only it: the options of all cost more than `version` does. Else all of them.
std::vector<Verb> add_verbs(CLI::App& command, const Program& program, std::string_view first) {
  std::vector<Verb> verbs;
  if (const OwnVerb* named = program.find(first)) {
    verbs.push_back(named->add(command));
  } else {
    for (const auto& known : known_verbs()) {
      const OwnVerb* own = program.find(known.name);
      verbs.push_back(own ? own->add(command) : listed_verb(command, known.name));
    }
  }
  // What is left over is looked at in refuse_leftovers(), which knows what was likely meant.
  command.allow_extras();
  for (const auto& verb : verbs) verb.app->allow_extras();
  return verbs;
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* option : app.get_options())
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string meant(const std::string& word, const std::vector<std::string>& candidates) {
  const std::string near = closest(word, candidates);
  return near.empty() ? "" : fmt::format("; did you mean '{}'?", near);
}

std::string help_hint(const CLI::App* app) {
  return fmt::format("\nRun 'binnacle {}--help' for the list.", app ? app->get_name() + " " : "");
}

void refuse_word(const CLI::App& app, const std::string& word, const std::string& hint) {
  if (word.rfind('-', 0) == 0) {
    const std::string name = word.substr(0, word.find('='));
    throw UsageError(fmt::format("unknown option '{}'{}{}", name, meant(name, option_names(app)), hint));
  }
}

/// What is an option of a verb here, and may be looked for as a verb.
std::string verb_meant(const std::string& word, const std::vector<std::string>& names) {
  if (word.starts_with("smooth")) return "; did you mean 'run CONFIG --smooth'?";
  return meant(word, names);
}

/// Unknown verbs, options and surplus words, the first of them, with what was likely meant.
void refuse_leftovers(const CLI::App& command, const std::vector<Verb>& verbs) {
  const auto chosen = std::find_if(verbs.begin(), verbs.end(), [](const Verb& verb) { return verb.app->parsed(); });
  for (const auto& word : command.remaining()) {
    refuse_word(command, word, help_hint(nullptr));
    std::vector<std::string> names;
    for (const auto& verb : verbs) names.push_back(verb.app->get_name());
    throw UsageError(fmt::format("unknown verb '{}'{}{}", word, verb_meant(word, names), help_hint(nullptr)));
  }
  if (chosen == verbs.end()) return;
  if (chosen->app->get_prefix_command()) return;
  const auto surplus = chosen->app->remaining();
  for (const auto& word : surplus) refuse_word(*chosen->app, word, help_hint(chosen->app));
  if (!surplus.empty())
    throw UsageError(fmt::format("'{}' is one argument too many{}", surplus.front(), help_hint(chosen->app)));
}

/// Help was printed: 0. Otherwise a usage error.
int refuse(const CLI::App& command, const CLI::ParseError& error, const std::vector<Verb>& verbs) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
    const int status = command.exit(error);
    flush_stdout();
    return status;
  }
  refuse_leftovers(command, verbs);
  const auto chosen = std::find_if(verbs.begin(), verbs.end(), [](const Verb& verb) { return verb.app->parsed(); });
  if (chosen == verbs.end()) {
    std::cerr << command.help();
    return usage;
  }
  throw UsageError(error.what() + help_hint(chosen->app));
}

/// What is usual elsewhere: --version, -V, help, help VERB.
std::vector<std::string> usual_words(int argc, char** argv) {
  std::vector<std::string> words(argv, argv + argc);
  if (argc < 2) return words;
  if (words[1] == "--version" || words[1] == "-V") words[1] = "version";
  if (words[1] != "help") return words;
  words.erase(words.begin() + 1);
  const bool is_of_all = words.size() < 2;
  if (is_of_all || known_verb(words[1])) words.insert(words.begin() + (is_of_all ? 1 : 2), "--help");
  return words;
}

/// Whoever calls a module instead of the command.
[[noreturn]] void refuse_foreign(const Program& program) {
  std::vector<std::string> names;
  for (const auto& own : program.own) names.push_back(fmt::format("'binnacle {}'", own.name));
  throw UsageError(fmt::format("{} is a part of the binnacle command, for {}", program.module, joined(names)));
}

int carry_out(int argc, char** argv, const Program& program) {
  std::vector<std::string> words = usual_words(argc, argv);
  const std::string first = words.size() > 1 ? words[1] : "";
  if (!program.find(first)) {
    if (!program.module.empty()) refuse_foreign(program);
    if (const KnownVerb* known = known_verb(first)) hand_over(*known, {words.begin() + 1, words.end()});
  }
  CLI::App command{"Error-state Kalman filters for INS/GNSS and other sensors, composed from JSON"};
  command.name("binnacle");
  command.require_subcommand(1);
  command.footer(exit_statuses);
  const auto verbs = add_verbs(command, program, first);
  try {
    // CLI11 takes them from the back, without the program's name.
    command.parse(std::vector<std::string>(words.rbegin(), words.rend() - 1));
  } catch (const CLI::ParseError& error) {
    return refuse(command, error, verbs);
  }
  refuse_leftovers(command, verbs);
  for (const auto& verb : verbs)
    if (verb.app->parsed()) {
      const int status = verb.act();
      flush_stdout();
      return status;
    }
  return usage;
}

/// Threads are all that is asked of the system and not turned into a message of its own.
std::string words_of(const std::system_error& error) {
  if (error.code() != std::errc::resource_unavailable_try_again) return std::string("internal: ") + error.what();
  return "no thread can be started: " + error.code().message() + "; raise the limit (ulimit -u, or -v of memory)";
}

/// Of a file of data in place of a config: what takes data.
void hint_at_inspect(const Diagnostics& diagnostics) {
  if (diagnostics.items().empty()) return;
  const Diagnostic& first = diagnostics.items().front();
  const std::string& file = first.origin.file;
  if (first.code != "B001" || first.origin.line > 1 || is_config(file)) return;
  print_note("a config is JSON, and " + file + " is none; of data, 'binnacle inspect " + file +
             " --write my.json' proposes one");
}

/// Of a config of the README that is not here, but comes with the command.
void hint_at_shared(const Diagnostics& diagnostics) {
  namespace fs = std::filesystem;
  if (diagnostics.items().empty() || diagnostics.items().front().code != "B003") return;
  const fs::path file = diagnostics.items().front().origin.file;
  std::error_code error;
  if (file.is_absolute() || file.begin() == file.end() || *file.begin() != "configs") return;
  const fs::path shared = prefix() / "share/binnacle" / file;
  if (fs::exists(shared, error)) print_note("it comes with this command as " + shared.string());
}

int guarded_main(int argc, char** argv, const Program& program) {
  try {
    return carry_out(argc, argv, program);
  } catch (const Error& error) {
    print_diagnostics(error.diagnostics());
    hint_at_inspect(error.diagnostics());
    hint_at_shared(error.diagnostics());
    return error.exit_status();
  } catch (const UsageError& error) {
    print_error(error.what());
    return usage;
  } catch (const OutputError& error) {
    print_error(error.what());
    return data;
  } catch (const std::bad_alloc&) {
    print_error("memory is exhausted; raise the limit (ulimit -v), or record less");
    return failed;
  } catch (const std::system_error& error) {
    print_error(words_of(error));
    return failed;
  } catch (const std::exception& error) {
    print_error(std::string("internal: ") + error.what());
    return failed;
  } catch (...) {
    print_error("internal: something was thrown that is not a std::exception");
    return failed;
  }
}

}  // namespace

int command_main(int argc, char** argv, std::string_view module, std::span<const OwnVerb> own) {
  hold_standard_streams();
  std::signal(SIGXFSZ,
              SIG_IGN);  // a write that goes beyond the limit fails with EFBIG, and is reported like a full disk
  keep_command_line(argc, argv);
  watch_exit();
  return leave(guarded_main(argc, argv, Program{module, own}));
}

}  // namespace binnacle::command
