// SPDX-License-Identifier: Apache-2.0
#include "binnacle/run_together.hpp"

#include <algorithm>
#include <deque>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/text.hpp"
#include "run/arrival_watch.hpp"
#include "run/arrivals.hpp"
#include "run/checkpoint.hpp"
#include "run/history.hpp"
#include "run/runtime.hpp"
#include "run/shared_feed.hpp"

namespace binnacle {

namespace {

using namespace internal;
using namespace runtime;

class WarningReporter : public Reporter {
 public:
  /// observer: is shown them at once, where there is one.
  WarningReporter(Diagnostics& warnings, const filter::Planned& of, RunObserver* const& observer)
      : warnings_(warnings), pointer_(of.pointer), observer_(observer) {}
  void warn(const std::string& code, const std::string& file, int line, const std::string& message) override {
    const Diagnostic warning{Severity::warning, code, Origin{file, line, 0}, pointer_, message};
    warnings_.add(warning);
    if (observer_) observer_->noted(warning);
  }

 private:
  Diagnostics& warnings_;
  std::string pointer_;
  RunObserver* const& observer_;
};

void open_sources(const compose::CompositionPlan& plan) {
  Diagnostics errors;
  for (const auto& source : plan.sources) {
    compose::SourceOpening& opening = *source.opening;
    try {
      std::call_once(opening.once, [&] {
        opening.reporter = std::make_unique<WarningReporter>(opening.warnings, source, opening.observer);
        source.type->guarded("open", [&] { source.object->open(*opening.reporter); });
      });
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
        return transform.type->guarded("waits_for",
                                       [&] { return transform.object->waits_for(runtime.memory_of(transform)); });
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
  if (silent.empty()) return "its initial values were never available together (channels: " + wanted + ")" + apart;
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
  for (const auto& [subscribed, pointer] : plan.subscriptions) {
    const int channel = subscribed;  // clang before 16 does not capture a structured binding
    if (!plan.filters.empty() &&
        std::ranges::all_of(plan.filters, [&](const auto& filter) { return are_apart(filter.input_channel, channel); }))
      warn(pointer, plan.filters.front().input_channel, channel);
  }
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
                               "checkpoints are not possible with the sink '" + sink.name + "': its type '" +
                                   sink.type->spec.type + "' does not support them"});
}

/// One run, from instant to instant.
class RunUnderWay {
 public:
  RunUnderWay(const std::shared_ptr<const Composition>& composition, const RunOptions& options)
      : plan_(composition->plan()),
        options_(options),
        observer_(options.observer ? *options.observer : nobody_),
        session_(opened(composition, options, observer_)),
        runtime_(session_.runtime()),
        parts_(parts_of(plan_)),
        noted_(plan_.filters.size()),
        checkpointing_(runtime_, composition->hash(), options_, [this](StateBytes& bytes) { exchange(bytes); }) {
    runtime_.feed_sinks(options.feeds_sinks);
    runtime_.read_from(options.input);
  }
  /// Nothing may look into it from here on.
  ~RunUnderWay() {
    for (const auto& source : plan_.sources)
      if (source.object->declaration().live) source.opening->observer = nullptr;
  }
  RunUnderWay(const RunUnderWay&) = delete;
  RunUnderWay& operator=(const RunUnderWay&) = delete;

  void begin() {
    for (const auto& part : parts_) part->begin(session_);
    observer_.begin(session_);
    if (options_.feeds_sinks)
      for (const auto& sink : plan_.sinks) {
        sink.object->report_to(reporters_.emplace_back(result_.warnings, sink, options_.observer));
        guard_call<DataError>(plan_, sink, "open", no_time, [&] { sink.object->open(); });
      }
    runtime_.subscribe([this](int channel, const SampleView& sample) { observer_.sampled(channel, sample); });
    runtime_.subscribe_settled([this](int channel, const SampleView& sample) { observer_.settled(channel, sample); });
    checkpointing_.begin();
    if (ArrivalWatch::is_wanted(plan_, options_, observer_)) watch_.emplace(runtime_, options_, observer_);
  }

  /// An instant; false: there is no further one.
  bool step() {
    if (!runtime_.next_instant()) {
      if (!runtime_.waits()) return false;
      if (!observer_.progress(runtime_.time())) runtime_.end_sources();
      runtime_.wait_for_sources();
      return true;
    }
    for (int f = 0; f < base::count_of(noted_); ++f)
      while (noted_[as_size(f)] < runtime_.engine(f).calls().note_book.notes().size())
        observer_.noted(session_.notes({f}).items()[noted_[as_size(f)]++]);
    for (const auto& part : parts_) part->after_instant();
    observer_.after_instant();
    if (watch_) watch_->end_instant();
    if (instants_++ % 32 == 0 && !observer_.progress(runtime_.time())) runtime_.end_sources();
    checkpointing_.after_instant();  // last: with what the observer keeps of this instant
    return true;
  }

  RunResult finish() {
    if (watch_) result_.live = watch_->figures();
    watch_.reset();
    runtime_.finish();
    for (const auto& part : parts_) part->finished();
    if (!parts_.empty()) runtime_.finish();  // of what they emitted
    observer_.after_instant();
    observer_.finished();
    runtime_.subscribe({});
    runtime_.subscribe_settled({});
    if (options_.feeds_sinks)
      for (const auto& sink : plan_.sinks)
        guard_call<DataError>(plan_, sink, "close", runtime_.time(), [&] { sink.object->close(); });

    Diagnostics warnings;
    for (const auto& source : plan_.sources) warnings.merge(source.opening->warnings);
    warnings.merge(result_.warnings);
    result_.warnings = std::move(warnings);
    for (int f = 0; f < base::count_of(plan_.filters); ++f) result_.warnings.merge(session_.notes({f}));
    note_spans_apart(runtime_, result_.warnings);
    note_dropped(runtime_, result_.warnings);
    note_without_latency(runtime_, result_.warnings);
    note_failures(runtime_, result_.failures);
    return std::move(result_);
  }

