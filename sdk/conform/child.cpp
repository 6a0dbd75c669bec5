// SPDX-License-Identifier: Apache-2.0
#include "child.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>

namespace binnacle::conform {

namespace {

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

volatile std::sig_atomic_t interrupted = 0;
void interrupt(int) { interrupted = 1; }

}  // namespace

Child::Child(const std::function<int(const Wire&)>& work, double time_limit)
    : limit_(time_limit), start_(Clock::now()) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe is available");
  void* shared = ::mmap(nullptr, stage_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) throw std::runtime_error("no shared memory is available");
  stage_ = static_cast<char*>(shared);
  const pid_t driver = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("no process is available");
  if (pid_ == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // a driver that is killed leaves no endless loop behind
    if (::getppid() != driver) ::_exit(70);
    for (const int signal : {SIGINT, SIGTERM}) ::signal(signal, SIG_DFL);
    ::close(ends[0]);
    const int null = ::open("/dev/null", O_RDWR);
    for (const int stream : {0, 1, 2}) ::dup2(null, stream);
    try {
      ::_exit(work(Wire{ends[1], stage_}));
    } catch (...) {
      ::_exit(70);  // what the driver made is not the child's to unmake
    }
  }
  ::close(ends[1]);
  pipe_ = ends[0];
  ::fcntl(pipe_, F_SETFL, O_NONBLOCK);
}

Child::~Child() {
  if (!is_over_) stop();
  ::close(pipe_);
  ::munmap(stage_, stage_bytes);
}

bool Child::poll() {
  drain();
  int status = 0;
  if (!is_over_ && ::waitpid(pid_, &status, WNOHANG) == pid_) end(status);
  if (!is_over_ && seconds_since(start_) > limit_) {
    timed_out_ = true;
    stop();
  }
  return is_over_;
}

void Child::drain() {
  char buffer[4096];
  ssize_t count = 0;
  while ((count = ::read(pipe_, buffer, sizeof buffer)) > 0) said_.append(buffer, static_cast<std::size_t>(count));
  if (count == 0) is_silent_ = true;
}

void Child::stop() {
  ::kill(-pid_, SIGKILL);
  ::kill(pid_, SIGKILL);
  int status = 0;
  ::waitpid(pid_, &status, 0);
  end(status);
}

void Child::end(int status) {
  status_ = status;
  is_over_ = true;
  seconds_ = seconds_since(start_);
  ::kill(-pid_, SIGKILL);  // whatever it started goes with it
  drain();
}

std::string signal_name(int signal) {
  const char* name = sigabbrev_np(signal);
  return name ? std::string("SIG") + name : "signal " + std::to_string(signal);
}

Interruptible::Interruptible() {
  for (const int signal : {SIGINT, SIGTERM}) ::signal(signal, interrupt);
}
Interruptible::~Interruptible() {
  for (const int signal : {SIGINT, SIGTERM}) ::signal(signal, SIG_DFL);
}
void Interruptible::check() {
  if (interrupted) throw std::runtime_error("interrupted");
}

Scratch::Scratch() {
  const auto folder = std::filesystem::temp_directory_path();
  std::string pattern = (folder / "binnacle-conform-XXXXXX").string();
  if (!::mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder is available in " + folder.string());
  path_ = pattern;
}
Scratch::~Scratch() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace binnacle::conform
