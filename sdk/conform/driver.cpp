// SPDX-License-Identifier: Apache-2.0
#include "driver.hpp"

#include <fcntl.h>
#include <fnmatch.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <map>
#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "miniature.hpp"
#include "run_check.hpp"

namespace binnacle::conform {

namespace {

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// A child process that talks on a pipe and may be stopped.
class Child {
 public:
  Child(const std::function<int(const Wire&)>& work, double time_limit) : limit_(time_limit), start_(Clock::now()) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe is to be had");
    void* shared = ::mmap(nullptr, stage_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) throw std::runtime_error("no shared memory is to be had");
    stage_ = static_cast<char*>(shared);
    const pid_t driver = ::getpid();
    pid_ = ::fork();
    if (pid_ < 0) throw std::runtime_error("no process is to be had");
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
  Child(const Child&) = delete;
  ~Child() {
    if (!is_over_) stop();
    ::close(pipe_);
    ::munmap(stage_, stage_bytes);
  }

  /// Takes in what it said; true once it is over.
  bool poll() {
    drain();
    int status = 0;
    if (!is_over_ && ::waitpid(pid_, &status, WNOHANG) == pid_) end(status);
    if (!is_over_ && seconds_since(start_) > limit_) {
      timed_out_ = true;
      stop();
    }
    return is_over_;
  }
  /// −1, which poll() passes over, once nobody can say anything more.
  int pipe() const { return is_silent_ ? -1 : pipe_; }
  const std::string& said() const { return said_; }
  bool timed_out() const { return timed_out_; }
  int status() const { return status_; }
  double seconds() const { return seconds_; }
  std::string stage() const { return std::string(stage_, strnlen(stage_, stage_bytes)); }

 private:
  void drain() {
    char buffer[4096];
    ssize_t count = 0;
    while ((count = ::read(pipe_, buffer, sizeof buffer)) > 0) said_.append(buffer, static_cast<std::size_t>(count));
    if (count == 0) is_silent_ = true;
  }
  void stop() {
    ::kill(-pid_, SIGKILL);
    ::kill(pid_, SIGKILL);
    int status = 0;
    ::waitpid(pid_, &status, 0);
    end(status);
  }
  void end(int status) {
    status_ = status;
    is_over_ = true;
    seconds_ = seconds_since(start_);
    ::kill(-pid_, SIGKILL);  // whatever it started goes with it
    drain();
  }

