// SPDX-License-Identifier: Apache-2.0
// The binnacle command as a child process.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <sys/resource.h>

#include "workbench.hpp"

namespace binnacle::test {

struct Outcome {
  int status = -1;  // exit status; -1 when a signal ended it
  int signal = 0;
  std::string out;
  std::string err;
  double peak_memory = 0;  // resident, bytes
};

/// How it is started, if not in the usual way.
struct Start {
  std::vector<std::string> launcher = {};  // "mpirun", "-n", "2"
  std::map<std::string, std::string> environment = {};
  std::string program = BINNACLE_TEST_COMMAND;
};

/// A binnacle that is running, in the bench's folder, without BINNACLE_PLUGIN_PATH.
class Command {
 public:
  Command(const Workbench& bench, const std::vector<std::string>& arguments, const Start& start = {});
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;
  ~Command();

  int id() const { return child_; }
  void signal(int number) const;
  bool is_running();
  Outcome wait();

 private:
  std::string out_, err_;
  int child_ = -1;
  int status_ = 0;
  struct rusage usage_ = {};
  bool has_ended_ = false;
};

/// From start to end.
Outcome binnacle(const Workbench& bench, const std::vector<std::string>& arguments, const Start& start = {});

}  // namespace binnacle::test
