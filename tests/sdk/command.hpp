// SPDX-License-Identifier: Apache-2.0
// The binnacle command as a child process.
#pragma once

#include <string>
#include <vector>

#include "workbench.hpp"

namespace binnacle::test {

struct Outcome {
  int status = -1;  // exit status; -1 when a signal ended it
  int signal = 0;
  std::string out;
  std::string err;
};

/// A binnacle that is running, in the bench's folder, without BINNACLE_PLUGIN_PATH.
class Command {
 public:
  Command(const Workbench& bench, const std::vector<std::string>& arguments);
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;
  ~Command();

  void signal(int number) const;
  bool is_running();
  Outcome wait();

 private:
  std::string out_, err_;
  int child_ = -1;
  int status_ = 0;
  bool has_ended_ = false;
};

/// From start to end.
Outcome binnacle(const Workbench& bench, const std::vector<std::string>& arguments);

}  // namespace binnacle::test
