// SPDX-License-Identifier: Apache-2.0
#include "binnacle/run.hpp"

#include <chrono>

#include "binnacle/session.hpp"
#include "filter/residual_rows.hpp"
#include "run/evaluator.hpp"
#include "run/guard_call.hpp"
#include "run/outputs.hpp"
#include "run/record_epochs.hpp"
#include "run/runtime.hpp"

namespace binnacle {

namespace {

std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

class WarningReporter : public Reporter {
 public:
  WarningReporter(Diagnostics& warnings, const SourcePlan& source) : warnings_(warnings), source_(source) {}
  void warn(const std::string& code, const std::string& file, int line, const std::string& message) override {
    warnings_.warning(code, Origin{file, line, 0}, source_.pointer, message);
  }

 private:
  Diagnostics& warnings_;
  const SourcePlan& source_;
};

void open_sources(const CompositionPlan& plan, Diagnostics& warnings) {
  Diagnostics errors;
  for (const auto& source : plan.sources) {
    WarningReporter reporter(warnings, source);
    try {
      source.type->guarded("open", [&] { source.source->open(reporter); });
    } catch (const ComponentError& error) {
      if (error.is_data_error())
        errors.error(error.code(), Origin{error.file(), error.line(), 0}, source.pointer, error.what());
      else
        errors.error("B030", plan.document.origin(source.pointer + error.pointer()), source.pointer + error.pointer(),
                     error.what());
    }
  }
  if (errors.has_errors()) throw DataError(errors);
}

/// Writes a filter's outputs, their 1-σ and what its noise estimators made of R, at most every so often.
class Recorder {
 public:
  Recorder(const Runtime& runtime, const Evaluator& evaluator, RunObserver& observer, Time every)
      : runtime_(runtime), evaluator_(evaluator), observer_(observer) {
    const auto& filters = runtime.plan().filters;
    tracks_.assign(filters.size(), Track{RecordEpochs(every), no_time, no_time, {}, 0});
    std::size_t scratch = 1;
    for (std::size_t f = 0; f < filters.size(); ++f) {
      std::vector<RecordColumn> columns, sigmas;
      for (const auto& block : filters[f].blocks) {
        for (const auto& output : block.declaration().outputs) {
          columns.push_back({block.name + "." + output.name, output.unit});
          sigmas.push_back({block.name + "." + output.name + ".sigma", output.unit});
        }
        scratch = std::max(scratch, output_sigma_scratch(block));
      }
      columns.insert(columns.end(), sigmas.begin(), sigmas.end());
      const auto implied_states = evaluator.implied_state_columns(static_cast<int>(f));
      columns.insert(columns.end(), implied_states.begin(), implied_states.end());
      const auto noise = evaluator.noise_columns(static_cast<int>(f));
      columns.insert(columns.end(), noise.begin(), noise.end());
      tracks_[f].implied_state_columns = implied_states.size();
      tracks_[f].kept.assign(columns.size(), 0.0);
      values_.resize(std::max(values_.size(), columns.size()));
      observer.begin(static_cast<int>(f), filters[f].name, columns);
    }
    scratch_.resize(scratch);
  }

  void after_instant() {
    using enum RecordEpochs::Verdict;
    for (std::size_t f = 0; f < tracks_.size(); ++f) {
      const auto& engine = runtime_.engine(static_cast<int>(f));
      Track& track = tracks_[f];
      if (!engine.started() || engine.broken() || engine.status().t == track.last) continue;
      const Time t = track.last = engine.status().t;
      const auto verdict = track.epochs.on(t);
      if (verdict == release || verdict == release_and_take || verdict == release_and_keep) write_kept(f);
      if (verdict == take || verdict == release_and_take) {
        read(f, t, values_.data());
        observer_.record(static_cast<int>(f), t, {values_.data(), track.kept.size()});
      } else if (verdict == keep || verdict == release_and_keep) {
        read(f, t, track.kept.data());
        track.kept_at = t;
      }
    }
  }

  void finish() {
    after_instant();
    for (std::size_t f = 0; f < tracks_.size(); ++f)
      if (tracks_[f].epochs.finish()) write_kept(f);
  }

 private:
  struct Track {
    RecordEpochs epochs;
    Time last, kept_at;
    std::vector<double> kept;  // a row that is written unless one nearer to its epoch comes
    std::size_t implied_state_columns;
  };

  void write_kept(std::size_t f) {
    observer_.record(static_cast<int>(f), tracks_[f].kept_at, tracks_[f].kept);
  }

