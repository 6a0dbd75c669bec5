// SPDX-License-Identifier: Apache-2.0
#include "page_session.hpp"

#include <filesystem>
#include <regex>
#include <sstream>

#include "../recorded_data.hpp"
#include "project_folder.hpp"

namespace binnacle::test {

namespace {

const std::string shared = "../shared/data";
const std::string mark = "@@@ ";

struct Command {
  std::string line;
  int status = 0;
};

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

bool is_shown(const Fence& fence) {
  return fence.language == "text" && !fence.lines.empty() && fence.lines.front().rfind("$ ", 0) == 0;
}

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
    for (const auto& fence : page_.fences()) {
      if (is_shown(fence)) {
        std::string typed;
        bool runs = true;
        for (auto line : typed_in(fence)) {
          runs = runs && can_run(line);
          typed += line + "\n";
        }
        if (runs) add({typed, printed_in(fence), true, 0});
      } else if (fence.language == "sh") {
        for (auto [line, status] : commands_of(fence.lines))
          if (can_run(line)) add({line, "", false, status});
      } else if (fence.language == "json") {
        write_file(fence);
      }
    }
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

  /// False where there are no data for it; otherwise with the data's folder in it.
  bool can_run(std::string& line) {
    const auto at = line.find(shared);
    if (at == std::string::npos) return true;
    static const std::regex kind(R"(\.\./shared/data/([a-z]+))");
    std::smatch found;
    const bool names_one = std::regex_search(line, found, kind);
    const auto folder = names_one ? recorded_folder(found[1]) : std::filesystem::path();
    if (!names_one || !std::filesystem::is_directory(folder)) {
      untried_.push_back(line);
      return false;
    }
    line.replace(at, static_cast<std::size_t>(found.length()), folder.string());
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
      const std::string printed = output.substr(from, at - from);
      const int status = std::stoi(output.substr(at + here.size()));
      from = output.find('\n', at + here.size()) + 1;
      if (!steps_[k].is_shown && status != steps_[k].status)
        faults.push_back("exit status " + std::to_string(status) + ": " + steps_[k].typed + "\n" + printed);
      if (steps_[k].is_shown && without_times(printed) != without_times(steps_[k].expected))
        faults.push_back("prints something else: " + steps_[k].typed + printed);
    }
    return faults;
  }

  const MarkdownFile& page_;
  ProjectFolder folder_;
  std::string script_;
  std::vector<Step> steps_;
  std::vector<std::string> untried_;
};

}  // namespace

SessionResult session_of(const MarkdownFile& page) { return Session(page).result(); }

int commands_in(const MarkdownFile& page) {
  std::size_t commands = 0;
  for (const auto& fence : page.fences()) {
    if (fence.language == "sh") commands += commands_of(fence.lines).size();
    if (is_shown(fence)) commands += typed_in(fence).size();
  }
  return static_cast<int>(commands);
}

}  // namespace binnacle::test
