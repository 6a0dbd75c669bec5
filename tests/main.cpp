// SPDX-License-Identifier: Apache-2.0
// The entry point of a test executable. Its exit status: 0 ok, 1 a test failed, 77 all tests were skipped.
#if !__has_include(<catch2/catch_all.hpp>)
#define CATCH_CONFIG_RUNNER
#endif
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "catch.hpp"
#include "junit.hpp"
#include "skip.hpp"

namespace {

bool is_skipped = false;  // the running test
int ran = 0, skipped = 0;
bool has_failed = false;

binnacle::test::JUnit& junit() {
  static binnacle::test::JUnit only;
  return only;
}

/// The environment and the working folder that the process began with; each case begins with them.
class Surroundings {
 public:
  void restore() const {
    if (variables() != variables_) {
      ::clearenv();
      for (const std::string& variable : variables_) {
        const std::size_t equals = variable.find('=');
        ::setenv(variable.substr(0, equals).c_str(), variable.c_str() + equals + 1, 1);
      }
    }
    std::error_code error;  // a folder that is gone
    if (std::filesystem::current_path(error) != folder_) std::filesystem::current_path(folder_, error);
  }

 private:
  static std::vector<std::string> variables() {
    std::vector<std::string> all;
    for (char** variable = environ; variable && *variable; ++variable)
      if (std::string(*variable).find('=') != std::string::npos) all.emplace_back(*variable);
    return all;
  }

  std::vector<std::string> variables_ = variables();
  std::filesystem::path folder_ = std::filesystem::current_path();
};

const Surroundings& surroundings() {
  static const Surroundings at_begin;
  return at_begin;
}

#if __has_include(<catch2/catch_all.hpp>)
using Events = Catch::EventListenerBase;
using Noted = void;
#else
using Events = Catch::TestEventListenerBase;
using Noted = bool;  // whether messages may be forgotten
#endif

struct Counter : Events {
  using Events::Events;
  void testCaseStarting(const Catch::TestCaseInfo& test) override {
    is_skipped = false;
    surroundings().restore();
    junit().begin(test.name);
  }
  Noted assertionEnded(const Catch::AssertionStats& stats) override {
    const Catch::AssertionResult& result = stats.assertionResult;
    if (!result.isOk()) {
      std::ostringstream text;
      text << result.getSourceInfo() << ": ";
      if (result.hasExpression()) text << result.getExpression() << " with " << result.getExpandedExpression();
      text << ' ' << result.getMessage();
      for (const auto& info : stats.infoMessages) text << '\n' << info.message;
      junit().failure(text.str());
    }
    return Noted(true);
  }
  void testCaseEnded(const Catch::TestCaseStats& stats) override {
    ++ran;
    if (is_skipped) ++skipped;
    if (stats.totals.assertions.failed > 0) has_failed = true;
    junit().end();
  }
};
CATCH_REGISTER_LISTENER(Counter)

}  // namespace

void binnacle::test::skip(const std::string& reason) {
  is_skipped = true;
  junit().skipped(reason);
  std::printf("SKIPPED: %s\n", reason.c_str());
  std::fflush(stdout);
#ifdef SKIP
  SKIP(reason);
#endif
}

int main(int count, char* arguments[]) {
  junit();  // takes its variable out of the environment
  surroundings();
  Catch::Session session;
  if (const int usage = session.applyCommandLine(count, arguments); usage != 0) return 1;
  // The result is the number of failed checks under v2, and 4 where all were skipped under v3: neither may be taken for
  // the other.
  const int result = session.run();
  junit().close();
  if (skipped > 0) std::printf("%d of %d test cases were skipped\n", skipped, ran);
  if (ran > 0 && skipped == ran && !has_failed) return binnacle::test::exit_skipped;
  return result == 0 ? 0 : 1;
}
