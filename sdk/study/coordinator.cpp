// SPDX-License-Identifier: Apache-2.0
// Messages are lines of JSON: ["report", {…}] of a rank that has read its study, ["runs", [[[variant, …], run], …]]
// for it to do, ["done", [[variant, run, figures], …]], ["alive"], ["ready"] once all have read it, and ["over"] for it to end.
#include "study/coordinator.hpp"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "figures_json.hpp"
#include "run_log.hpp"
#include "study/section.hpp"

namespace binnacle::study {

namespace {

using Clock = std::chrono::steady_clock;

/// Between looks for messages, longer when there are none: MPI's own waiting takes a processor.
class Pause {
 public:
  std::chrono::milliseconds next() { return std::exchange(next_, std::min(2 * next_, std::chrono::milliseconds(4))); }
  void reset() { next_ = std::chrono::milliseconds(1); }

 private:
  std::chrono::milliseconds next_{1};
};

Json read_message(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  return json.is_array() && !json.empty() && json[0].is_string() ? json : Json::array({"?"});
}

bool is(const Json& message, const char* kind) { return message[0] == kind; }

std::string quoted_place(const std::string& machine, int rank) {
  return "rank " + std::to_string(rank) + (machine.empty() ? "" : " on " + machine);
}

[[noreturn]] void fail(int status, const std::string& place, const std::string& message) {
  Diagnostics diagnostics;
  diagnostics.error("", Origin{place, 0, 0}, "", message);
  throw Error(status, diagnostics);
}

/// Whether this process itself was stopped since the last look, as a batch system does with all: no other is to blame.
bool have_stood_still(Clock::time_point& last_look, const Timeouts& timeouts) {
  const auto now = Clock::now();
  return now - std::exchange(last_look, now) > timeouts.silence / 2;
}

std::string silent_for(const Timeouts& timeouts) {
  return "no message for " + std::to_string(timeouts.silence.count() / 1000) + " s, so it is considered dead";
}

/// How long a rank may still read its study once another has; that one took `loading`. It may be slow; but a plugin's call there
/// may never come back, while signs of life are given all the same.
std::chrono::milliseconds time_to_load(const Timeouts& timeouts, Clock::duration loading) {
  return 10 * (timeouts.silence + std::chrono::duration_cast<std::chrono::milliseconds>(loading));
}

std::string still_loading(std::chrono::milliseconds time) {
  return "it is alive, but is still reading its study, " + std::to_string(time.count() / 1000) +
         " s after this rank had; a plugin's call may not come back";
}

Json makings_of(const Study& study) {
  Json makings = Json::object();
  for (const auto& making : study.makings()) makings[making.what] = making.hash;
  makings["arithmetic"] = arithmetic_hash();
  return makings;
}

/// What of a rank's study is not that of rank 0; "" where all is.
std::string difference(const Json& ours, const Json& theirs) {
  for (const auto& [what, hash] : ours.items()) {
    if (theirs.contains(what) && theirs.at(what) == hash) continue;
    if (what == "arithmetic")
      return "its processor or C library rounds sines and logarithms differently from that of rank 0, so figures would "
             "depend on the rank of a run; use machines of one type";
    return "its " + what + " is another than that of rank 0";
  }
  for (const auto& [what, hash] : theirs.items())
    if (!ours.contains(what)) return "it has a " + what + ", which rank 0 has not";
  return "";
}

/// A thread that is joined whatever happens, and what it threw.
class Thread {
 public:
  template <typename Work>
  explicit Thread(Work work)
      : thread_([this, work] {
          try {
            work();
          } catch (...) {
            thrown_ = std::current_exception();
            has_thrown_ = true;
          }
        }) {}
  ~Thread() {
    if (thread_.joinable()) thread_.join();
  }
  void join() {
    thread_.join();
    if (thrown_) std::rethrow_exception(thrown_);
  }
  /// The work is over, and not well: join() reports why.
  bool has_thrown() const { return has_thrown_; }

 private:
  std::exception_ptr thrown_;
  std::atomic<bool> has_thrown_{false};
  std::thread thread_;
};

/// Set at the end of the scope, whatever happens.
struct Stop {
  std::atomic<bool>& flag;
  ~Stop() { flag = true; }
};

/// What has been handed to a rank, for its threads to take; and what they have made of it, to be sent.
class WorkQueue {
 public:
  void put(Batch batch) {
    {
      const std::lock_guard lock(mutex_);
      in_.push_back(std::move(batch));
    }
    has_work_.notify_one();
  }
  void close() {
    {
      const std::lock_guard lock(mutex_);
      is_closed_ = true;
    }
    has_work_.notify_all();
  }
  /// Waits for a batch; nothing once closed.
  std::optional<Batch> take() {
    std::unique_lock lock(mutex_);
    has_work_.wait(lock, [this] { return is_closed_ || !in_.empty(); });
    if (is_closed_) return std::nullopt;
    Batch batch = std::move(in_.front());
    in_.pop_front();
    return batch;
  }
  void put_out(std::string text) {
    {
      const std::lock_guard lock(mutex_);
      out_.push_back(std::move(text));
    }
    has_results_.notify_one();
  }
  /// Waits for results, no longer than that.
  std::vector<std::string> take_out(std::chrono::milliseconds longest) {
    std::unique_lock lock(mutex_);
    has_results_.wait_for(lock, longest, [this] { return !out_.empty(); });
    return std::exchange(out_, {});
  }
  bool is_closed() const { return is_closed_; }

