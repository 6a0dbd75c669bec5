// SPDX-License-Identifier: Apache-2.0
// observe: what the measurements of a run say about the state, and what they do not.
#include <deque>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "interrupt.hpp"
#include "observability_text.hpp"
#include "observe/observe.hpp"
#include "output.hpp"
#include "provenance.hpp"
#include "run_recorder.hpp"
#include "score/run.hpp"
#include "sentinel.hpp"
#include "step_observers.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct ObserveVerbOptions {
  std::string config_path;
  ConfigOptions config;
  std::vector<std::string> windows;
  std::string out;
  std::uint64_t seed = 1;
  int run = 0;
  bool json = false, quiet = false;
};

class Watch final : public score::RunObserver {
 public:
  Watch(const observe::Observability& observability, RunRecorder* recorder)
      : observability_(observability), recorder_(recorder) {}

  bool wants_records() const override { return recorder_ != nullptr; }
  void begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns) override {
    recorder_->begin(filter, name, columns);
  }
  void record(int filter, Time t, std::span<const double> values) override { recorder_->record(filter, t, values); }
  void scored(int filter, const score::ErrorSeries& errors) override { recorder_->scored(filter, errors); }
  StepObserver* step_observer(int filter) override {
    StepObservers& both = both_.emplace_back();
    both.add(observability_.step_observer(filter));
    if (recorder_) both.add(recorder_->step_observer(filter));
    return both.joined();
  }
  bool progress(Time) override { return interrupted_by() == 0; }

 private:
  const observe::Observability& observability_;
  RunRecorder* recorder_;
  std::deque<StepObservers> both_;
};

Json provenance_of(const ObserveVerbOptions& options, const Composition& composition) {
  std::string windows;
  for (const auto& window : options.windows) windows += " --window " + shell_quoted(window);
  Json all = provenance(composition.catalog(),
                        fmt::format("binnacle observe {}{}{} --seed {} --run {}", shell_quoted(options.config_path),
                                    options.config.as_typed(), windows, options.seed, options.run));
  all["seed"] = options.seed;
  all["run"] = options.run;
  all["created"] = now_in_words();
  return all;
}

std::vector<observe::Window> windows_of(const ObserveVerbOptions& options, const Composition& composition) {
  if (options.windows.empty()) return {observe::whole_run()};
  std::vector<observe::Window> windows;
  for (const auto& text : options.windows) {
    const auto window = observe::read_window(composition, text);
    if (!window) throw UsageError("--window: " + window.error());
    windows.push_back(*window);
  }
  return windows;
}

[[noreturn]] void give_up(std::unique_ptr<RunRecorder>& recorder) {
  recorder.reset();
  print_error("interrupted; nothing was written");
  die_of_signal();
  throw UsageError("interrupted");
}

void leave_in_folder(RunRecorder& recorder, Json summary, const Json& filters, const Composition& composition) {
  for (const auto& [name, windows] : filters.items()) summary["filters"][name]["observability"] = windows;
  recorder.commit(summary, Json::parse(composition.config()));
}

int observe_config(const ObserveVerbOptions& options) {
  watch_signals("nothing was written");
  const LoadOptions load_options = options.config.load_options(options.config_path);
  const auto composition = score::load(options.config_path, load_options);
  watch_exit();  // again, now that the plugins are loaded
  const observe::Observability observability(*composition, windows_of(options, *composition));
  std::unique_ptr<RunRecorder> recorder;
  if (!options.out.empty())
    recorder = std::make_unique<RunRecorder>(options.out, *composition, provenance_of(options, *composition));
  Watch watch(observability, recorder.get());
  score::RunOptions run_options;
  run_options.seed = options.seed;
  run_options.run = options.run;
  run_options.observer = &watch;
  run_options.feeds_sinks = false;
  score::RunResult result = score::run(composition, run_options);
  if (interrupted_by() != 0) give_up(recorder);
  const observe::RunKey key{options.seed, options.run, [] { return interrupted_by() == 0; }};
  const Json filters = observability.figures(options.config_path, load_options, key);
  stand_down();
  if (interrupted_by() != 0) give_up(recorder);
  if (recorder) leave_in_folder(*recorder, std::move(result.summary), filters, *composition);
  if (!options.quiet) print_abridged(result.warnings, "binnacle run has all");
  if (options.json)
    print_json({{"filters", filters}});
  else if (!options.quiet)
    print(heading(composition->title()) + observability_text(filters));
  print_diagnostics(result.failures);
  return result.failures.empty() ? ok : failed;
}

}  // namespace

Verb observe_verb(CLI::App& command) {
  const auto options = std::make_shared<ObserveVerbOptions>();
  CLI::App* app = add_verb(command, "observe");
  app->add_option("CONFIG", options->config_path, "The config")->required();
  options->config.add_to(*app);
  options->config.add_variant_to(*app);
  app->add_option("--window", options->windows,
                  "A time span in seconds of the data, or a window of evaluate, instead of the whole run")
      ->type_name("FROM:TO|NAME")
      ->allow_extra_args(false);
  app->add_option("--out", options->out, "Record the run as 'run' does, with these results on the page")
      ->type_name("DIR");
  app->add_option("--seed", options->seed, "Seed of all random numbers")->type_name("N")->capture_default_str();
  app->add_option("--run", options->run, "Number of the run with this seed")
      ->type_name("K")
      ->check(CLI::Range(0, 1'000'000'000))
      ->capture_default_str();
  app->add_flag("--json", options->json, "Print the figures as JSON on stdout");
  app->add_flag("--quiet", options->quiet, "Print only errors: no warnings or tables");
  return {app, [options] { return observe_config(*options); }};
}

}  // namespace binnacle::command