  void read(std::size_t f, Time t, double* values) {
    const auto& engine = runtime_.engine(static_cast<int>(f));
    CallSite site;
    site.set_time(t);
    const CallScope scope(site);
    try {
      for (const auto& block : engine.plan().blocks) {
        site.enter(nullptr, block.type, "read");
        block.block->read(engine.state() + block.stored_offset, values);
        values += block.declaration().outputs.size();
      }
      for (const auto& block : engine.plan().blocks) {
        site.enter(nullptr, block.type, "plus and read, for its 1-sigma");
        output_sigmas(block, engine.state() + block.stored_offset, engine.covariance(), scratch_.data(), values);
        values += block.declaration().outputs.size();
      }
    } catch (const std::exception& error) {
      const auto& pointer = engine.plan().pointer;
      throw FilterError(Diagnostic{Severity::error, "B045", runtime_.plan().document.origin(pointer), pointer,
                                   site.text() + " threw: " + error.what()});
    }
    evaluator_.latest_implied_states(static_cast<int>(f), t, values);
    evaluator_.latest_noise(static_cast<int>(f), values + tracks_[f].implied_state_columns);
  }

  const Runtime& runtime_;
  const Evaluator& evaluator_;
  RunObserver& observer_;
  std::vector<Track> tracks_;  // by filter
  std::vector<double> scratch_, values_;
};

/// Rows that a gate by row or key took out of accepted samples: in all, and which.
nlohmann::ordered_json left_out_summary(const Engine& engine, int measurement) {
  const auto& plan = engine.plan().measurements[static_cast<std::size_t>(measurement)];
  const auto groups = residual_rows_of(engine.plan(), plan);
  const bool tells_group = plan.gate_unit == GateUnit::row && groups.size() > 1;
  nlohmann::ordered_json by_key = nlohmann::ordered_json::object();
  for (const auto& entry : engine.left_out(measurement)) {
    if (entry.count == 0) continue;
    const std::string key = std::to_string(entry.key);
    by_key[tells_group ? groups[static_cast<std::size_t>(entry.group)].name + " " + key : key] = entry.count;
  }
  const Ledger& ledger = engine.ledger(measurement);
  return {{"rows", ledger.rows_left_out}, {"of", ledger.dof_sum + ledger.rows_left_out}, {"by_key", std::move(by_key)}};
}

nlohmann::ordered_json measurement_summary(const Engine& engine) {
  static constexpr const char* names[outcome_count] = {"accepted", "gated",    "late",    "unsupported",
                                                       "invalid",  "withheld", "rejected"};
  nlohmann::ordered_json summary = nlohmann::ordered_json::object();
  const auto& plan = engine.plan();
  for (std::size_t m = 0; m < plan.measurements.size(); ++m) {
    const Ledger& ledger = engine.ledger(static_cast<int>(m));
    nlohmann::ordered_json entry;
    entry["offered"] = ledger.offered;
    for (int o = 0; o < outcome_count; ++o) entry[names[o]] = ledger.outcomes[o];
    entry["before_start"] = ledger.before_start;
    if (plan.measurements[m].recover_after > 0) entry["recoveries"] = ledger.recoveries;
    if (plan.measurements[m].gate_unit != GateUnit::sample)
      entry["left_out"] = left_out_summary(engine, static_cast<int>(m));
    const double n = static_cast<double>(ledger.nis_count);
    if (ledger.nis_count > 0) {
      entry["nis_mean"] = ledger.nis_sum / n;
      entry["dof"] = static_cast<double>(ledger.dof_sum) / n;
    } else {
      entry["nis_mean"] = nullptr;
      entry["dof"] = plan.measurements[m].max_rows;
    }
    if (ledger.last_reason[0] != '\0') entry["last_reason"] = ledger.last_reason;
    summary[plan.measurements[m].name] = std::move(entry);
  }
  return summary;
}

nlohmann::ordered_json metric_summary(const Evaluator& evaluator, const CompositionPlan& plan) {
  nlohmann::ordered_json summary = nlohmann::ordered_json::object();
  for (const auto& metric : plan.evaluation.metrics) {
    const double value = evaluator.value(metric).value;
    const auto unit = parse_unit(metric.unit);
    summary[metric.name] = {{"value", to_unit(value, unit ? *unit : Unit{})}, {"unit", metric.unit}};
  }
  return summary;
}

void note_failures(const Runtime& runtime, Diagnostics& failures) {
  const auto& plan = runtime.plan();
  for (std::size_t f = 0; f < plan.filters.size(); ++f) {
    const auto& filter = plan.filters[f];
    const auto& engine = runtime.engine(static_cast<int>(f));
    if (engine.broken()) {
      failures.error("B080", plan.document.key_origin(filter.pointer), filter.pointer,
                     "filter '" + filter.name + "' broke: " + engine.diagnosis());
    } else if (!engine.started()) {
      std::string wanted, silent;
      for (const auto& initial : filter.initial) {
        const std::string& name = plan.channels[as_size(initial.channel)].name;
        wanted += (wanted.empty() ? "" : ", ") + name;
        if (!engine.has_heard(initial)) silent += (silent.empty() ? "" : ", ") + name;
      }
      failures.error("B081", plan.document.key_origin(filter.pointer), filter.pointer,
                     "filter '" + filter.name + "' never started: " +
                         (wanted.empty()   ? std::string("no sample came")
                          : silent.empty() ? "its initial values were never there together (channels: " + wanted + ")"
                                           : "no sample ever came on " + silent + " (it needs " + wanted + ")"));
    }
  }
}

}  // namespace

RunResult run(const std::shared_ptr<const Composition>& composition, const RunOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const auto& plan = composition->plan();
  RunResult result;
  std::call_once(plan.opening->once, [&] { open_sources(plan, plan.opening->warnings); });
  result.warnings = plan.opening->warnings;

  Runtime runtime(plan);
  runtime.reset(options.seed, options.run);
  runtime.feed_sinks(options.feeds_sinks);
  std::vector<StepObserver*> observers;
  if (options.observer)
    for (std::size_t f = 0; f < plan.filters.size(); ++f)
      observers.push_back(options.observer->step_observer(static_cast<int>(f)));
  Evaluator evaluator(runtime, observers);
  evaluator.watch(plan.evaluation.metrics);
  evaluator.watch(options.metrics);
  std::unique_ptr<Recorder> recorder;
  const bool records = options.observer && options.observer->wants_records();
  if (records) evaluator.keep_sigmas();
  if (records)
    recorder = std::make_unique<Recorder>(runtime, evaluator, *options.observer, composition->record_every());
  if (options.feeds_sinks)
    for (const auto& sink : plan.sinks) guard_call<DataError>(plan, sink, "open", no_time, [&] { sink.sink->open(); });

  for (std::int64_t instants = 0; runtime.next_instant(); ++instants) {
    if (recorder) recorder->after_instant();
    if (options.observer && instants % 32 == 0 && !options.observer->progress(runtime.time())) break;
  }
  runtime.finish();
  if (recorder) recorder->finish();
  evaluator.finish();
  if (records) evaluator.tell_errors(*options.observer);
  if (options.feeds_sinks)
    for (const auto& sink : plan.sinks)
      guard_call<DataError>(plan, sink, "close", runtime.time(), [&] { sink.sink->close(); });

  nlohmann::ordered_json filters = nlohmann::ordered_json::object();
  for (std::size_t f = 0; f < plan.filters.size(); ++f) {
    const auto& engine = runtime.engine(static_cast<int>(f));
    auto entry = evaluator.filter_summary(static_cast<int>(f));
    entry["measurements"] = measurement_summary(engine);
    if (engine.started()) {
      entry["start_s"] = seconds(engine.status().start);
      entry["end_s"] = seconds(engine.status().t);
    }
    entry["steps"] = engine.status().steps;
    if (engine.status().gaps > 0) entry["input_gaps"] = engine.status().gaps;
    entry["filter_s"] = runtime.filter_seconds(static_cast<int>(f));
    if (engine.broken()) entry["broken"] = engine.diagnosis();
    filters[plan.filters[f].name] = std::move(entry);
  }
  result.summary["filters"] = std::move(filters);
  for (const auto& metric : options.metrics) result.metrics.push_back(evaluator.value(metric));
  if (auto metrics = metric_summary(evaluator, plan); !metrics.empty()) result.summary["metrics"] = std::move(metrics);
  if (auto across = evaluator.across_windows(); !across.empty()) result.summary["windows"] = std::move(across);
  note_failures(runtime, result.failures);
  nlohmann::ordered_json warnings = nlohmann::ordered_json::array();
  for (const auto& warning : result.warnings.items()) warnings.push_back(to_string(warning));
  result.summary["warnings"] = std::move(warnings);
  result.summary["seed"] = options.seed;
  result.summary["wall_s"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace binnacle
