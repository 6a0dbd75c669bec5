// SPDX-License-Identifier: Apache-2.0
#include "study/workers.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include <unistd.h>

#include "run_log.hpp"

namespace binnacle::study {

namespace {

/// Threads that help a caller of in_parallel(), joined whatever happens.
class Helpers {
 public:
  Helpers() = default;
  Helpers(const Helpers&) = delete;
  Helpers& operator=(const Helpers&) = delete;
  ~Helpers() {
    for (auto& thread : threads_) thread.join();
  }
  /// False where `most` are at work, or the system gives no more.
  template <class Work>
  bool start(int most, const Work& work) {
    if (!is_taken(most)) return false;
    try {
      threads_.emplace_back([&work] {
        work();
        --at_work;
      });
    } catch (const std::system_error&) {
      --at_work;
      return false;
    }
    return true;
  }

 private:
  /// Of all calls together, so that one inside another adds no threads.
  static inline std::atomic<int> at_work{0};

  static bool is_taken(int most) {
    int now = at_work;
    while (now < most)
      if (at_work.compare_exchange_weak(now, now + 1)) return true;
    return false;
  }

  std::vector<std::thread> threads_;
};

}  // namespace

int processors(int processes_here) {
  const int ours = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));  // that we may run on
  const bool is_bound = ours < sysconf(_SC_NPROCESSORS_ONLN);
  return is_bound ? ours : std::max(1, ours / processes_here);
}

void in_parallel(int jobs, std::size_t count, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto take_part = [&] {
    try {
      for (std::size_t i; (i = next++) < count;) work(i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!thrown) thrown = std::current_exception();
      next = count;
    }
  };
  {
    Helpers helpers;
    for (std::size_t n = 1; n < count && helpers.start(jobs - 1, take_part); ++n) {
    }
    take_part();
  }
  if (thrown) std::rethrow_exception(thrown);
}

void carry_out_runs(const Study& study, int jobs, const std::function<std::optional<Batch>()>& next,
                    const OnBatch& done, const std::function<bool()>& goes_on) {
  const auto is_open = [](const Figures& figures) { return figures.state == Figures::State::open; };
  const auto work = [&](std::size_t) {
    while (goes_on()) {
      const auto batch = next();
      if (!batch) return;
      auto figures = study.carry_out(batch->variants, static_cast<int>(batch->run), goes_on);
      if (std::ranges::any_of(figures, is_open)) return;
      done(*batch, std::move(figures));
    }
  };
  in_parallel(jobs, static_cast<std::size_t>(jobs), work);
}

void carry_out_all(const Study& study, Results& results, int jobs, const std::function<bool()>& goes_on,
                   const OnRun& on_run) {
  RunLog run_log(study, results, on_run, jobs);
  carry_out_runs(
      study, jobs, [&] { return run_log.take(); },
      [&](const Batch& batch, std::vector<Figures>&& figures) { run_log.enter(batch, std::move(figures)); },
      [&] { return !run_log.have_failed() && goes_on(); });
}

}  // namespace binnacle::study
