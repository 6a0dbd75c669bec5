// SPDX-License-Identifier: Apache-2.0
// run: a config from the first sample to the last, with progress, records, and a summary.
#include "score/run.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "checkpoint_files.hpp"
#include "input_record.hpp"
#include "interrupt.hpp"
#include "live/run_page.hpp"
#include "output.hpp"
#include "provenance.hpp"
#include "record_journal.hpp"
#include "record_options.hpp"
#include "run_recorder.hpp"
#include "sentinel.hpp"
#include "smoothers.hpp"
#include "study/variants.hpp"
#include "summary_text.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct RunVerbOptions {
  std::string config_path;
  ConfigOptions config;
  std::string summary;
  std::string out;
  RecordOptions records;
  RecordFormats formats;
  std::string record_input, input;
  std::optional<std::string> page;
  score::RunOptions run;
  CheckpointFiles checkpoints;
  bool json = false;
  bool quiet = false;
  bool strict = false;
  bool smooth = false;
};

/// Nothing is finished any more, so that no sink leaves a file.
struct Interrupted {};

/// One line on a terminal, rewritten: how far the data are, and how fast they go by.
class ProgressLine {
 public:
  explicit ProgressLine(bool is_shown) : is_shown_(is_shown) {}
  ~ProgressLine() { clear(); }
  void clear() {
    if (std::exchange(is_drawn_, false)) to_stderr("\r\x1b[K", false);
  }
  void show(Time t) {
    if (!is_shown_) return;
    const auto now = std::chrono::steady_clock::now();
    if (first_ == no_time) {
      first_ = t;
      begin_ = now;
    }
    if (now - drawn_ < std::chrono::milliseconds(100)) return;
    drawn_ = now;
    is_drawn_ = true;
    const double wall = std::chrono::duration<double>(now - begin_).count();
    const double speed = wall > 0 ? seconds(t - first_) / wall : 0;
    to_stderr(fmt::format("\r{:.1f} s of data, {:.0f} x real time\x1b[K", seconds(t - first_), speed), false);
  }

 private:
  bool is_shown_;
  bool is_drawn_ = false;
  Time first_ = no_time;
  std::chrono::steady_clock::time_point begin_, drawn_;
};

/// Whether samples come as they are measured: such a run ends when it is interrupted, and is not given up.
bool is_live(const Composition& composition) {
  return std::ranges::any_of(composition.sources(),
                             [](const auto& source) { return source.object->declaration().live; });
}

/// Then it ends with results where it is interrupted.
bool goes_by_clock(const RunVerbOptions& options, const Composition& composition) {
  return options.run.pace > 0 || (options.input.empty() && is_live(composition));
}

void refuse_pace_of_live(const RunVerbOptions& options, const Composition& composition) {
  if (options.run.pace > 0 && is_live(composition))
    throw UsageError("--pace is for recorded data, and a source of this config is live: it has a pace of its own");
}

class Watch : public score::RunObserver {
 public:
  Watch(RunRecorder* recorder, RecordJournal* journal, InputWriter* input, live::RunPage* page, bool is_quiet,
        bool is_live)
      : recorder_(recorder),
        journal_(journal),
        input_(input),
        page_(page),
        is_quiet_(is_quiet),
        is_live_(is_live),
        line_(stderr_is_terminal() && !is_quiet) {}

  void begin_run(const Session& session) override {
    if (page_) page_->begin_run(session);
  }
  void after_instant() override {
    if (page_) page_->after_instant();
  }
  void finished() override {
    if (page_) page_->finished();
  }
  bool wants_records() const override { return recorder_ != nullptr; }
  void begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns) override {
    if (recorder_) recorder_->begin(filter, name, columns);
  }
  void record(int filter, Time t, std::span<const double> values) override {
    if (journal_)
      journal_->record(filter, t, values);
    else if (recorder_)
      recorder_->record(filter, t, values);
  }
  StepObserver* step_observer(int filter) override {
    StepObserver* const recorded = journal_    ? journal_->step_observer(filter)
                                   : recorder_ ? recorder_->step_observer(filter)
                                               : nullptr;
    return page_ ? page_->step_observer(filter, recorded) : recorded;
  }
  void exchange(StateBytes& bytes) override {
    if (journal_) journal_->exchange(bytes);
  }
  void scored(int filter, const score::ErrorSeries& errors) override {
    if (recorder_) recorder_->scored(filter, errors);
  }
  void noted(const Diagnostic& note) override {
    if (is_quiet_) return;
    line_.clear();
    print_diagnostic(note);
    shown_.add(note);
  }
  bool wants_arrivals() const override { return input_; }
  void arrived(const Arrival& arrival) override { input_->write(arrival); }
  const Diagnostics& shown() const { return shown_; }
  bool progress(Time t) override {
    line_.show(t);
    if (page_) page_->after_instant();  // sources may have fallen silent: then no instant follows
    if (interrupted_by() == 0) return true;
    if (!is_live_) throw Interrupted();
    return false;
  }

 private:
  RunRecorder* recorder_;
  RecordJournal* journal_;  // null: without checkpoints
  InputWriter* input_;      // null: not kept
  live::RunPage* page_;
  bool is_quiet_, is_live_;
  Diagnostics shown_;
  ProgressLine line_;
};

