// SPDX-License-Identifier: Apache-2.0
#include "study/workers.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace binnacle::study {

int processors() { return std::max(1u, std::thread::hardware_concurrency()); }

void carry_out_all(const Study& study, Results& results, int jobs, const std::function<bool()>& goes_on,
                   const OnRun& on_run) {
  struct Item {
    std::size_t variant, run;
  };
  std::vector<Item> open;
  for (std::size_t run = 0; run < results.runs(); ++run)
    for (std::size_t variant = 0; variant < study.variants().size(); ++variant)
      if (results.at(variant, run).state == Figures::State::open) open.push_back({variant, run});

  std::atomic<std::size_t> next{0};
  std::atomic<bool> has_failed{false};
  std::mutex one_at_a_time;
  const std::function<bool()> may_go_on = [&] { return !has_failed && goes_on(); };
  const auto work = [&](int) {
    while (may_go_on()) {
      const std::size_t taken = next++;
      if (taken >= open.size()) return;
      const auto [variant, run] = open[taken];
      Figures figures = study.carry_out(variant, static_cast<int>(run), may_go_on);
      if (figures.state == Figures::State::open) return;
      const std::lock_guard lock(one_at_a_time);
      try {
        on_run(variant, run, figures);
      } catch (...) {
        has_failed = true;
        throw;
      }
      results.at(variant, run) = std::move(figures);
    }
  };
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(jobs));
  tbb::task_arena arena(jobs);
  arena.execute([&] { tbb::parallel_for(0, jobs, work, tbb::simple_partitioner()); });
}

}  // namespace binnacle::study
