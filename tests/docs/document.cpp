// SPDX-License-Identifier: Apache-2.0
#include "document.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace binnacle::test {

namespace {

std::string file_named_in(const std::string& line) {
  const std::string mark = "<!-- file: ", end = " -->";
  return line.rfind(mark, 0) == 0 ? line.substr(mark.size(), line.size() - mark.size() - end.size()) : "";
}

}  // namespace

std::filesystem::path in_project(const std::string& path) {
  return std::filesystem::path(BINNACLE_TEST_PROJECT) / path;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string without_times(const std::string& text) {
  static const std::regex times(R"([0-9.]+ (ns|us|ms|s|min)( per step)?\n)");
  return std::regex_replace(text, times, "TIME$2\n");
}

std::string without_blanks(std::string text) {
  text = std::regex_replace(text, std::regex(R"((^|\s)//[^\n]*)"), "");
  return std::regex_replace(text, std::regex(R"(\s+)"), "");
}

std::string Fence::text() const {
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  return text;
}

MarkdownFile::MarkdownFile(const std::string& path) : path_(in_project(path)), text_(text_of(path_)) {}

std::vector<Fence> MarkdownFile::fences() const {
  std::vector<Fence> found;
  std::istringstream stream(text_);
  bool is_inside = false;
  std::size_t indent = 0;
  std::string before;
  for (std::string line; std::getline(stream, line); before = line) {
    const std::size_t at = std::min(line.find_first_not_of(' '), line.size());
    if (line.compare(at, 3, "```") == 0) {
      is_inside = !is_inside;
      indent = at;
      if (is_inside) found.push_back({line.substr(at + 3), file_named_in(before), {}});
    } else if (is_inside) {
      found.back().lines.push_back(line.substr(std::min(at, indent)));
    }
  }
  return found;
}

std::vector<Fence> MarkdownFile::fences(const std::string& language) const {
  auto found = fences();
  std::erase_if(found, [&](const Fence& fence) { return fence.language != language; });
  return found;
}

std::vector<std::string> MarkdownFile::links() const {
  static const std::regex link(R"(\]\(([A-Za-z0-9_./-]+)(#[A-Za-z0-9_-]*)?\))");
  std::vector<std::string> found;
  for (std::sregex_iterator at(text_.begin(), text_.end(), link), end; at != end; ++at) found.push_back((*at)[1]);
  return found;
}

}  // namespace binnacle::test