  Runtime& runtime() { return runtime_; }

 private:
  static Session opened(const std::shared_ptr<const Composition>& composition, const RunOptions& options,
                        RunObserver& observer) {
    const auto& plan = composition->plan();
    if (!options.input) open_sources(plan);
    for (const auto& source : plan.sources)
      if (source.object->declaration().live) source.opening->observer = &observer;
    return Session(composition, options.seed, options.run, options.estimates,
                   !options.input && Runtime::is_ordered(plan));
  }
  void exchange(StateBytes& bytes) {
    bytes.list(noted_);
    bytes.expect(noted_.size() == plan_.filters.size());
    if (!bytes.holds()) noted_.resize(plan_.filters.size());
    for (const auto& part : parts_) part->exchange(bytes);
    observer_.exchange(bytes);
    if (options_.feeds_sinks)
      for (const auto& sink : plan_.sinks) exchange_sink(plan_, sink, bytes, runtime_.time());
  }

  const compose::CompositionPlan& plan_;
  const RunOptions& options_;
  RunObserver nobody_;
  RunObserver& observer_;
  RunResult result_;
  std::deque<WarningReporter> reporters_;
  Session session_;
  Runtime& runtime_;
  Parts parts_;
  std::vector<std::size_t> noted_;  // of each filter's notes
  Checkpointing checkpointing_;
  std::optional<ArrivalWatch> watch_;
  std::int64_t instants_ = 0;
};

}  // namespace

bool can_rerun(const Session& session) { return !session.runtime().is_live(); }

void rerun(Session& session, std::span<const std::byte> from, std::int64_t instants, RunObserver& observer) {
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
    if (!is_over) observer.after_instant();
  }
  if (is_over || instants == 0) {
    runtime.finish();
    observer.after_instant();
  }
  for (int f = 0; f < filters; ++f) runtime.engine(f).calls().note_book = notes[as_size(f)];
  runtime.filter_times() = times;
}

RunResult run(const std::shared_ptr<const Composition>& composition, const RunOptions& options) {
  RunUnderWay run(composition, options);
  run.begin();
  while (run.step()) {
  }
  return run.finish();
}

// ---- several over the same samples

bool have_same_sources(const Composition& a, const Composition& b) {
  return std::ranges::equal(a.plan().sources, b.plan().sources, [](const auto& one, const auto& other) {
    return !one.identity.empty() && one.identity == other.identity;
  });
}

void share_sources(std::span<const std::shared_ptr<const Composition>> compositions) {
  std::vector<const compose::SourcePlan*> known;
  for (const auto& composition : compositions)
    // Nobody runs it yet, and a plan is made as what may be changed.
    for (auto& source : const_cast<compose::CompositionPlan&>(composition->plan()).sources) {
      const auto same = std::ranges::find(known, source.identity, &compose::SourcePlan::identity);
      if (source.identity.empty()) continue;
      if (same == known.end()) {
        known.push_back(&source);
      } else {
        source.object = (*same)->object;
        source.opening = (*same)->opening;
      }
    }
}

namespace {

struct Member {
  std::unique_ptr<RunUnderWay> run;
  Taps* taps = nullptr;  // null: it is over
};

void refuse_unlike(std::span<const RunRequest> requests) {
  const auto refuse = [](const char* why) { throw std::invalid_argument(std::string("run_together: ") + why); };
  for (const auto& [composition, options] : requests) {
    if (!have_same_sources(*requests.front().composition, *composition)) refuse("the sources are not the same");
    if (options.seed != requests.front().options.seed || options.run != requests.front().options.run)
      refuse("seed and run are not the same");
    if (options.input || options.pace != 0 || options.checkpoints.keeper || !options.checkpoints.from.empty())
      refuse("there are no checkpoints, pace and recorded input");
  }
}

}  // namespace

std::vector<RunOutcome> run_together(std::span<const RunRequest> requests) {
  constexpr std::int64_t stretch = 64;  // samples: each works from what its caches hold, and few wait
  refuse_unlike(requests);
  std::vector<RunOutcome> outcomes(requests.size());
  std::vector<Member> members(requests.size());
  SharedFeed feed;
  // What is thrown ends one alone.
  const auto guarded = [&](std::size_t i, const auto& goes_on) {
    bool is_open = false;
    try {
      is_open = goes_on(members[i]);
    } catch (...) {
      outcomes[i].thrown = std::current_exception();
    }
    if (!is_open && members[i].taps) feed.remove(*std::exchange(members[i].taps, nullptr));
  };
  for (std::size_t i = 0; i < requests.size(); ++i)
    guarded(i, [&](Member& member) {
      member.run = std::make_unique<RunUnderWay>(requests[i].composition, requests[i].options);
      Runtime& runtime = member.run->runtime();
      member.taps = &feed.add(runtime);
      runtime.read_from(member.taps);
      member.run->begin();
      return true;
    });
  const auto is_open = [](const Member& member) { return member.taps != nullptr; };
  for (std::int64_t until = stretch; std::ranges::any_of(members, is_open); until += stretch) {
    for (std::size_t i = 0; i < members.size(); ++i)
      if (is_open(members[i]))
        guarded(i, [&](Member& member) {
          while (member.taps->taken < until)
            if (!member.run->step()) {
              outcomes[i].result = member.run->finish();
              return false;
            }
          return true;
        });
    feed.forget_taken();
  }
  return outcomes;
}

}  // namespace binnacle