 private:
  std::mutex mutex_;
  std::condition_variable has_work_, has_results_;
  std::deque<Batch> in_;
  std::vector<std::string> out_;
  std::atomic<bool> is_closed_{false};
};

}  // namespace

std::uint64_t arithmetic_hash() {
  std::uint64_t hash = 14695981039346656037u;
  const auto add = [&hash](double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    hash = (hash ^ bits) * 1099511628211u;
  };
  volatile double argument = 0.01;  // that nothing is worked out by the compiler
  for (int i = 0; i < 1000; ++i) {
    argument = argument + 0.0137 * i;
    const double x = argument;
    for (const double value : {std::sin(x), std::cos(x), std::tan(x), std::atan2(x, 1.3), std::asin(1 / (1 + x)),
                               std::exp(-0.01 * x), std::log(x), std::pow(x, 0.7)})
      add(value);
  }
  return hash;
}

// ---- rank 0

Coordinator::Coordinator(Team& team, Timeouts timeouts)
    : team_(team), timeouts_(timeouts), ranks_(static_cast<std::size_t>(team.size())) {
  for (Rank& rank : ranks_) rank.last_message = Clock::now();
}

Coordinator::~Coordinator() { dismiss(); }

std::string Coordinator::name_of(int rank) const {
  return quoted_place(ranks_[static_cast<std::size_t>(rank)].machine, rank);
}

Study Coordinator::load(const std::function<Study()>& load) {
  const auto begin = Clock::now();
  std::optional<Study> study;
  std::atomic<bool> is_over{false};
  Thread loading([&] {
    const Stop over{is_over};
    study = load();
  });
  for (Pause pause; !is_over; std::this_thread::sleep_for(pause.next())) {
    give_sign_of_life();
    while (auto message = team_.receive()) {
      ranks_[static_cast<std::size_t>(message->from)].last_message = Clock::now();
      early_.push_back(std::move(*message));
    }
  }
  loading.join();
  loaded_ = Clock::now();
  loading_ = loaded_ - begin;
  return std::move(*study);
}

void Coordinator::give_sign_of_life() {
  const auto now = Clock::now();
  if (now - last_sign_ < timeouts_.sign_of_life) return;
  last_sign_ = now;
  for (int rank = 1; rank < team_.size(); ++rank) team_.send(rank, line_of(Json::array({"alive"})));
}

void Coordinator::take_report(const Study& study, int rank, const std::string& text) {
  const Json message = read_message(text);
  Rank& entry = ranks_[static_cast<std::size_t>(rank)];
  entry.last_message = Clock::now();
  if (!is(message, "report")) return;
  const Json& report = message[1];
  entry.has_reported = true;
  entry.machine = report.at("machine").get<std::string>();
  entry.jobs = report.at("jobs").get<int>();
  entry.status = report.at("status").get<int>();
  entry.trouble = report.at("trouble").get<std::string>();
  if (!entry.trouble.empty()) return;
  entry.trouble = difference(makings_of(study), report.at("makings"));
  entry.status = 2;
}

void Coordinator::refuse_troubled() {
  int first = 0, others = 0;
  for (int rank = 1; rank < team_.size(); ++rank) {
    const Rank& entry = ranks_[static_cast<std::size_t>(rank)];
    if (entry.trouble.empty()) continue;
    if (first == 0)
      first = rank;
    else
      ++others;
  }
  if (first == 0) return;
  const Rank& entry = ranks_[static_cast<std::size_t>(first)];
  fail(entry.status, name_of(first),
       entry.trouble + (others ? " (and " + std::to_string(others) + " more of the ranks cannot serve)" : ""));
}

bool Coordinator::assemble(const Study& study, const std::function<bool()>& goes_on) {
  for (const Message& message : std::exchange(early_, {})) take_report(study, message.from, message.text);
  const auto have_all_reported = [this] {
    return std::all_of(ranks_.begin() + 1, ranks_.end(), [](const Rank& rank) { return rank.has_reported; });
  };
  for (Pause pause; !have_all_reported();) {
    if (!goes_on()) return false;
    give_sign_of_life();
    if (const auto message = team_.receive()) {
      take_report(study, message->from, message->text);
      continue;
    }
    look_for_silent();
    look_for_late();
    std::this_thread::sleep_for(pause.next());
  }
  refuse_troubled();
  for (int rank = 1; rank < team_.size(); ++rank) team_.send(rank, line_of(Json::array({"ready"})));
  return true;
}

void Coordinator::look_for_late() {
  const auto longest = time_to_load(timeouts_, loading_);
  if (Clock::now() - loaded_ < longest) return;
  for (int rank = 1; rank < team_.size(); ++rank) {
    const Rank& entry = ranks_[static_cast<std::size_t>(rank)];
    const bool is_alive = Clock::now() - entry.last_message <= 2 * timeouts_.sign_of_life;
    if (entry.has_reported || !is_alive) continue;  // look_for_silent() has the others
    is_over_ = true;                                // it would not learn that it is
    fail(1, name_of(rank), still_loading(longest));
  }
}

int Coordinator::threads() const {
  int threads = 0;
  for (const auto& rank : ranks_) threads += rank.jobs;
  return threads;
}

void Coordinator::look_for_silent() {
  const bool has_stood_still = have_stood_still(last_look_, timeouts_);
  for (int rank = 1; rank < team_.size(); ++rank) {
    Rank& entry = ranks_[static_cast<std::size_t>(rank)];
    if (has_stood_still) entry.last_message = loaded_ = last_look_;
    if (last_look_ - entry.last_message < timeouts_.silence) continue;
    is_over_ = true;  // there is nobody to wait for
    fail(1, name_of(rank),
         silent_for(timeouts_) +
             (entry.has_reported ? "; its runs are still to be done" : "; it has not read its study"));
  }
}

void Coordinator::carry_out_all(const Study& study, Results& results, int jobs, const std::function<bool()>& goes_on,
                                const OnRun& on_run) {
  const int all_threads = jobs + threads();
  RunLog run_log(study, results, on_run, all_threads);
  std::atomic<bool> is_stopped{false};
  const std::function<bool()> may_go_on = [&] { return !is_stopped && !run_log.have_failed() && goes_on(); };

  // Another one for each thread while it is at work; near the end none waits behind another.
  const auto hand_out = [&](int rank) {
    Rank& entry = ranks_[static_cast<std::size_t>(rank)];
    const auto each = run_log.left() > 2 * static_cast<std::size_t>(all_threads) ? 2u : 1u;
    Json runs = Json::array();
    while (entry.given < each * static_cast<std::size_t>(entry.jobs)) {
      const auto batch = run_log.take();
      if (!batch) break;
      runs.push_back(Json::array({batch->variants, batch->run}));
      ++entry.given;
    }
    if (!runs.empty()) team_.send(rank, line_of(Json::array({"runs", std::move(runs)})));
  };
  const auto take_in = [&](const Message& message) {
    Rank& entry = ranks_[static_cast<std::size_t>(message.from)];
    entry.last_message = Clock::now();
    const Json json = read_message(message.text);
    if (!is(json, "done")) return;
    for (const Json& each : json[1]) {
      auto done = read_entry(each, study.metrics().size());
      if (!done) fail(1, name_of(message.from), "it sent what is no result of a run");
      run_log.enter(done->first, std::move(done->second));
    }
    --entry.given;
    hand_out(message.from);
  };

  Thread own([&] {
    carry_out_runs(
        study, jobs, [&] { return run_log.take(); },
        [&](const Batch& batch, std::vector<Figures>&& figures) { run_log.enter(batch, std::move(figures)); },
        may_go_on);
  });
  {
    const Stop stop{is_stopped};
    for (int rank = 1; rank < team_.size(); ++rank) {
      ranks_[static_cast<std::size_t>(rank)].last_message = Clock::now();
      hand_out(rank);
    }
    Pause pause;
    while (!run_log.are_complete() && !own.has_thrown() && may_go_on()) {
      if (const auto message = team_.receive()) {
        pause.reset();
        take_in(*message);
        continue;
      }
      give_sign_of_life();
      look_for_silent();
      std::this_thread::sleep_for(pause.next());
    }
  }
  own.join();
}

bool Coordinator::dismiss() {
  if (is_over_) return true;
  is_over_ = true;
  for (int rank = 1; rank < team_.size(); ++rank) team_.send(rank, line_of(Json::array({"over"})));
  return team_.leave(timeouts_.silence);
}

// ---- the others

namespace {

/// Of a rank that has read its study, or could not.
Json report_of(const Team& team, int jobs, const std::function<Study()>& load, std::optional<Study>& study) {
  Json report{{"machine", team.machine()}, {"jobs", jobs}, {"status", 0}, {"trouble", ""}};
  try {
    study = load();
    report["makings"] = makings_of(*study);
  } catch (const Error& error) {
    report["status"] = error.exit_status();
    const auto items = error.diagnostics().sorted();
    report["trouble"] = "it cannot read the study: " + (items.empty() ? error.what() : to_string(items.front()));
  } catch (const std::exception& error) {
    report["status"] = 1;
    report["trouble"] = std::string("it cannot read the study: ") + error.what();
  }
  return report;
}

/// What goes on between a rank and rank 0 while threads of the rank are at work.
class Correspondence {
 public:
  Correspondence(Team& team, WorkQueue& work_queue, Timeouts timeouts)
      : team_(team), work_queue_(work_queue), timeouts_(timeouts) {}

