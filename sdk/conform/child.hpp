// SPDX-License-Identifier: Apache-2.0
// A child process with a time limit, and what goes with it.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>

#include <sys/types.h>

#include "run_check.hpp"

namespace binnacle::conform {

using Clock = std::chrono::steady_clock;

/// A child process that talks on a pipe and may be stopped.
class Child {
 public:
  Child(const std::function<int(const Wire&)>& work, double time_limit);
  Child(const Child&) = delete;
  ~Child();

  /// Takes in what it said; true once it is over.
  bool poll();
  /// −1, which poll() passes over, once nobody can say anything more.
  int pipe() const { return is_silent_ ? -1 : pipe_; }
  const std::string& said() const { return said_; }
  bool timed_out() const { return timed_out_; }
  int status() const { return status_; }
  double seconds() const { return seconds_; }
  std::string stage() const { return std::string(stage_, strnlen(stage_, stage_bytes)); }

 private:
  void drain();
  void stop();
  void end(int status);

  pid_t pid_ = -1;
  int pipe_ = -1, status_ = 0;
  char* stage_ = nullptr;
  double limit_ = 0, seconds_ = 0;
  Clock::time_point start_;
  std::string said_;
  bool is_over_ = false, timed_out_ = false, is_silent_ = false;
};

/// "SIGSEGV"
std::string signal_name(int signal);

/// Ctrl-C ends the run as an exception does: children are stopped, their folders go.
class Interruptible {
 public:
  Interruptible();
  ~Interruptible();
  static void check();
};

/// A folder of its own, gone at the end.
class Scratch {
 public:
  Scratch();
  ~Scratch();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace binnacle::conform
