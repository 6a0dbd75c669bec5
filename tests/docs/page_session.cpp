// SPDX-License-Identifier: Apache-2.0
#include "page_session.hpp"

#include <algorithm>
#include <optional>
#include <regex>
#include <sstream>

#include "project_folder.hpp"
#include "typed_elsewhere.hpp"

namespace binnacle::test {

namespace {

const std::string mark = "@@@ ";

struct Command {
  std::string line;
  int status = 0;
};

/// What a session types for it: see page_session.hpp.
std::string typed_for(const Command& command) {
  static const std::regex study(R"(^binnacle study configs/\S+)"), runs(R"( --runs \d+)"),
      takes_long("^binnacle (study|covariance|tune) configs/");
  if (!std::regex_search(command.line, takes_long)) return command.line;
  std::string line = command.line;
  if (std::regex_search(line, study))
    line = std::regex_replace(std::regex_replace(line, runs, ""), study, "$& --runs 1");
  // 124 is the status of `timeout` where it stopped the command.
  const std::string status = std::to_string(command.status);
  return "timeout --signal=INT 10 " + line + "; s=$?; (exit $((s == 124 ? " + status + " : s)))";
}

/// Lines of a fence, those that end in a backslash joined with the next, without comments.
std::vector<Command> commands_of(const std::vector<std::string>& lines) {
  static const std::regex comment(R"(\s+#\s(.*)$)"), status(R"(exit status (\d+))");
  std::vector<Command> commands;
  bool goes_on = false;
  for (std::string line : lines) {
    if (line.empty() || line.front() == '#') continue;
    if (!goes_on) commands.emplace_back();
    std::smatch found, given;
    if (std::regex_search(line, found, comment)) {
      const std::string text = found[1];
      if (std::regex_search(text, given, status)) commands.back().status = std::stoi(given[1]);
      line = found.prefix();
    }
    goes_on = line.back() == '\\';
    commands.back().line += goes_on ? line.substr(0, line.size() - 1) : line;
  }
  return commands;
}

bool is_typed(const Fence& fence) { return fence.language == "sh" && fence.file.empty(); }

std::vector<std::string> typed_in(const Fence& fence) {
  std::vector<std::string> typed;
  for (const auto& line : fence.lines)
    if (line.rfind("$ ", 0) == 0) typed.push_back(line.substr(2));
  return typed;
}

std::string printed_in(const Fence& fence) {
  std::string text;
  for (const auto& line : fence.lines)
    if (line.rfind("$ ", 0) != 0) text += line + "\n";
  return text;
}

class Session {
 public:
  explicit Session(const MarkdownFile& page) : page_(page) {}

  SessionResult result() {
    write_script();
    if (steps_.empty()) return {{}, untried_};
    std::string output;
    folder_.run(script_, output);
    return {compare(output), untried_};
  }

 private:
  struct Step {
    std::string typed;
    std::string expected;  // of a shown one
    bool is_shown;
    int status;
  };

  void write_script() {
    script_ = "PATH=$PWD/build/release/bin:$PATH\n";
    if (has_plugin()) script_ += std::string("BINNACLE_PLUGIN_PATH=$BINNACLE_PLUGIN_PATH:'") + DOCS_PLUGINS + "'\n";
    for (const auto& fence : page_.fences()) {
      if (is_shown(fence)) {
        std::string typed;
        bool runs = true;
        for (const auto& line : typed_in(fence)) {
          runs = runs && can_run(line);
          typed += line + "\n";
        }
        if (runs) add({typed, printed_in(fence), true, 0});
      } else if (is_typed(fence)) {
        for (const auto& command : commands_of(fence.lines))
          if (can_run(command.line)) add({typed_for(command), "", false, command.status});
      } else if (fence.language == "json") {
        write_file(fence);
      }
    }
  }

  /// Whether the reader has built a plugin on the page: that of CMakeLists.txt.
  bool has_plugin() const {
    const auto code = page_.fences("cpp");
    return std::any_of(code.begin(), code.end(),
                       [](const Fence& fence) { return fence.lines.front().rfind("// beacon.cpp: ", 0) == 0; });
  }

