// SPDX-License-Identifier: Apache-2.0
// A Markdown file of this project: its fenced blocks and its links.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace binnacle::test {

struct Fence {
  std::string language;
  std::string file;                // that the line before it names, "<!-- file: PATH -->"; else ""
  std::vector<std::string> lines;  // less the indentation of a fence in a list

  std::string text() const;
};

class MarkdownFile {
 public:
  /// `path` within the project.
  explicit MarkdownFile(const std::string& path);

  const std::string& text() const { return text_; }
  std::vector<Fence> fences(const std::string& language) const;
  /// All of them, in their order.
  std::vector<Fence> fences() const;
  /// Targets of links to files, without what follows a '#'.
  std::vector<std::string> links() const;
  std::filesystem::path folder() const { return path_.parent_path(); }

 private:
  std::filesystem::path path_;
  std::string text_;
};

std::filesystem::path in_project(const std::string& path);
std::string text_of(const std::filesystem::path& path);
/// What a command printed, without the times that it took.
std::string without_times(const std::string& text);
/// JSON without comments and blanks.
std::string without_blanks(std::string text);

}  // namespace binnacle::test
