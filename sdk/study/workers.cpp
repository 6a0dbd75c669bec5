// SPDX-License-Identifier: Apache-2.0
#include "study/workers.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include <unistd.h>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "run_log.hpp"

namespace binnacle::study {

int processors(int processes_here) {
  const int ours = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));  // that we may run on
  const bool is_bound = ours < sysconf(_SC_NPROCESSORS_ONLN);
  return is_bound ? ours : std::max(1, ours / processes_here);
}

void in_parallel(int jobs, std::size_t count, const std::function<void(std::size_t)>& work) {
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(jobs));
  tbb::task_arena arena(jobs);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, work, tbb::simple_partitioner()); });
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
