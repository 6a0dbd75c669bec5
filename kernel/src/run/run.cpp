// SPDX-License-Identifier: Apache-2.0
#include "binnacle/run.hpp"

#include <algorithm>
#include <deque>
#include <limits>
#include <optional>
#include <set>

#include "base/text.hpp"
#include "run/arrival_watch.hpp"
#include "run/arrivals.hpp"
#include "run/checkpoint.hpp"
#include "run/history.hpp"
#include "run/runtime.hpp"

namespace binnacle {

namespace {

using namespace internal;
using namespace runtime;

class WarningReporter : public Reporter {
 public:
  /// observer: is shown them at once, where there is one.
  WarningReporter(Diagnostics& warnings, const filter::Planned& of, RunObserver* const& observer)
      : warnings_(warnings), of_(of), observer_(observer) {}
  void warn(const std::string& code, const std::string& file, int line, const std::string& message) override {
    const Diagnostic warning{Severity::warning, code, Origin{file, line, 0}, of_.pointer, message};
    warnings_.add(warning);
    if (observer_) observer_->noted(warning);
  }

 private:
  Diagnostics& warnings_;
  const filter::Planned& of_;
  RunObserver* const& observer_;
};

void open_sources(const compose::CompositionPlan& plan) {
  compose::SourceOpening& opening = *plan.opening;
  Diagnostics errors;
  for (const auto& source : plan.sources) {
    Reporter& reporter =
        *opening.reporters.emplace_back(std::make_unique<WarningReporter>(opening.warnings, source, opening.observer));
    try {
      source.type->guarded("open", [&] { source.object->open(reporter); });
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

/// "imu from 0 s to 12 s".
std::string span_text(const Runtime& runtime, int channel) {
  const auto& span = runtime.span(channel);
  const std::string& name = runtime.plan().channels[as_size(channel)].name;
  if (span.from == no_time) return name + " not at all";
  return name + " from " + filter::time_text(span.from) + " to " + filter::time_text(span.to);
}

/// Why a channel stays silent, as the transform that makes it says; empty where it does not.
std::string reason_of_silence(Runtime& runtime, int channel) {
  for (const auto& transform : runtime.plan().transforms)
    if (base::index_of(transform.channels, channel) >= 0) {
      try {
        return transform.type->guarded("waits_for", [&] {
          return transform.object->waits_for(transform.memory.in(runtime.arena()));
        });
      } catch (const ComponentError& error) {
        return error.what();
      }
    }
  return "";
}

/// The channels that a filter needs to start, and all that these are made of.
std::set<int> channels_behind(const compose::CompositionPlan& plan, const filter::FilterPlan& filter) {
  std::set<int> all;
  if (filter.input_channel >= 0) all.insert(filter.input_channel);
  for (const auto& initial : filter.initial)
    if (initial.is_of_start) all.insert(initial.channel);
  for (std::size_t size = 0; size != all.size();) {
    size = all.size();
    for (const auto& transform : plan.transforms)
      if (std::ranges::any_of(transform.channels, [&](int channel) { return all.contains(channel); }))
        for (const auto& input : transform.inputs)
          if (input.channel >= 0) all.insert(input.channel);
  }
  return all;
}

std::string why_not_started(Runtime& runtime, const filter::FilterPlan& filter) {
  std::string wanted, silent, reason, spans;
  Time first_end = std::numeric_limits<Time>::max(), last_begin = no_time;
  for (const auto& initial : filter.initial) {
    if (!initial.is_of_start) continue;
    const std::string& name = runtime.plan().channels[as_size(initial.channel)].name;
    wanted += (wanted.empty() ? "" : ", ") + name;
    if (initial.head.in(runtime.arena())->t != no_time) continue;
    silent += (silent.empty() ? "" : ", ") + name;
    if (reason.empty()) reason = reason_of_silence(runtime, initial.channel);
  }
  for (const int channel : channels_behind(runtime.plan(), filter)) {
    const auto& span = runtime.span(channel);
    if (span.from == no_time) continue;
    first_end = std::min(first_end, span.to);
    last_begin = std::max(last_begin, span.from);
    spans += (spans.empty() ? "" : ", ") + span_text(runtime, channel);
  }
  if (wanted.empty()) return "no sample came";
  const std::string apart = last_begin > first_end ? "; the spans of the data do not overlap: " + spans : "";
  if (silent.empty()) return "its initial values were never there together (channels: " + wanted + ")" + apart;
  return "no sample ever came on " + silent + " (it needs " + wanted + ")" + (reason.empty() ? "" : ": " + reason) +
         apart;
}

/// Measurements that gave nothing and what sections subscribe to, where its samples have no time in common with the
/// driving input.
void note_spans_apart(const Runtime& runtime, Diagnostics& warnings) {
  const auto& plan = runtime.plan();
  const auto are_apart = [&](int input, int channel) {
    if (input < 0) return false;
    const auto &a = runtime.span(input), &b = runtime.span(channel);
    return a.from != no_time && b.from != no_time && (a.to < b.from || b.to < a.from);
  };
  const auto warn = [&](const std::string& pointer, int input, int channel) {
    warnings.warning("B114", plan.document.key_origin(pointer), pointer,
                     "channel '" + plan.channels[as_size(channel)].name +
                         "' has no time in common with the input: " + span_text(runtime, input) + ", " +
                         span_text(runtime, channel) + "; is the offset or the unit of a time missing?");
  };
  for (int f = 0; f < base::count_of(plan.filters); ++f)
    for (int m = 0; m < base::count_of(plan.filters[as_size(f)].measurements); ++m) {
      const auto& filter = plan.filters[as_size(f)];
      const auto& measurement = filter.measurements[as_size(m)];
      const auto& outcomes = runtime.engine(f).ledger().tally(m).by_outcome;
      const auto used = outcomes[static_cast<int>(Outcome::accepted)] + outcomes[static_cast<int>(Outcome::withheld)];
      if (used == 0 && are_apart(filter.input_channel, measurement.channel))
        warn(measurement.pointer, filter.input_channel, measurement.channel);
    }
  for (const auto& [channel, pointer] : plan.subscriptions)
    if (!plan.filters.empty() &&
        std::ranges::all_of(plan.filters, [&](const auto& filter) { return are_apart(filter.input_channel, channel); }))
      warn(pointer, plan.filters.front().input_channel, channel);
}

/// What was not used since it came later than any history.
void note_dropped(const Runtime& runtime, Diagnostics& warnings) {
  const auto& plan = runtime.plan();
  if (!runtime.history()) return;
  for (int c = 0; c < base::count_of(plan.channels); ++c) {
    const auto& dropped = runtime.history()->dropped(c);
    if (dropped.count == 0) continue;
    const auto& channel = plan.channels[as_size(c)];
    warnings.warning("B122", plan.document.key_origin(channel.pointer), channel.pointer,
                     std::to_string(dropped.count) + " samples of channel '" + channel.name + "' came up to " +
                         filter::time_text(dropped.longest) + " late, and the longest history is " +
                         filter::time_text(plan.history.length) + "; they were not used" +
                         (dropped.while_lagging == 0 ? std::string()
                                                     : ", " + std::to_string(dropped.while_lagging) +
                                                           " of them since the live estimates lagged behind"));
  }
}

/// What arrived at its own time since the field of its latency holds none.
void note_without_latency(const Runtime& runtime, Diagnostics& warnings) {
  const auto& plan = runtime.plan();
  if (!runtime.arrivals()) return;
  for (std::size_t s = 0; s < plan.sources.size(); ++s) {
    const auto count = runtime.arrivals()->without_latency(s);
    if (count == 0) continue;
    const std::string pointer = plan.sources[s].pointer + "/latency";
    warnings.warning("B124", plan.document.origin(pointer), pointer,
                     std::to_string(count) + " samples of source '" + plan.sources[s].name +
                         "' have a latency that is NaN, infinite or negative; they arrived at their own time");
  }
}

void note_failures(Runtime& runtime, Diagnostics& failures) {
  const auto& plan = runtime.plan();
  for (std::size_t f = 0; f < plan.filters.size(); ++f) {
    const auto& filter = plan.filters[f];
    const auto& engine = runtime.engine(static_cast<int>(f));
    if (engine.broken()) {
      failures.error("B080", plan.document.key_origin(filter.pointer), filter.pointer,
                     "filter '" + filter.name + "' broke: " + engine.ledger().diagnosis());
    } else if (!engine.has_started()) {
      failures.error("B081", plan.document.key_origin(filter.pointer), filter.pointer,
                     "filter '" + filter.name + "' never started: " + why_not_started(runtime, filter));
    }
  }
}

/// What belongs to every run of the composition.
using Parts = std::vector<std::shared_ptr<RunObserver>>;

Parts parts_of(const compose::CompositionPlan& plan) {
  Parts parts;
  for (const auto& section : plan.sections)
    if (auto part = section ? section->part() : nullptr) parts.push_back(std::move(part));
  return parts;
}

/// What a sink keeps; of one that knows no way to go on there is no checkpoint.
void exchange_sink(const compose::CompositionPlan& plan, const compose::SinkPlan& sink, StateBytes& bytes, Time t) {
  if (guard_call<DataError>(plan, sink, "exchange", t, [&] { return sink.object->exchange(bytes); })) return;
  throw ConfigError(Diagnostic{Severity::error, "B084", plan.document.key_origin(sink.pointer), sink.pointer,
                               "there are no checkpoints with the sink '" + sink.name + "': its type '" +
                                   sink.type->spec.type + "' does not say how it goes on from one"});
}

/// From the first instant to the end of the sources.
void run_sources(Session& session, const Parts& parts, const RunOptions& options, RunObserver& observer,
                 RunResult& result) {
  Runtime& runtime = session.runtime();
  runtime.subscribe([&](int channel, const SampleView& sample) { observer.sampled(channel, sample); });
  runtime.subscribe_settled([&](int channel, const SampleView& sample) { observer.settled(channel, sample); });
  std::vector<std::size_t> noted(runtime.plan().filters.size());
  Checkpointing checkpointing(runtime, session.composition().hash(), options, [&](StateBytes& bytes) {
    bytes.list(noted);
    for (const auto& part : parts) part->exchange(bytes);
    observer.exchange(bytes);
    if (options.feeds_sinks)
      for (const auto& sink : runtime.plan().sinks) exchange_sink(runtime.plan(), sink, bytes, runtime.time());
  });
  checkpointing.begin();
  std::optional<ArrivalWatch> watch;
  if (ArrivalWatch::is_wanted(runtime.plan(), options, observer)) watch.emplace(runtime, options, observer);
  for (std::int64_t instants = 0;; ++instants) {
    if (!runtime.next_instant()) {
      if (!runtime.waits()) break;
      if (!observer.progress(runtime.time())) runtime.end_sources();
      runtime.wait_for_sources();
      continue;
    }
    for (int f = 0; f < base::count_of(noted); ++f)
      while (noted[as_size(f)] < runtime.engine(f).calls().note_book.notes().size())
        observer.noted(session.notes({f}).items()[noted[as_size(f)]++]);
    for (const auto& part : parts) part->after_instant();
    observer.after_instant();
    checkpointing.after_instant();
    if (watch) watch->end_instant();
    if (instants % 32 == 0 && !observer.progress(runtime.time())) runtime.end_sources();
  }
  if (watch) result.live = watch->figures();
  watch.reset();
  runtime.finish();
  for (const auto& part : parts) part->finished();
  if (!parts.empty()) runtime.finish();  // of what they emitted
  observer.after_instant();
  observer.finished();
  runtime.subscribe({});
  runtime.subscribe_settled({});
}

}  // namespace

bool can_rerun(const Session& session) { return !session.runtime().is_live(); }

void rerun(Session& session, std::span<const std::byte> from, std::int64_t instants,
           const std::function<void()>& each) {
  Runtime& runtime = session.runtime();
  const int filters = base::count_of(runtime.plan().filters);
  std::vector<filter::NoteBook> notes;
  for (int f = 0; f < filters; ++f) notes.push_back(runtime.engine(f).calls().note_book);
  const auto times = runtime.filter_times();
  runtime.feed_sinks(false);
  for (int f = 0; f < filters; ++f) runtime.engine(f).attach_section(nullptr);
  session.restore(from);
  bool is_over = false;
  for (std::int64_t i = 0; i < instants && !is_over; ++i) {
    is_over = !runtime.next_instant();
    if (!is_over) each();
  }
  if (is_over || instants == 0) {
    runtime.finish();
    each();
  }
  for (int f = 0; f < filters; ++f) runtime.engine(f).calls().note_book = notes[as_size(f)];
  runtime.filter_times() = times;
}

RunResult run(const std::shared_ptr<const Composition>& composition, const RunOptions& options) {
  const auto& plan = composition->plan();
  RunResult result;
  if (!options.input) std::call_once(plan.opening->once, [&] { open_sources(plan); });

  RunObserver nobody;
  RunObserver& observer = options.observer ? *options.observer : nobody;
  const bool is_live =
      std::ranges::any_of(plan.sources, [](const auto& source) { return source.object->declaration().live; });
  if (is_live) plan.opening->observer = &observer;
  Session session(composition, options.seed, options.run, options.estimates,
                  !options.input && Runtime::is_ordered(plan));
  Runtime& runtime = session.runtime();
  runtime.feed_sinks(options.feeds_sinks);
  runtime.read_from(options.input);
  const Parts parts = parts_of(plan);
  for (const auto& part : parts) part->begin(session);
  observer.begin(session);
  std::deque<WarningReporter> reporters;
  if (options.feeds_sinks)
    for (const auto& sink : plan.sinks) {
      sink.object->report_to(reporters.emplace_back(result.warnings, sink, options.observer));
      guard_call<DataError>(plan, sink, "open", no_time, [&] { sink.object->open(); });
    }
  run_sources(session, parts, options, observer, result);
  if (options.feeds_sinks)
    for (const auto& sink : plan.sinks)
      guard_call<DataError>(plan, sink, "close", runtime.time(), [&] { sink.object->close(); });

  Diagnostics warnings = plan.opening->warnings;
  if (is_live) plan.opening->observer = nullptr;
  warnings.merge(result.warnings);
  result.warnings = std::move(warnings);
  for (int f = 0; f < static_cast<int>(plan.filters.size()); ++f) result.warnings.merge(session.notes({f}));
  note_spans_apart(runtime, result.warnings);
  note_dropped(runtime, result.warnings);
  note_without_latency(runtime, result.warnings);
  note_failures(runtime, result.failures);
  return result;
}

}  // namespace binnacle
