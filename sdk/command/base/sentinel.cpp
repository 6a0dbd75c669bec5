// SPDX-License-Identifier: Apache-2.0
#include "sentinel.hpp"

#include <atomic>
#include <cstdlib>
#include <exception>

#include <unistd.h>

#include "binnacle/plugin_call.hpp"
#include "output.hpp"
#include "unfinished.hpp"

namespace binnacle::command {

namespace {

std::atomic<bool> has_left{false};

std::string culprit() {
  const std::string call = plugin_call_under_way();
  return call.empty() ? "something in it" : call;
}

/// Of exit(); the status that it was given is lost, since 0 must not be believed.
void end_of_exit() {
  if (has_left) return;
  abandon(culprit() + " ended the program by exit(); unfinished results are lost");
}

/// Of what nobody catches on a thread, "" where nothing was thrown.
std::string thrown_by_nobody() {
  const auto thrown = std::current_exception();
  if (!thrown) return "";
  try {
    std::rethrow_exception(thrown);
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "something that is not a std::exception";
  }
}

[[noreturn]] void end_of_terminate() {
  const std::string thrown = thrown_by_nobody();
  print_error(culprit() + " ended the program by std::terminate()" + (thrown.empty() ? "" : ": " + thrown));
  Unfinished::remove_all();
  std::abort();
}

}  // namespace

void watch_exit() {
  std::atexit(end_of_exit);
  std::at_quick_exit(end_of_exit);
  std::set_terminate(end_of_terminate);
}

int leave(int status) {
  has_left = true;
  return status;
}

void abandon(const std::string& message) noexcept {
  print_error(message);
  Unfinished::remove_all();
  ::_exit(failed);
}

}  // namespace binnacle::command
