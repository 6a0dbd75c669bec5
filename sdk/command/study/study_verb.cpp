// SPDX-License-Identifier: Apache-2.0
// study: variants of a config, many runs of each, and the tables made of them.
#include <chrono>
#include <memory>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "binnacle/config.hpp"
#include "folder_lock.hpp"
#include "folders.hpp"
#include "interrupt.hpp"
#include "launcher.hpp"
#include "other_results.hpp"
#include "output.hpp"
#include "provenance.hpp"
#include "report_file.hpp"
#include "results/study_writer.hpp"
#include "score/sections.hpp"
#include "sentinel.hpp"
#include "study/coordinator.hpp"
#include "study/journal.hpp"
#include "study/study.hpp"
#include "study/summary.hpp"
#include "study/workers.hpp"
#include "study_results.hpp"
#include "study_text.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

using Clock = std::chrono::steady_clock;

struct StudyVerbOptions {
  std::string config_path;
  ConfigOptions config;
  std::optional<int> runs;
  std::optional<std::uint64_t> seed;
  int jobs = 0;  // 0: all processors
  std::string summary;
  std::string out;
  bool json = false;
  bool quiet = false;
  bool strict = false;
};

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// "41 s", "3 min 5 s", "2 h 10 min"
std::string time_left(double s) {
  const auto whole = static_cast<long>(s + 0.5);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

/// One line on a terminal, rewritten: how many runs are done, and how long the others will take.
class ProgressLine {
 public:
  ProgressLine(bool is_shown, std::size_t done, std::size_t all)
      : is_shown_(is_shown), done_(done), first_(done), all_(all) {}
  ~ProgressLine() {
    if (is_drawn_) to_stderr("\r\x1b[K", false);
  }
  void add(bool has_failed) {
    ++done_;
    failed_ += has_failed;
    const auto now = Clock::now();
    if (!is_shown_ || now - drawn_ < std::chrono::milliseconds(100)) return;
    drawn_ = now;
    is_drawn_ = true;
    const double per_run = seconds_since(begin_) / static_cast<double>(done_ - first_);
    to_stderr(fmt::format("\r{} of {} runs{}, {} left\x1b[K", done_, all_,
                          failed_ ? fmt::format(", {} broke", failed_) : "",
                          time_left(per_run * static_cast<double>(all_ - done_))),
              false);
  }
  std::size_t done() const { return done_; }

 private:
  bool is_shown_;
  bool is_drawn_ = false;
  std::size_t done_, first_, all_, failed_ = 0;
  Clock::time_point begin_ = Clock::now(), drawn_;
};

/// What a study leaves behind. Places are looked at before the first run, so that a bad name is reported at once.
struct Outputs {
  Outputs(const StudyVerbOptions& options, const study::Study& study, study::Results& results) {
    if (!options.summary.empty()) summary = std::make_unique<AtomicFile>(options.summary);
    if (options.out.empty()) return;
    folder = options.out;
    load_netcdf();
    make_folders(folder);
    lock.emplace(folder);
    journal = std::make_unique<study::Journal>(folder / "study.journal", study, results);
    config = Json::parse(score::load_config(options.config_path, options.config.load_options()).text());
    command = fmt::format("binnacle study {} --runs {} --seed {}{}", shell_quoted(options.config_path), study.runs(),
                          study.seed(), options.config.as_typed());
  }
  /// Now, not once hours of runs are done.
  void load_netcdf() const {
    try {
      results::load_netcdf();
    } catch (const results::WriteError& error) {
      throw OutputError(fmt::format("'{}' could not be written: {}", (folder / "study.nc").string(), error.what()));
    }
  }
  void write(const char* name, const std::string& text) const {
    AtomicFile file(folder / name);
    file.write(text);
    file.commit();
  }
  /// Nothing in the folder shows how long it took: an interrupted study leaves the same files as another.
  void commit(const study::Study& study, const study::Results& results, const Json& figures, const Json& timed) const {
    if (journal) {
      journal->sync();
      std::error_code ignored;
      std::filesystem::remove(folder / "study.json", ignored);  // with it there, all of them are, and of one study
      std::filesystem::remove(report_in(folder), ignored);
      write("study.csv", study::runs_csv(study, results));
      write("table.csv", study::tables_csv(figures));
      write_netcdf(study, results, figures);
      write("study.json", figures.dump(2) + "\n");
      name_other_run(folder, config);
      write_page(page(), report_in(folder));
    }
    if (!summary) return;
    summary->write(timed.dump(2) + "\n");
    summary->commit();
  }
  /// Reads the results again, which takes memory. They are whole without the page.
  std::string page() const {
    const auto fault = [this](const std::string& why) {
      return OutputError(could_not_write(report_in(folder), why + "; the other results are complete"));
    };
    try {
      return report_page(folder);
    } catch (const std::bad_alloc&) {
      throw fault("memory is exhausted");
    } catch (const std::runtime_error& error) {
      throw fault(error.what());
    }
  }
  void write_netcdf(const study::Study& study, const study::Results& results, const Json& figures) const {
    AtomicFile file(folder / "study.nc", AtomicFile::Temporary::named);
    try {
      results::write_study(file.path(), study_results(study, results, figures, config, command));
    } catch (const results::WriteError& error) {
      file.fail(error.what());
    }
    file.commit();
  }
  std::unique_ptr<AtomicFile> summary;
  std::filesystem::path folder;
  std::optional<FolderLock> lock;
  std::unique_ptr<study::Journal> journal;
  Json config;
  std::string command;
};

/// The command that repeats one run alone.
std::string repeated_by(const StudyVerbOptions& options, const study::Study& study, const study::Variant& variant,
                        std::size_t run) {
  std::string line = "binnacle run " + shell_quoted(options.config_path);
  if (!variant.patches.empty()) line += " --variant " + shell_quoted(variant.name);
  line += fmt::format(" --seed {} --run {}", study.seed(), run);
  return line + options.config.as_typed();
}

bool any_lost(const study::Study& study, const study::Results& results) {
  for (std::size_t v = 0; v < study.variants().size(); ++v)
    for (std::size_t run = 0; run < results.runs(); ++run)
      if (results.at(v, run).verdict == Verdict::lost) return true;
  return false;
}

/// Runs that broke: the first few by name and number, then how many there are.
std::size_t tell_failures(const StudyVerbOptions& options, const study::Study& study, const study::Results& results) {
  constexpr std::size_t most_shown = 10;
  std::size_t failures = 0;
  for (std::size_t v = 0; v < study.variants().size(); ++v)
    for (std::size_t run = 0; run < results.runs(); ++run) {
      const auto& figures = results.at(v, run);
      if (figures.state != study::Figures::State::failed || ++failures > most_shown) continue;
      to_stderr(to_string(Diagnostic{Severity::error,
                                     "B093",
                                     {options.config_path, 0, 0},
                                     "",
                                     fmt::format("variant '{}', seed {}, run {}: {}; to see it: {}",
                                                 study.variants()[v].name, study.seed(), run, figures.failure,
                                                 repeated_by(options, study, study.variants()[v], run))}));
    }
  if (failures > 0)
    print_error(fmt::format("{} of {} runs broke{}", failures, study.variants().size() * results.runs(),
                            failures > most_shown ? fmt::format(" ({} shown here)", most_shown) : ""));
  return failures;
}

bool goes_on() { return interrupted_by() == 0; }

/// False when it was interrupted.
bool carry_out(const study::Study& study, study::Results& results, Outputs& outputs, const StudyVerbOptions& options,
               study::Coordinator* coordinator, int jobs) {
  const std::size_t restored = outputs.journal ? outputs.journal->restored() : 0;
  const std::size_t all = study.variants().size() * results.runs();
  if (restored > 0 && !options.quiet)
    to_stderr(fmt::format("{} of {} are in the journal", restored, counted(all, "run")));
  ProgressLine progress(stderr_is_terminal() && !options.quiet, restored, all);
  const auto on_run = [&](std::size_t variant, std::size_t run, const study::Figures& figures) {
    if (outputs.journal) outputs.journal->add(variant, run, figures);
    progress.add(figures.state == study::Figures::State::failed);
  };
  if (coordinator)
    coordinator->carry_out_all(study, results, jobs, goes_on, on_run);
  else
    study::carry_out_all(study, results, jobs, goes_on, on_run);
  return progress.done() == all;
}

study::Study load(const StudyVerbOptions& options) {
  return study::Study::load(options.config_path, {options.config.load_options(), options.runs, options.seed});
}

/// What an interrupted study leaves.
std::string kept_of(const StudyVerbOptions& options) {
  return options.out.empty() ? "nothing was written (with --out DIR a study continues where it stopped)"
                             : "the same command continues from here";
}

/// mpirun ends all of its processes when one of them dies, so this may be how the others learn of it.
std::string interruption(const StudyVerbOptions& options, bool is_led) {
  return std::string("interrupted") + (is_led ? " (if a rank died, mpirun says which)" : "") + "; " + kept_of(options);
}

/// Said at the beginning, since of a rank that mpirun stops the last words may be lost.
void announce_workers(const StudyVerbOptions& options, const study::Team& team, const study::Coordinator& coordinator,
                      int jobs) {
  if (!options.quiet)
    to_stderr(fmt::format("{}, {}{}", counted(static_cast<std::size_t>(team.size()), "rank"),
                          counted(static_cast<std::size_t>(jobs + coordinator.threads()), "thread"),
                          options.out.empty() ? "" : "; after an interruption, the same command continues it"));
}

/// A rank other than 0: does runs and says nothing.
int serve(study::Team& team, const StudyVerbOptions& options, int jobs, const study::Timeouts& timeouts) {
  watch_signals("rank 0 has what is finished");
  const bool is_complete = study::serve(
      team, [&options] { return load(options); }, jobs, goes_on, timeouts);
  stand_down();
  if (!is_complete) die_of_signal();
  return ok;
}

int run_study(const StudyVerbOptions& options) {
  const auto begin = Clock::now();
  const study::Timeouts timeouts = team_timeouts();
  const auto team = join_team(timeouts);
  const int jobs = options.jobs > 0 ? options.jobs : study::processors(team ? team->size_here() : 1);
  if (team && team->rank() > 0) return serve(*team, options, jobs, timeouts);
  std::optional<study::Coordinator> coordinator;
  if (team) coordinator.emplace(*team, timeouts);
  watch_signals(kept_of(options));
  const auto study = coordinator ? coordinator->load([&options] { return load(options); }) : load(options);
  watch_exit();  // again, now that the plugins are loaded
  study::Results results(study.variants().size(), static_cast<std::size_t>(study.runs()));
  std::optional<Outputs> outputs;
  bool is_complete = false;
  try {
    if (!coordinator || coordinator->assemble(study, goes_on)) {
      outputs.emplace(options, study, results);
      if (coordinator) announce_workers(options, *team, *coordinator, jobs);
      is_complete = carry_out(study, results, *outputs, options, coordinator ? &*coordinator : nullptr, jobs);
    }
  } catch (const std::filesystem::filesystem_error& error) {
    throw OutputError(could_not_write(error.path1(), error.code().message()));
  }
  stand_down();
  if (!is_complete) {
    outputs.reset();
    print_error(interruption(options, coordinator.has_value()));
    die_of_signal();
  }
  const bool have_all_left = !coordinator || coordinator->dismiss();
  if (!have_all_left)
    print_error("a rank has not come to its end, it or its machine may be stopped; the results are complete");
  const Json figures = study::summarize(study, results);
  Json timed = figures;
  timed["wall_s"] = seconds_since(begin);
  outputs->commit(study, results, figures, timed);
  if (!options.quiet) print_abridged(study.warnings(), "binnacle check has all");
  if (options.json)
    print_json(timed);
  else if (!options.quiet)
    print(study_text(timed, study) + study_end_text(timed, study));
  const bool is_lost = options.strict && any_lost(study, results);
  return tell_failures(options, study, results) == 0 && !is_lost && have_all_left ? ok : failed;
}

}  // namespace

Verb study_verb(CLI::App& command) {
  const auto options = std::make_shared<StudyVerbOptions>();
  CLI::App* app = add_verb(command, "study");
  app->add_option("CONFIG", options->config_path, "Config with the section \"study\"")->required();
  options->config.add_to(*app);
  app->add_option("--runs", options->runs, "Number of runs of each variant, instead of the config's")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  app->add_option("--seed", options->seed, "Seed of all random numbers, instead of the config's")->type_name("N");
  app->add_option(
         "--jobs", options->jobs,
         "Number of parallel runs in each process; default: the number of processors; the figures do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  app->add_option("--summary", options->summary, "Write the figures as JSON to a file")->type_name("FILE.json");
  app->add_option("--out", options->out,
                  "Folder for study.nc, study.csv, table.csv, study.json; a second start continues the study")
      ->type_name("DIR");
  app->add_flag("--json", options->json, "Print the figures as JSON on stdout");
  app->add_flag("--quiet", options->quiet, "Print only errors: no progress, warnings or tables");
  app->add_flag("--strict", options->strict, "Exit with status 1 if a run is lost");
  return {app, [options] { return run_study(*options); }};
}

}  // namespace binnacle::command