  void add(const Step& step) {
    // Braces, and not a shell of its own: what a line sets stays for the next.
    script_ +=
        "{ " + step.typed + "\n} < /dev/null; printf '\\n" + mark + std::to_string(steps_.size()) + " %s\\n' $?\n";
    steps_.push_back(step);
  }

  void write_file(const Fence& fence) {
    static const std::regex name(R"(// ([a-z-]+\.json):.*)");
    std::smatch found;
    if (std::regex_match(fence.lines.front(), found, name)) folder_.write(found[1], fence.text());
  }

  /// Whether the README of the config has the same study, and so types it.
  bool is_in_readme(const std::string& line) const {
    static const std::regex study(
        R"(^binnacle (study|covariance) (configs/[a-z_]+)/[a-z0-9_]+\.json( --(runs|jobs|set) \S+)*$)");
    std::smatch found;
    if (!std::regex_match(line, found, study) || page_.folder() == in_project(found[2])) return false;
    const auto commands = commands_in(MarkdownFile(found.str(2) + "/README.md"));
    return std::find(commands.begin(), commands.end(), line) != commands.end();
  }

  /// False where another test types it, and where there are no data for it.
  bool can_run(const std::string& line) {
    if (typed_elsewhere(line) || is_in_readme(line)) return false;
    static const std::regex data(R"(\.\./shared/data(/[a-z]+)?)");
    for (std::sregex_iterator at(line.begin(), line.end(), data), end; at != end; ++at)
      if (!folder_.has_folder(at->str())) {
        untried_.push_back(line);
        return false;
      }
    return true;
  }

  std::vector<std::string> compare(const std::string& output) const {
    std::vector<std::string> faults;
    std::size_t from = 0;
    for (std::size_t k = 0; k < steps_.size(); ++k) {
      const std::string here = "\n" + mark + std::to_string(k) + " ";
      const auto at = output.find(here, from);
      if (at == std::string::npos) {
        faults.push_back("the session ended in: " + steps_[k].typed + "\n" + output.substr(from));
        break;
      }
      const std::string printed = without_folder(output.substr(from, at - from));
      const int status = std::stoi(output.substr(at + here.size()));
      from = output.find('\n', at + here.size()) + 1;
      if (!steps_[k].is_shown && status != steps_[k].status)
        faults.push_back("exit status " + std::to_string(status) + ": " + steps_[k].typed + "\n" + printed);
      if (!steps_[k].is_shown)
        if (const auto row = row_not_shown(printed))
          faults.push_back("prints another row: " + steps_[k].typed + "\n" + *row);
      if (steps_[k].is_shown && without_times(printed) != without_times(steps_[k].expected))
        faults.push_back("prints something else: " + steps_[k].typed + printed);
    }
    return faults;
  }

  /// Pages show FOLDER for the folder in which the reader types.
  std::string without_folder(std::string printed) const {
    const std::string folder = folder_.path().string();
    for (auto at = printed.find(folder); at != std::string::npos; at = printed.find(folder))
      printed.replace(at, folder.size(), "FOLDER");
    return printed;
  }

  /// A row of a Markdown table that was printed and that the page does not have.
  std::optional<std::string> row_not_shown(const std::string& printed) const {
    std::istringstream stream(printed);
    for (std::string line; std::getline(stream, line);)
      if (line.rfind("| ", 0) == 0 && ("\n" + page_.text()).find("\n" + line + "\n") == std::string::npos) return line;
    return std::nullopt;
  }

  const MarkdownFile& page_;
  ProjectFolder folder_;
  std::string script_;
  std::vector<Step> steps_;
  std::vector<std::string> untried_;
};

}  // namespace

bool is_shown(const Fence& fence) {
  return fence.language == "text" && !fence.lines.empty() && fence.lines.front().rfind("$ ", 0) == 0;
}

SessionResult session_of(const MarkdownFile& page) { return Session(page).result(); }

std::vector<std::string> commands_in(const MarkdownFile& page) {
  std::vector<std::string> commands;
  for (const auto& fence : page.fences()) {
    if (is_typed(fence))
      for (const auto& command : commands_of(fence.lines)) commands.push_back(command.line);
    if (is_shown(fence))
      for (const auto& line : typed_in(fence)) commands.push_back(line);
  }
  return commands;
}

}  // namespace binnacle::test