  pid_t pid_ = -1;
  int pipe_ = -1, status_ = 0;
  char* stage_ = nullptr;
  double limit_ = 0, seconds_ = 0;
  Clock::time_point start_;
  std::string said_;
  bool is_over_ = false, timed_out_ = false, is_silent_ = false;
};

std::string signal_name(int signal) {
  const char* name = sigabbrev_np(signal);
  return name ? std::string("SIG") + name : "signal " + std::to_string(signal);
}

volatile std::sig_atomic_t interrupted = 0;
void interrupt(int) { interrupted = 1; }

/// Ctrl-C ends the run as an exception does: children are stopped, their folders go.
class Interruptible {
 public:
  Interruptible() {
    for (const int signal : {SIGINT, SIGTERM}) ::signal(signal, interrupt);
  }
  ~Interruptible() {
    for (const int signal : {SIGINT, SIGTERM}) ::signal(signal, SIG_DFL);
  }
  static void check() {
    if (interrupted) throw std::runtime_error("interrupted");
  }
};

/// A folder of its own, gone at the end.
class Scratch {
 public:
  Scratch() {
    std::string pattern = (fs::temp_directory_path() / "binnacle-conform-XXXXXX").string();
    if (!::mkdtemp(pattern.data()))
      throw std::runtime_error("no temporary folder is to be had in " + fs::temp_directory_path().string());
    path_ = pattern;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::vector<nlohmann::json> lines_of(const std::string& said) {
  std::vector<nlohmann::json> lines;
  std::istringstream in(said);
  for (std::string line; std::getline(in, line);) {
    auto parsed = nlohmann::json::parse(line, nullptr, false);
    if (parsed.is_object()) lines.push_back(std::move(parsed));
  }
  return lines;
}

/// The components of the library, told by a process that loads it. `why` when that fails.
std::vector<Component> enumerate(const Options& options, std::string& why) {
  const auto work = [&](const Wire& wire) {
    Catalog catalog;
    Diagnostics diagnostics;
    catalog.load(options.library, diagnostics);
    std::string text;
    for (const auto* type : catalog.types())
      text += nlohmann::json({{"role", static_cast<int>(type->role)}, {"type", type->full_name()}}).dump() + "\n";
    text += "{\"end\": true}\n";
    return ::write(wire.pipe, text.data(), text.size()) == static_cast<ssize_t>(text.size()) ? 0 : 1;
  };
  Child child(work, options.time_limit);
  while (!child.poll()) {
    Interruptible::check();
    ::usleep(1000);
  }
  std::vector<Component> components;
  bool is_whole = false;
  for (const auto& line : lines_of(child.said())) {
    if (line.contains("end"))
      is_whole = true;
    else
      components.push_back({static_cast<Role>(line.at("role").get<int>()), line.at("type").get<std::string>()});
  }
  if (!is_whole) {
    why = child.timed_out()             ? "loading it never ends"
          : WIFSIGNALED(child.status()) ? "loading it ends in " + signal_name(WTERMSIG(child.status()))
                                        : "it cannot be loaded";
  }
  return components;
}

Outcome conclude(const Child& child, Outcome outcome, double time_limit) {
  outcome.seconds = child.seconds();
  bool is_done = false;
  std::vector<std::string> messages;
  for (const auto& line : lines_of(child.said())) {
    const std::string kind = line.at("kind");
    if (kind == "done") {
      is_done = true;
      continue;
    }
    messages.push_back(line.at("message"));
    if (kind == "fail") outcome.status = Status::fail;
    if (kind == "warn" && outcome.status == Status::pass) outcome.status = Status::warn;
    if (kind == "skip" && outcome.status == Status::pass) outcome.status = Status::skip;
  }
  const std::string during = child.stage().empty() ? "" : " in " + child.stage() + "()";
  if (child.timed_out()) {
    outcome.status = Status::timeout;
    std::ostringstream text;
    text << "not over after " << time_limit << " s" << during;
    messages.push_back(text.str());
  } else if (WIFSIGNALED(child.status())) {
    outcome.status = Status::crash;
    messages.push_back("ends in " + signal_name(WTERMSIG(child.status())) + during);
  } else if (is_done && outcome.status != Status::fail && WEXITSTATUS(child.status()) != 0) {
    outcome.status = Status::fail;
    messages.push_back("the process ends with status " + std::to_string(WEXITSTATUS(child.status())) +
                       " after the check: a sanitizer found something, or an assertion failed");
  } else if (!is_done) {
    outcome.status = Status::crash;
    messages.push_back("the process ends with status " + std::to_string(WEXITSTATUS(child.status())) + during +
                       " before the check is over");
  }
  constexpr std::size_t most = 8;
  for (std::size_t i = 0; i < std::min(messages.size(), most); ++i) outcome.message += (i ? "\n" : "") + messages[i];
  if (messages.size() > most) outcome.message += "\nand " + std::to_string(messages.size() - most) + " more";
  return outcome;
}

bool is_bad(Status status) { return status == Status::fail || status == Status::crash || status == Status::timeout; }

/// One check of one component, from waiting to over.
struct Job {
  const Check* check = nullptr;
  const Component* component = nullptr;  // null: the library
  Outcome outcome;
  bool is_wanted = false;  // itself, not only for what needs it
  bool is_over = false;
  bool is_blocked = false;  // over, and what needs it is skipped
  std::string why_blocked;
};

class Scheduler {
 public:
  Scheduler(const Options& options, const std::vector<Component>& components,
            const std::function<void(const Outcome&)>& progress)
      : options_(options), progress_(progress) {
    const auto add = [&](const Check& check, const Component* component) {
      Job job;
      job.check = &check;
      job.component = component;
      job.outcome.check = check.id;
      if (component) job.outcome.type = component->type, job.outcome.role = role_name(component->role);
      jobs_.push_back(std::move(job));
    };
    for (const auto& check : all_checks())
      if (check.roles.empty()) add(check, nullptr);
    for (const auto& component : components)
      for (const auto& check : all_checks())
        if (std::find(check.roles.begin(), check.roles.end(), component.role) != check.roles.end())
          add(check, &component);
    drop_unwanted();
  }

  std::vector<Outcome> run() {
    std::vector<std::pair<Job*, std::unique_ptr<Running>>> running;
    while (true) {
      for (auto& job : jobs_) {
        if (static_cast<int>(running.size()) >= options_.jobs) break;
        if (job.is_over || is_running(running, job) || !is_ready(job)) continue;
        if (job.is_over) continue;  // is_ready() found that it must be skipped
        running.emplace_back(&job, std::make_unique<Running>(*this, job));
      }
      if (running.empty() && std::all_of(jobs_.begin(), jobs_.end(), [](const Job& job) { return job.is_over; })) break;
      wait(running);
      Interruptible::check();
      for (auto it = running.begin(); it != running.end();) {
        if (!it->second->child.poll()) {
          ++it;
          continue;
        }
        finish(*it->first, conclude(it->second->child, it->first->outcome, options_.time_limit));
        it = running.erase(it);
      }
    }
    std::vector<Outcome> outcomes;
    for (auto& job : jobs_) {
      job.outcome.is_wanted = job.is_wanted;
      outcomes.push_back(std::move(job.outcome));
    }
    return outcomes;
  }

 private:
  struct Running {
    Running(const Scheduler& scheduler, const Job& job)
        : child([&](const Wire& wire) { return scheduler.work(job, scratch.path(), wire); },
                scheduler.options_.time_limit) {}
    Scratch scratch;
    Child child;
  };
  using RunningJobs = std::vector<std::pair<Job*, std::unique_ptr<Running>>>;

  static bool is_running(const RunningJobs& running, const Job& job) {
    return std::any_of(running.begin(), running.end(), [&](const auto& entry) { return entry.first == &job; });
  }

  /// By level and filters; what a wanted check needs runs as well.
  void drop_unwanted() {
    std::set<std::string> wanted;
    const auto matches = [&](const Job& job) {
      if (job.check->level > options_.level) return false;
      if (options_.filters.empty()) return true;
      const std::string name = job.outcome.type + ":" + job.check->id;
      return std::any_of(options_.filters.begin(), options_.filters.end(),
                         [&](const std::string& glob) { return ::fnmatch(glob.c_str(), name.c_str(), 0) == 0; });
    };
    std::function<void(const Job&)> want = [&](const Job& job) {
      if (!wanted.insert(job.outcome.role + ":" + job.outcome.type + ":" + job.check->id).second) return;
      for (const auto& need : job.check->needs)
        for (const auto& other : jobs_)
          if (other.check->id == need && (other.component == job.component || !other.component)) want(other);
    };
    for (auto& job : jobs_)
      if (matches(job)) {
        job.is_wanted = true;
        want(job);
      }
    std::erase_if(jobs_, [&](const Job& job) {
      return !wanted.contains(job.outcome.role + ":" + job.outcome.type + ":" + job.check->id);
    });
  }

  /// Whether its prerequisites are over. One that failed ends it as skipped.
  bool is_ready(Job& job) {
    for (const auto& need : job.check->needs)
      for (const auto& other : jobs_) {
        if (other.check->id != need || (other.component && other.component != job.component)) continue;
        if (!other.is_over) return false;
        if (!other.is_blocked) continue;
        job.outcome.status = Status::skip;
        job.outcome.message = "prerequisite " + other.why_blocked + " failed";
        job.is_blocked = true;
        job.why_blocked = other.why_blocked;
        job.is_over = true;
        progress_(job.outcome);
        return true;
      }
    return true;
  }

  void finish(Job& job, Outcome outcome) {
    job.outcome = std::move(outcome);
    job.is_over = true;
    job.is_blocked = is_bad(job.outcome.status);
    job.why_blocked = job.check->id;
    progress_(job.outcome);
  }

  int work(const Job& job, const fs::path& scratch, const Wire& wire) const {
    const auto report = wire_report(wire);
    Trial trial(options_.library, job.component ? job.component->type : "",
                job.component ? job.component->role : Role::state_block, options_.level, options_.seed, scratch,
                *report);
    return run_check(*job.check, trial, wire);
  }

  static void wait(const RunningJobs& running) {
    std::vector<pollfd> ends;
    for (const auto& entry : running) ends.push_back({entry.second->child.pipe(), POLLIN, 0});
    ::poll(ends.data(), ends.size(), 20);
  }

  const Options& options_;
  const std::function<void(const Outcome&)>& progress_;
  std::vector<Job> jobs_;
};

}  // namespace

int Verdict::count(Status status) const {
  return static_cast<int>(
      std::count_if(outcomes.begin(), outcomes.end(), [&](const Outcome& o) { return o.status == status; }));
}

bool Verdict::passes(bool warnings_fail) const {
  const bool any_bad = std::any_of(outcomes.begin(), outcomes.end(), [&](const Outcome& o) {
    return is_bad(o.status) || (warnings_fail && o.status == Status::warn);
  });
  const bool any_wanted_ran = std::any_of(outcomes.begin(), outcomes.end(), [](const Outcome& o) {
    return o.is_wanted && (o.status == Status::pass || o.status == Status::warn);
  });
  return enumeration.empty() && !components.empty() && any_wanted_ran && !any_bad;
}

Verdict run_checks(const Options& options, const std::function<void(const Outcome&)>& progress) {
  const Interruptible interruptible;
  Verdict verdict;
  verdict.components = enumerate(options, verdict.enumeration);
  verdict.outcomes = Scheduler(options, verdict.components, progress).run();
  return verdict;
}

}  // namespace binnacle::conform