Json provenance_of(const RunVerbOptions& options, const Composition& composition) {
  Json all = provenance(composition.catalog(),
                        fmt::format("binnacle run {}{}{} --seed {} --run {}", shell_quoted(options.config_path),
                                    options.config.as_typed(), options.smooth ? " --smooth" : "", options.run.seed,
                                    options.run.run));
  all["seed"] = options.run.seed;
  all["run"] = options.run.run;
  all["created"] = now_in_words();
  return all;
}

/// What a run leaves behind. Both are opened before the run, so that a bad name is reported at once.
struct Outputs {
  Outputs(const RunVerbOptions& options, const Composition& composition) {
    if (!options.summary.empty()) summary = std::make_unique<AtomicFile>(options.summary);
    if (!options.record_input.empty()) input = std::make_unique<InputWriter>(options.record_input, composition);
    if (!options.out.empty())
      recorder =
          std::make_unique<RunRecorder>(options.out, composition, provenance_of(options, composition), options.formats);
  }
  void commit(const Json& figures, const Json& config) {
    if (input) input->close();
    if (recorder) recorder->commit(figures, config);
    if (!summary) return;
    summary->write(figures.dump(2) + "\n");
    summary->commit();
  }
  std::unique_ptr<AtomicFile> summary;
  std::unique_ptr<RunRecorder> recorder;
  std::unique_ptr<InputWriter> input;
};

score::RunResult watched_run(const std::shared_ptr<const Composition>& composition, RunVerbOptions& options,
                             const Outputs& outputs, live::RunPage* page, Diagnostics& shown) {
  RunRecorder* const recorder = outputs.recorder.get();
  std::unique_ptr<RecordJournal> journal;
  if (recorder && options.checkpoints.are_wanted())
    journal =
        std::make_unique<RecordJournal>(options.checkpoints.kept_records(), options.checkpoints.resumed_records(),
                                        RecordTakers{[recorder](int filter, Time t, std::span<const double> values) {
                                                       recorder->record(filter, t, values);
                                                     },
                                                     [recorder](int filter) {
                                                       return recorder->step_observer(filter);
                                                     }},
                                        score::filters_of(*composition).size());
  Watch watch(recorder, journal.get(), outputs.input.get(), page, options.quiet, goes_by_clock(options, *composition));
  score::RunOptions run_options = options.run;
  std::unique_ptr<InputReader> input;
  if (!options.input.empty()) input = std::make_unique<InputReader>(options.input, *composition);
  run_options.input = input.get();
  run_options.checkpoints = options.checkpoints.checkpoints();
  run_options.observer = &watch;
  score::RunResult result = score::run(composition, run_options);
  shown = watch.shown();
  if (input && !input->warning().empty())
    result.warnings.warning("B144", Origin{options.input, 0, 0}, "", input->warning());
  return result;
}

/// Null where none is asked for. Its address goes to stderr, `--quiet` or not: port 0 is known by nothing else.
std::unique_ptr<live::RunPage> served_page(const RunVerbOptions& options, const Composition& composition) {
  if (!options.page) return nullptr;
  try {
    auto page = std::make_unique<live::RunPage>(*options.page, Json::parse(composition.config()),
                                                provenance_of(options, composition));
    to_stderr("page: " + page->url());
    return page;
  } catch (const live::AddressError& error) {
    throw UsageError(error.what());
  }
}

/// But those that are shown already, word for word.
void tell_warnings(const Composition& composition, const score::RunResult& result, const Diagnostics& shown) {
  Diagnostics warnings = composition.warnings();
  for (const auto& warning : result.warnings.items())
    if (std::ranges::find(shown.items(), warning) == shown.items().end()) warnings.add(warning);
  print_abridged(warnings, "--summary has all that came of the data");
}