  /// Takes in what has come and sends what is finished, then waits a little. Throws where rank 0 is silent for too long.
  void go_on() {
    while (const auto message = team_.receive()) take_in(read_message(message->text));
    if (have_stood_still(last_look_, timeouts_)) {
      heard_ = last_look_;
      if (loaded_ != not_yet) loaded_ = last_look_;
    }
    if (!is_dismissed_ && last_look_ - heard_ >= timeouts_.silence) fail(1, "rank 0", silent_for(timeouts_));
    look_for_late();
    for (auto& text : work_queue_.take_out(pause_.next())) {
      if (loaded_ == not_yet) {  // what is sent first is that this has read its study
        loaded_ = Clock::now();
        loading_ = loaded_ - begin_;
      }
      team_.send(0, std::move(text));
    }
    if (Clock::now() - reported_ < timeouts_.sign_of_life) return;
    team_.send(0, line_of(Json::array({"alive"})));
    reported_ = Clock::now();
  }
  bool is_dismissed() const { return is_dismissed_; }

 private:
  void take_in(const Json& message) {
    pause_.reset();
    heard_ = Clock::now();
    is_ready_ = is_ready_ || is(message, "ready") || is(message, "runs");
    is_dismissed_ = is_dismissed_ || is(message, "over");
    if (!is(message, "runs")) return;
    for (const auto& batch : message[1])
      work_queue_.put({batch[0].get<std::vector<std::size_t>>(), batch[1].get<std::size_t>()});
  }

