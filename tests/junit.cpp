// SPDX-License-Identifier: Apache-2.0
#include "junit.hpp"

#include <sys/resource.h>

#include <chrono>
#include <cstdlib>

namespace binnacle::test {

namespace {

constexpr std::size_t most_failures = 20, longest_failure = 4000;  // of one case

std::string escaped(const std::string& text) {
  std::string result;
  for (const char character : text) {
    switch (character) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '"': result += "&quot;"; break;
      case '\n': result += "&#10;"; break;
      default: result += static_cast<unsigned char>(character) < ' ' ? '?' : character;  // XML has no other controls
    }
  }
  return result;
}

double wall_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double processor_s_of(int whose) {
  rusage usage{};
  ::getrusage(whose, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Of this process and the children that it waited for.
double processor_s() { return processor_s_of(RUSAGE_SELF) + processor_s_of(RUSAGE_CHILDREN); }

}  // namespace

JUnit::JUnit() {
  const char* path = std::getenv("BINNACLE_JUNIT");
  if (!path || !*path) return;
  file_ = std::fopen(path, "w");
  if (!file_) {
    std::fprintf(stderr, "BINNACLE_JUNIT: cannot write %s\n", path);
    return;
  }
  std::fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite>\n", file_);
  std::fflush(file_);
  // The processes that a case starts write no file.
  ::unsetenv("BINNACLE_JUNIT");
}

void JUnit::close() {
  if (!file_) return;
  std::fputs("</testsuite>\n", file_);
  std::fclose(file_);
  file_ = nullptr;
}

void JUnit::begin(const std::string& name) {
  name_ = name;
  failures_.clear();
  skipped_.clear();
  wall_s_ = wall_s();
  processor_s_ = processor_s();
}

void JUnit::failure(const std::string& text) {
  if (failures_.size() < most_failures) failures_.push_back(text.substr(0, longest_failure));
}

void JUnit::skipped(const std::string& reason) { skipped_ = reason; }

void JUnit::end() {
  if (!file_) return;
  std::fprintf(file_, "<testcase name=\"%s\" time=\"%.3f\" processor=\"%.3f\">", escaped(name_).c_str(),
               wall_s() - wall_s_, processor_s() - processor_s_);
  for (const std::string& failure : failures_)
    std::fprintf(file_, "\n<failure message=\"%s\"/>", escaped(failure).c_str());
  if (failures_.empty() && !skipped_.empty())
    std::fprintf(file_, "\n<skipped message=\"%s\"/>", escaped(skipped_).c_str());
  std::fputs("</testcase>\n", file_);
  std::fflush(file_);
}

}  // namespace binnacle::test