/// Lines that a receiver did not get although it was there. One that left knows.
Diagnostics losses(const Diagnostics& warnings) {
  const auto left = [&](const Diagnostic& loss) {
    return std::ranges::any_of(warnings.items(),
                               [&](const auto& other) { return other.code == "B146" && other.origin == loss.origin; });
  };
  Diagnostics lost;
  for (const auto& warning : warnings.items())
    if (warning.code == "B145" && !left(warning)) lost.add(warning);
  return lost;
}

int run_config(RunVerbOptions& options) {
  options.formats = options.records.formats();
  options.checkpoints.open();
  watch_signals("nothing was written" + options.checkpoints.advice());
  LoadOptions load_options = options.config.load_options(options.config_path);
  if (options.smooth) add_smoothers(options.config_path, load_options);
  const auto composition = score::load(options.config_path, load_options);
  watch_exit();  // again, now that the plugins are loaded
  refuse_pace_of_live(options, *composition);
  if (goes_by_clock(options, *composition)) watch_second_signal();
  study::refuse_misspelt_metrics(*composition, options.config_path, load_options);
  auto outputs = std::make_unique<Outputs>(options, *composition);
  const auto page = served_page(options, *composition);
  Diagnostics shown;
  score::RunResult result;
  try {
    result = watched_run(composition, options, *outputs, page.get(), shown);
    stand_down();
    if (interrupted_by() != 0 && !goes_by_clock(options, *composition)) throw Interrupted();
  } catch (const Interrupted&) {
    stand_down();
    outputs.reset();
    print_error("interrupted; nothing was written" + options.checkpoints.advice());
    die_of_signal();
  }
  if (page) page->conclude(result.summary);
  outputs->commit(result.summary, Json::parse(composition->config()));
  options.checkpoints.remove();
  if (options.quiet)
    print_diagnostics(losses(result.warnings));
  else
    tell_warnings(*composition, result, shown);
  if (options.json)
    print_json(result.summary);
  else if (!options.quiet)
    print(summary_text(result.summary, *composition));
  print_diagnostics(result.doubts);
  print_diagnostics(result.failures);
  const Verdict worst = options.strict ? Verdict::ok : Verdict::doubtful;  // that passes
  return result.failures.empty() && result.verdict <= worst ? ok : failed;
}

}  // namespace

Verb run_verb(CLI::App& command) {
  const auto options = std::make_shared<RunVerbOptions>();
  CLI::App* app = add_verb(command, "run");
  app->add_option("CONFIG", options->config_path, "The config")->required();
  options->config.add_to(*app);
  options->config.add_variant_to(*app);
  app->add_option("--summary", options->summary, "Write the summary as JSON to a file")->type_name("FILE.json");
  auto* out = app->add_option("--out", options->out,
                              "Record the run in a folder: run.nc, FILTER.csv, summary.json, config.json, report.html")
                  ->type_name("DIR");
  options->records.add_to(*app, out);
  app->add_option("--page", options->page, "Serve the report's page during the run; default HOST: loopback")
      ->type_name("[HOST:]PORT");
  app->add_option("--seed", options->run.seed, "Seed of all random numbers")->type_name("N")->capture_default_str();
  app->add_option("--run", options->run.run, "Number of the run with this seed")
      ->type_name("K")
      ->check(CLI::Range(0, 1'000'000'000))
      ->capture_default_str();
  options->checkpoints.add_to(*app);
  auto* pace = app->add_option("--pace", options->run.pace, "Replay recorded data in real time, X times faster")
                   ->type_name("X")
                   ->check(CLI::PositiveNumber);
  app->add_option("--record-input", options->record_input,
                  "Write all arriving input to a file, in order of arrival, for --input")
      ->type_name("FILE")
      ->excludes("--resume");
  app->add_option("--input", options->input, "Run a file of --record-input instead of the sources")
      ->type_name("FILE")
      ->excludes(pace)
      ->excludes("--resume")
      ->excludes("--checkpoint");
  app->add_flag("--smooth", options->smooth, "Smooth every filter after the run: FILTER.smoothed");
  app->add_flag("--json", options->json, "Print the summary as JSON on stdout");
  app->add_flag(
      "--quiet", options->quiet,
      "Print only errors, the reasons of verdicts and losses of lines: no progress, other warnings or summary");
  app->add_flag("--strict", options->strict, "Exit with status 1 also if a filter is doubtful, not only if it is lost");
  return {app, [options] { return run_config(*options); }};
}

}  // namespace binnacle::command
