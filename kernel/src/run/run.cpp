// SPDX-License-Identifier: Apache-2.0
#include "binnacle/run.hpp"

#include <chrono>
#include <set>

#include "base/index.hpp"
#include "filter/residual_rows.hpp"
#include "run/guard_call.hpp"
#include "run/runtime.hpp"

namespace binnacle {

namespace {

using namespace runtime;

using base::as_size;

class WarningReporter : public Reporter {
 public:
  WarningReporter(Diagnostics& warnings, const compose::SourcePlan& source) : warnings_(warnings), source_(source) {}
  void warn(const std::string& code, const std::string& file, int line, const std::string& message) override {
    warnings_.warning(code, Origin{file, line, 0}, source_.pointer, message);
  }

 private:
  Diagnostics& warnings_;
  const compose::SourcePlan& source_;
};

void open_sources(const compose::CompositionPlan& plan, Diagnostics& warnings) {
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
  const auto& ledger = engine.tally(measurement);
  return {{"rows", ledger.rows_left_out}, {"of", ledger.dof_sum + ledger.rows_left_out}, {"by_key", std::move(by_key)}};
}

nlohmann::ordered_json measurement_summary(const Engine& engine) {
  static constexpr const char* names[outcome_count] = {"accepted", "gated",    "late",    "unsupported",
                                                       "invalid",  "withheld", "rejected"};
  nlohmann::ordered_json summary = nlohmann::ordered_json::object();
  const auto& plan = engine.plan();
  for (std::size_t m = 0; m < plan.measurements.size(); ++m) {
    const auto& ledger = engine.tally(static_cast<int>(m));
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

/// Hands the samples of subscribed channels on.
class SampleRelay final : public SampleSubscriber {
 public:
  explicit SampleRelay(RunObserver& observer) : observer_(observer) {}
  void sampled(int channel, const SampleView& sample) override { observer_.sampled(channel, sample); }

 private:
  RunObserver& observer_;
};

std::vector<int> subscribed_channels(const compose::CompositionPlan& plan) {
  std::set<int> channels;
  for (const auto& subscription : plan.subscriptions) channels.insert(subscription.channel);
  return {channels.begin(), channels.end()};
}

/// From the first instant to the end of the sources.
void run_sources(Runtime& runtime, RunObserver& observer) {
  SampleRelay relay(observer);
  runtime.subscribe(&relay, subscribed_channels(runtime.plan()));
  for (std::int64_t instants = 0; runtime.next_instant(); ++instants) {
    observer.after_instant();
    if (instants % 32 == 0 && !observer.progress(runtime.time())) break;
  }
  runtime.finish();
  observer.after_instant();
  observer.finished();
  runtime.subscribe(nullptr, {});
}

nlohmann::ordered_json filter_summary(const Runtime& runtime, int filter) {
  const auto& engine = runtime.engine(filter);
  nlohmann::ordered_json entry;
  entry["measurements"] = measurement_summary(engine);
  if (engine.started()) {
    entry["start_s"] = seconds(engine.status().start);
    entry["end_s"] = seconds(engine.status().t);
  }
  entry["steps"] = engine.status().steps;
  if (engine.status().gaps > 0) entry["input_gaps"] = engine.status().gaps;
  entry["filter_s"] = runtime.filter_seconds(filter);
  if (engine.broken()) entry["broken"] = engine.diagnosis();
  return entry;
}

}  // namespace

RunResult run(const std::shared_ptr<const Composition>& composition, const RunOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const auto& plan = composition->plan();
  RunResult result;
  std::call_once(plan.opening->once, [&] { open_sources(plan, plan.opening->warnings); });
  result.warnings = plan.opening->warnings;

  RunObserver nobody;
  RunObserver& observer = options.observer ? *options.observer : nobody;
  Session session(composition, options.seed, options.run);
  Runtime& runtime = session.runtime();
  runtime.feed_sinks(options.feeds_sinks);
  observer.begin(session);
  if (options.feeds_sinks)
    for (const auto& sink : plan.sinks) guard_call<DataError>(plan, sink, "open", no_time, [&] { sink.sink->open(); });
  run_sources(runtime, observer);
  if (options.feeds_sinks)
    for (const auto& sink : plan.sinks)
      guard_call<DataError>(plan, sink, "close", runtime.time(), [&] { sink.sink->close(); });

  nlohmann::ordered_json filters = nlohmann::ordered_json::object();
  for (int f = 0; f < static_cast<int>(plan.filters.size()); ++f) {
    filters[plan.filters[as_size(f)].name] = filter_summary(runtime, f);
    result.warnings.merge(session.notes({f}));
  }
  result.summary["filters"] = std::move(filters);
  note_failures(runtime, result.failures);
  nlohmann::ordered_json warnings = nlohmann::ordered_json::array();
  for (const auto& warning : result.warnings.items()) warnings.push_back(to_string(warning));
  result.summary["warnings"] = std::move(warnings);
  result.summary["seed"] = options.seed;
  result.summary["wall_s"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace binnacle
