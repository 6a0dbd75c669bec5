// SPDX-License-Identifier: Apache-2.0
// What became of each test case, as JUnit: into the file that BINNACLE_JUNIT names, without which nothing is written.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace binnacle::test {

/// One executable's file. Each case is in it as soon as it has ended: a crash leaves what ended before.
class JUnit {
 public:
  JUnit();

  void begin(const std::string& name);
  void failure(const std::string& text);
  void skipped(const std::string& reason);
  void end();
  /// The end of the file, not by a destructor: a process that a case forked runs those too.
  void close();

 private:
  std::FILE* file_ = nullptr;
  std::string name_;
  std::vector<std::string> failures_;
  std::string skipped_;
  double wall_s_ = 0, processor_s_ = 0;  // at the case's begin
};

}  // namespace binnacle::test
