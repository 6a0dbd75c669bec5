// SPDX-License-Identifier: Apache-2.0
#include "driver.hpp"

#include <fnmatch.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "child.hpp"
#include "miniature.hpp"

namespace binnacle::conform {

namespace {

namespace fs = std::filesystem;

std::vector<nlohmann::json> lines_of(const std::string& said) {
  std::vector<nlohmann::json> lines;
  std::istringstream in(said);
  for (std::string line; std::getline(in, line);) {
    auto parsed = nlohmann::json::parse(line, nullptr, false);
    if (parsed.is_object()) lines.push_back(std::move(parsed));
  }
  return lines;
}

/// The components of the library, as a process that loads it finds them. `why` when that fails.
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
    if ((kind == "skip" || kind == "not applicable") && outcome.status == Status::pass) {
      outcome.status = Status::skip;
      outcome.applies = kind == "skip";
    }
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

/// "core/vector:life.calls"; the library's own begin with the colon.
bool is_named(const std::string& name, const std::vector<std::string>& globs) {
  return std::any_of(globs.begin(), globs.end(),
                     [&](const std::string& glob) { return ::fnmatch(glob.c_str(), name.c_str(), 0) == 0; });
}

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
      return job.check->level <= options_.level &&
             (options_.filters.empty() || is_named(job.outcome.type + ":" + job.check->id, options_.filters));
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
int Verdict::not_applicable() const {
  return static_cast<int>(std::count_if(outcomes.begin(), outcomes.end(),
                                        [](const Outcome& o) { return o.status == Status::skip && !o.applies; }));
}
int Verdict::skipped() const { return count(Status::skip) - not_applicable(); }
int Verdict::tried() const { return static_cast<int>(outcomes.size()) - count(Status::skip); }
int Verdict::failed() const { return count(Status::fail) + count(Status::crash) + count(Status::timeout); }

std::vector<std::string> Verdict::untried() const {
  std::vector<std::string> names;
  for (const auto& component : components) {
    int ran = 0, apply = 0;
    for (const auto& outcome : outcomes) {
      if (outcome.type != component.type || outcome.role != role_name(component.role)) continue;
      if (!outcome.is_wanted || !outcome.applies || !outcome.check.starts_with("numbers.")) continue;
      // That it repeats itself, and that its R may be one, say nothing of what it computes.
      if (outcome.check == "numbers.measurement.value" || outcome.check == "numbers.measurement.noise") continue;
      ++apply;
      ran += outcome.status != Status::skip;
    }
    if (apply > 0 && ran == 0) names.push_back(component.type);
  }
  return names;
}

bool Verdict::passes(bool warnings_fail) const {
  const bool any_bad = std::any_of(outcomes.begin(), outcomes.end(), [&](const Outcome& o) {
    return is_bad(o.status) || (warnings_fail && o.status == Status::warn);
  });
  const bool any_wanted_ran = std::any_of(outcomes.begin(), outcomes.end(), [](const Outcome& o) {
    return o.is_wanted && (o.status == Status::pass || o.status == Status::warn);
  });
  return enumeration.empty() && !components.empty() && any_wanted_ran && !any_bad && untried().empty();
}

int run_in_process(const Options& options) {
  std::string why;
  const std::vector<Component> components = enumerate(options, why);
  std::vector<std::pair<const Check*, Component>> found;
  std::string names;
  const auto consider = [&](const Check& check, const Component& component) {
    const std::string name = component.type + ":" + check.id;
    if (!is_named(name, options.filters)) return;
    found.emplace_back(&check, component);
    names += "\n  " + name + (component.type.empty() ? "" : std::string("  (") + role_name(component.role) + ")");
  };
  for (const auto& check : all_checks()) {
    if (check.roles.empty()) consider(check, {});
    for (const auto& component : components)
      if (std::find(check.roles.begin(), check.roles.end(), component.role) != check.roles.end())
        consider(check, component);
  }
  if (found.size() != 1)
    throw std::invalid_argument("--in-process runs one check of one component, and --only names " +
                                (found.empty() ? std::string("none") + (why.empty() ? "" : "; the library: " + why)
                                               : std::to_string(found.size()) + ":" + names));
  const auto& [check, component] = found.front();
  char stage[stage_bytes] = {};
  const Wire wire{-1, stage};
  const Scratch scratch;
  const auto report = wire_report(wire);
  Trial trial(options.library, component.type, component.role, std::max(options.level, check->level), options.seed,
              scratch.path(), *report);
  return run_check(*check, trial, wire);
}

Verdict run_checks(const Options& options, const std::function<void(const Outcome&)>& progress) {
  const Interruptible interruptible;
  Verdict verdict;
  verdict.components = enumerate(options, verdict.enumeration);
  verdict.outcomes = Scheduler(options, verdict.components, progress).run();
  return verdict;
}

}  // namespace binnacle::conform
