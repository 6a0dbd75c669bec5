// SPDX-License-Identifier: Apache-2.0
#include "command.hpp"

#include <csignal>
#include <cstdlib>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace binnacle::test {

namespace {

[[noreturn]] void become_binnacle(const std::string& folder, const std::vector<std::string>& arguments,
                                  const Start& start, const std::string& out, const std::string& err) {
  std::vector<char*> words;
  for (const auto& word : start.launcher) words.push_back(const_cast<char*>(word.c_str()));
  std::string program = start.program;
  words.push_back(program.data());
  for (const auto& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const int flags = O_CREAT | O_TRUNC | O_WRONLY;
  dup2(open(out.c_str(), flags, 0600), STDOUT_FILENO);
  dup2(open(err.c_str(), flags, 0600), STDERR_FILENO);
  unsetenv("BINNACLE_PLUGIN_PATH");
  for (const auto& [name, value] : start.environment) setenv(name.c_str(), value.c_str(), 1);
  if (chdir(folder.c_str()) == 0) execvp(words.front(), words.data());
  _exit(126);
}

}  // namespace

Command::Command(const Workbench& bench, const std::vector<std::string>& arguments, const Start& start)
    : out_(bench.beside("stdout")), err_(bench.beside("stderr")), child_(fork()) {
  if (child_ == 0) become_binnacle(bench.folder(), arguments, start, out_, err_);
}

Command::~Command() {
  if (has_ended_) return;
  signal(SIGKILL);
  wait();
}

void Command::signal(int number) const { kill(child_, number); }

bool Command::is_running() {
  if (!has_ended_) has_ended_ = wait4(child_, &status_, WNOHANG, &usage_) == child_;
  return !has_ended_;
}

Outcome Command::wait() {
  if (!has_ended_) wait4(child_, &status_, 0, &usage_);
  has_ended_ = true;
  Outcome outcome;
  if (WIFEXITED(status_)) outcome.status = WEXITSTATUS(status_);
  if (WIFSIGNALED(status_)) outcome.signal = WTERMSIG(status_);
  outcome.peak_memory = static_cast<double>(usage_.ru_maxrss) * 1024.0;
  outcome.out = read_file(out_);
  outcome.err = read_file(err_);
  return outcome;
}

Outcome binnacle(const Workbench& bench, const std::vector<std::string>& arguments, const Start& start) {
  return Command(bench, arguments, start).wait();
}

}  // namespace binnacle::test