  /// Rank 0 waits for ranks that are late, and says so first; this is for rank 0 itself.
  void look_for_late() {
    if (is_ready_ || is_dismissed_ || loaded_ == not_yet) return;
    const auto longest = 2 * time_to_load(timeouts_, loading_);
    const bool is_alive = last_look_ - heard_ <= 2 * timeouts_.sign_of_life;
    if (is_alive && last_look_ - loaded_ > longest) fail(1, "rank 0", still_loading(longest));
  }

  static constexpr Clock::time_point not_yet{};

  Team& team_;
  WorkQueue& work_queue_;
  Timeouts timeouts_;
  Pause pause_;
  bool is_ready_ = false;  // all have read their study
  Clock::duration loading_{0};
  Clock::time_point begin_ = Clock::now(), loaded_ = not_yet;
  Clock::time_point heard_ = Clock::now(), last_look_ = Clock::now(), reported_ = Clock::now();
  bool is_dismissed_ = false;
};

/// At the end of the scope, whatever happens, so that the threads come to theirs.
struct Close {
  WorkQueue& work_queue;
  ~Close() { work_queue.close(); }
};

}  // namespace

bool serve(Team& team, const std::function<Study()>& load, int jobs, const std::function<bool()>& goes_on,
           Timeouts timeouts) {
  WorkQueue work_queue;
  std::atomic<bool> is_stopped{false};
  const std::function<bool()> may_go_on = [&] { return !is_stopped && goes_on(); };
  Thread work([&] {
    std::optional<Study> study;
    work_queue.put_out(line_of(Json::array({"report", report_of(team, jobs, load, study)})));
    if (!study) return;
    carry_out_runs(
        *study, jobs, [&] { return work_queue.take(); },
        [&](const Batch& batch, std::vector<Figures>&& figures) {
          Json entries = Json::array();
          for (std::size_t i = 0; i < figures.size(); ++i)
            entries.push_back(entry_of({batch.variants[i], batch.run}, figures[i]));
          work_queue.put_out(line_of(Json::array({"done", std::move(entries)})));
        },
        may_go_on);
  });
  Correspondence correspondence(team, work_queue, timeouts);
  {
    const Close close{work_queue};
    const Stop stop{is_stopped};
    while (!correspondence.is_dismissed() && !work.has_thrown() && goes_on()) correspondence.go_on();
  }
  work.join();
  if (correspondence.is_dismissed() && !team.leave(timeouts.silence))
    fail(1, "a rank",
         "did not end within " + std::to_string(timeouts.silence.count() / 1000) +
             " s, it or its machine may be stopped");
  return correspondence.is_dismissed();
}

}  // namespace binnacle::study
