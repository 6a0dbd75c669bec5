// SPDX-License-Identifier: Apache-2.0
// What every page is checked for: it is quiet, fetches nothing, and shows every figure.
#pragma once

#include "../catch.hpp"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <string>

#include <unistd.h>

#include "browser.hpp"
#include "skip.hpp"

namespace binnacle::test {

namespace fs = std::filesystem;

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("binnacle-report-" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

inline std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Null, and the test is skipped, where there is none; in CI there is one.
inline std::unique_ptr<Browser> browser() {
  auto browser = Browser::start();
  const char* const ci = std::getenv("CI");
  if (!browser && ci && std::string(ci) == "true") FAIL("there is no chromium: apt-get install chromium");
  if (!browser) binnacle::test::skip("no chromium");
  if (browser) browser->size(1400, 1000);
  return browser;
}

/// But for what dygraphs 2.2.1 (Debian 13) says where a plot's range leaves values out, as its buttons do on purpose.
inline void require_quiet(const Browser& browser) {
  bool is_quiet = true;
  for (const auto& line : browser.console()) {
    if (line.find(" points out of X bounds:") != line.npos || line.find(" points out of Y bounds:") != line.npos)
      continue;
    FAIL_CHECK(line);
    is_quiet = false;
  }
  REQUIRE(is_quiet);
}

inline void require_alone(const Browser& browser) {
  for (const auto& address : browser.requests())
    REQUIRE((address.starts_with("file://") || address.starts_with("data:")));
}

inline void add_numbers(const Json& value, const std::string& pointer, std::map<std::string, double>& numbers) {
  if (value.is_number()) numbers[pointer] = value.get<double>();
  if (value.is_structured())
    for (const auto& [key, child] : value.items()) {
      std::string token;
      for (const char c : key) token += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
      add_numbers(child, pointer + "/" + token, numbers);
    }
}

/// Every number of the JSON is on the page under its pointer, in full and, rounded, to be read.
inline void require_figures(Browser& browser, const Json& json, const std::string& root) {
  std::map<std::string, double> numbers;
  add_numbers(json, root, numbers);
  REQUIRE(!numbers.empty());
  const Json shown = browser.value_of(
      "[...document.querySelectorAll('[data-path]')].map((e) => [e.dataset.path, Number(e.dataset.value),"
      " e.textContent.replaceAll('\\u202f', '').replace('\\u2212', '-')])");
  std::map<std::string, int> seen;
  for (const auto& entry : shown) {
    const std::string path = entry[0];
    if (!path.starts_with(root + "/")) continue;
    INFO(path << " reads " << entry[2]);
    const auto number = numbers.find(path);
    if (number == numbers.end()) continue;  // null, true or false
    ++seen[path];
    REQUIRE(entry[1].get<double>() == number->second);
    const std::string text = entry[2];
    char* end = nullptr;
    const double read = std::strtod(text.c_str(), &end);
    if (*end != '\0') continue;  // with a unit of its own: "1.70 s"
    const double resolution = text.find('.') == std::string::npos
                                  ? 0.5
                                  : 0.5 * std::pow(10.0, -static_cast<double>(text.size() - text.find('.') - 1));
    const bool is_close = std::abs(read - number->second) <= 5.001e-4 * std::abs(number->second) ||
                          std::abs(read - number->second) <= 1.001 * resolution;
    REQUIRE(is_close);
  }
  for (const auto& [path, value] : numbers) {
    INFO(path);
    REQUIRE(seen[path] > 0);
  }
}

}  // namespace binnacle::test
