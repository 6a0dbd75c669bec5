// SPDX-License-Identifier: Apache-2.0
#include "binnacle/session.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "base/index.hpp"
#include "base/text.hpp"
#include "base/time_range.hpp"
#include "run/checksum.hpp"
#include "run/history.hpp"
#include "run/runtime.hpp"

namespace binnacle {

namespace {

using namespace internal;
using namespace runtime;

using base::as_size;

struct SnapshotHead {
  char magic[8] = {'b', 'i', 'n', 's', 'n', 'a', 'p', '2'};
  std::uint64_t composition = 0;
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;  // of all, as if it were zero
};

/// Where a name stands among those there are.
int find(const std::vector<std::string>& names, std::string_view name, const char* code, const std::string& what) {
  const auto found = std::ranges::find(names, name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  throw ConfigError(Diagnostic{Severity::error,
                               code,
                               {},
                               "",
                               "there is no " + what + " '" + std::string(name) + "'" + base::suggestion(name, names)});
}

/// "ins/position", or "position" where there is one filter: (filter, index in its list).
template <class List>
std::pair<int, int> find_in_filters(const Composition& composition, List FilterInfo::*list, const char* code,
                                    const char* what, std::string_view name) {
  std::vector<std::string> names;
  std::vector<std::pair<int, int>> places;
  const auto& filters = composition.filters();
  const bool is_alone = filters.size() == 1 && name.find('/') == name.npos;
  for (std::size_t f = 0; f < filters.size(); ++f)
    for (const auto& item : filters[f].*list) {
      names.push_back(is_alone ? item.name : filters[f].name + "/" + item.name);
      places.emplace_back(static_cast<int>(f), static_cast<int>(&item - (filters[f].*list).data()));
    }
  return places[as_size(find(names, name, code, what))];
}

/// Checked.
const auto& item_at(const auto& list, int index, const char* what) {
  if (index < 0 || as_size(index) >= list.size())
    throw std::out_of_range(std::string("there is no ") + what + " " + std::to_string(index) + " (of " +
                            std::to_string(list.size()) + ")");
  return list[as_size(index)];
}

}  // namespace

Session::Session(std::shared_ptr<const Composition> composition, std::uint64_t seed, int run, Estimates estimates)
    : Session(std::move(composition), seed, run, estimates, false) {}

Session::Session(std::shared_ptr<const Composition> composition, std::uint64_t seed, int run, Estimates estimates,
                 bool is_ordered)
    : composition_(std::move(composition)), shown_(estimates) {
  runtime_ = std::make_unique<Runtime>(composition_->plan(), is_ordered);
  runtime_->show(estimates);
  std::size_t scratch = 1;
  for (const auto& filter : composition_->filters())
    for (const auto& block : filter.blocks) scratch = std::max(scratch, output_sigma_scratch(block));
  scratch_.assign(scratch, 0.0);
  reset(seed, run);
}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

void Session::reset(std::uint64_t seed, int run) {
  runtime_->reset(seed, run);
  intake_.assign(composition_->channels().size(), Intake{});
  instant_ = no_time;
}

ChannelId Session::channel(std::string_view name) const {
  return {find(base::names_of(composition_->channels()), name, "B020", "channel")};
}

FilterId Session::filter(std::string_view name) const {
  return {find(base::names_of(composition_->filters()), name, "B027", "filter")};
}

BlockId Session::block(std::string_view name) const {
  const auto [filter, index] = find_in_filters(*composition_, &FilterInfo::blocks, "B015", "block", name);
  return {{filter}, index};
}

MeasurementId Session::measurement(std::string_view name) const {
  const auto [filter, index] = find_in_filters(*composition_, &FilterInfo::measurements, "B027", "measurement", name);
  return {{filter}, index};
}

// ---- what is wrong with a call

Engine& Session::engine(FilterId filter) const {
  item_at(composition_->filters(), filter.index, "filter");
  return runtime_->engine(filter.index);
}

const BlockInfo& Session::info(BlockId block) const {
  return item_at(item_at(composition_->filters(), block.filter.index, "filter").blocks, block.index, "block");
}

const Session::Intake& Session::intake(ChannelId channel) const { return item_at(intake_, channel.index, "channel"); }

void Session::push(ChannelId channel, Time t0, Time t, std::span<const double> fields) {
  intake(channel);
  const auto& plan = composition_->plan().channels[as_size(channel.index)];
  if (static_cast<int>(fields.size()) != plan.epoch_fields)
    throw std::invalid_argument("channel '" + plan.name + "' has " + std::to_string(plan.epoch_fields) +
                                " fields; got " + std::to_string(fields.size()));
  push(channel, SampleView{.t = t, .t0 = t0, .fields = fields.data(), .available = true});
}

void Session::push(ChannelId channel, const SampleView& sample) {
  if (instant_ != no_time)
    throw std::invalid_argument("what was added for one instant must be committed before the next push");
  take(channel, sample);
  runtime_->end_arrival(sample.t);
  runtime_->settle();
}

void Session::add(ChannelId channel, const SampleView& sample) {
  if (instant_ != no_time && sample.t != instant_)
    throw std::invalid_argument("samples that are added together have one time");
  take(channel, sample);
  instant_ = sample.t;
}

void Session::commit(Time t) {
  if (instant_ != no_time && t != instant_)
    throw std::invalid_argument("commit() takes the time of the samples that were added");
  instant_ = no_time;
  runtime_->end_arrival(t);
  runtime_->settle();
}

void Session::take(ChannelId channel, const SampleView& sample) {
  intake(channel);
  Intake& taken = intake_[as_size(channel.index)];
  const auto& plan = composition_->plan().channels[as_size(channel.index)];
  if (sample.rows < 0 || sample.rows > plan.declaration.max_rows)
    throw std::invalid_argument("channel '" + plan.name + "' takes at most " +
                                std::to_string(plan.declaration.max_rows) + " rows; got " +
                                std::to_string(sample.rows));
  if ((!sample.fields && plan.epoch_fields > 0) || (!sample.row_fields && sample.rows * plan.row_fields > 0))
    throw std::invalid_argument("a sample on channel '" + plan.name + "' has no fields");
  if (sample.t == no_time) throw std::invalid_argument("a sample on channel '" + plan.name + "' has no time");
  if (!base::is_near(sample.t) || (sample.t0 != no_time && !base::is_near(sample.t0)))
    throw std::invalid_argument("a sample on channel '" + plan.name + "' at " + std::to_string(sample.t) +
                                " ns is more than " + base::farthest_text + " from zero");
  if (sample.t0 != no_time && sample.t0 >= sample.t)
    throw std::invalid_argument("a sample on channel '" + plan.name + "' begins at " + std::to_string(sample.t0) +
                                " ns and ends at " + std::to_string(sample.t) + " ns; t0 < t, or no_time");
  ++taken.counts.pushed;
  if (taken.newest != no_time && sample.t < taken.newest)
    ++taken.counts.behind;
  else
    taken.newest = sample.t;
  runtime_->deliver(channel.index, sample);
}

bool Session::started(FilterId filter) const { return engine(filter).has_started(); }
bool Session::healthy(FilterId filter) const { return !engine(filter).broken(); }
std::string Session::diagnosis(FilterId filter) const { return engine(filter).ledger().diagnosis(); }
Time Session::start_time(FilterId filter) const { return engine(filter).status().start; }
Time Session::time(FilterId filter) const { return engine(filter).status().t; }

Diagnostics Session::notes(FilterId filter) const {
  const auto& from = engine(filter);
  const NoteBook& book = from.calls().note_book;
  const Document& document = composition_->plan().document;
  const auto times = [](std::int64_t count) { return " (" + std::to_string(count) + " times)"; };
  Diagnostics notes;
  for (const auto& note : book.notes())
    notes.warning("B083", document.key_origin(*note.pointer), *note.pointer,
                  filter::call_text(*note.type, *note.pointer, note.call, note.first) + " notes: " + note.text +
                      (note.count > 1 ? times(note.count) : ""));
  if (const auto left_out = book.left_out(); left_out > 0)
    notes.warning("B083", document.key_origin(from.plan().pointer), from.plan().pointer,
                  "further notes of filter '" + from.plan().name + "' are left out" + times(left_out));
  return notes;
}

/// Calls a block for as many numbers as it has outputs, from its stored state.
template <class Call>
void Session::read(BlockId block, std::span<double> outputs, const char* call_name, Call&& call) const {
  const BlockInfo& of = info(block);
  if (const auto count = of.declaration->outputs.size(); outputs.size() != count)
    throw std::invalid_argument("block '" + of.name + "' has " + std::to_string(count) +
                                " outputs; there is room for " + std::to_string(outputs.size()));
  const Engine& of_filter = runtime_->engine(block.filter.index);
  if (of_filter.status().t == no_time) {  // zeros would pass for an estimate
    std::ranges::fill(outputs, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const auto error = [&](const std::string& text) {
    const std::string& pointer = of_filter.plan().blocks[as_size(block.index)].pointer;
    return FilterError(
        Diagnostic{Severity::error, "B045", composition_->plan().document.origin(pointer), pointer, text});
  };
  call_plugin(
      nullptr, of.type, call_name, of_filter.status().t,
      [&] { call(of, of_filter.state() + of.stored_offset, of_filter); }, error);
}

void Session::read(BlockId block, std::span<double> outputs) const {
  read(block, outputs, "read", [&](const BlockInfo& of, const double* x, const Engine&) {
    of.block->read({x, of.declaration->stored_size}, {outputs.data(), static_cast<int>(outputs.size())});
  });
}

void Session::read_sigma(BlockId block, std::span<double> sigmas) const {
  read(block, sigmas, "plus and read, for its 1-sigma",
       [&](const BlockInfo& of, const double* x, const Engine& of_filter) {
         output_sigmas(of, x, of_filter.covariance(), scratch_.data(), sigmas.data());
       });
}

ConstMatrixView Session::covariance(BlockId block) const {
  const BlockInfo& of = info(block);
  const ConstMatrixView P = covariance(block.filter);
  const int active = static_cast<int>(of.active.size());
  return {P.data + of.first_row + static_cast<std::ptrdiff_t>(of.first_row) * P.stride, active, active, P.stride};
}

ConstMatrixView Session::covariance(FilterId filter) const { return engine(filter).covariance(); }

std::span<const double> Session::state(FilterId filter) const {
  return {engine(filter).state(), as_size(engine(filter).plan().stored_size)};
}

FilterCounts Session::counts(FilterId filter) const {
  const auto& head = engine(filter).status();
  const auto* history = history_of(filter);
  return {head.steps, head.gaps, runtime_->of(filter.index).filter_times()[as_size(filter.index)].seconds,
          history ? history->lag().longest : 0};
}

ChannelCounts Session::counts(ChannelId channel) const { return intake(channel).counts; }

void Session::attach(FilterId filter, StepObserver* observer) { engine(filter).attach(observer); }
void Session::attach_section(FilterId filter, StepObserver* observer) { engine(filter).attach_section(observer); }

void Session::push_estimates(ChannelId channel, FilterId filter, Time t, const double* x, ConstMatrixView P) {
  intake(channel);
  const auto& further = engine(filter).plan().further_channels;
  if (std::ranges::find(further, channel.index) == further.end())
    throw std::invalid_argument("channel '" + composition_->channels()[as_size(channel.index)].name +
                                "' is none that a section has for filter '" + engine(filter).plan().name + "'");
  runtime_->emit_estimates(channel.index, filter.index, t, x, P);
}

const History* Session::history_of(FilterId filter) const {
  return engine(filter).plan().history > 0 ? runtime_->history() : nullptr;
}

bool Session::was_lagging(FilterId filter) const {
  const auto* history = history_of(filter);
  return history && history->lag().since != no_time;
}

Verdict Session::verdict(FilterId filter) const {
  const Verdict verdict = engine(filter).verdict();
  return was_lagging(filter) ? std::max(verdict, Verdict::doubtful) : verdict;
}

std::size_t Session::reasons(FilterId filter, std::span<TrustReason> into) const {
  const std::size_t count = engine(filter).reasons(into);
  if (!was_lagging(filter)) return count;
  const auto& lag = runtime_->history()->lag();
  if (count < into.size()) {
    into[count] = {.doubt = Doubt::lagging, .since = lag.since, .figure = seconds(lag.longest)};
    into[count].limit = seconds(composition_->plan().history.length);
  }
  return count + 1;
}

MeasurementCounts Session::counts(MeasurementId measurement) const {
  const auto& filter = engine(measurement.filter);
  item_at(filter.plan().measurements, measurement.index, "measurement");
  const Tally& tally = filter.ledger().tally(measurement.index);
  const double n = static_cast<double>(tally.nis_count);
  MeasurementCounts counts{tally, {}, 0, 0, tally.last_reason};
  counts.nis_mean = n > 0 ? tally.nis_sum / n : std::numeric_limits<double>::quiet_NaN();
  counts.dof_mean = n > 0 ? static_cast<double>(tally.rows_used) / n : 0.0;
  if (const auto* history = history_of(measurement.filter)) {
    const int channel = filter.plan().measurements[as_size(measurement.index)].channel;
    const auto& dropped = history->dropped(channel);
    counts.offered += dropped.count;
    counts.by_outcome[static_cast<int>(Outcome::late)] += dropped.count;
    if (dropped.count > 0 && counts.last_reason.empty())
      counts.last_reason =
          dropped.while_lagging > 0 ? "late, and the live estimates lagged behind" : "older than the filter's history";
  }
  for (const auto& row : filter.ledger().rows(measurement.index))
    if (row.is_in_use) counts.rows.push_back(internal::filter::figures_of(row));
  return counts;
}

namespace {

/// ∂outputs/∂δ by central differences. J: outputs × dof; columns of components that are not estimated stay as they are.
void difference_outputs(const BlockInfo& block, const double* x, ConstMatrixView P, MatrixView J, double* scratch) {
  const auto& declaration = *block.declaration;
  const int outputs = static_cast<int>(declaration.outputs.size());
  const ConstVectorView at(x, declaration.stored_size);
  const VectorView delta(scratch, declaration.dof());
  const VectorView moved(delta.data() + delta.size(), declaration.stored_size);
  const VectorView above(moved.data() + moved.size(), outputs), below(above.data() + outputs, outputs);
  delta.as().setZero();
  for (std::size_t a = 0; a < block.active.size(); ++a) {
    const int component = block.active[a], row = block.first_row + static_cast<int>(a);
    const double sigma = std::sqrt(std::max(0.0, P(row, row)));
    // A step of the size of the uncertainty itself, but small against the curvature of an angle.
    const double step = std::clamp(sigma, 1e-9, 1e-4);
    delta[component] = step;
    block.block->plus(at, delta, moved);
    block.block->read(moved, above);
    delta[component] = -step;
    block.block->plus(at, delta, moved);
    block.block->read(moved, below);
    delta[component] = 0;
    for (int i = 0; i < outputs; ++i) {
      double difference = above[i] - below[i];
      if (std::abs(difference) > std::numbers::pi && declaration.outputs[as_size(i)].is_angle)
        difference = std::remainder(difference, 2 * std::numbers::pi);
      J(i, component) = difference == 0 ? 0 : difference / (2 * step);
    }
  }
}

}  // namespace

std::size_t output_sigma_scratch(const BlockInfo& block) {
  const auto outputs = block.declaration->outputs.size();
  const auto dof = as_size(block.declaration->dof());
  return outputs * dof + dof + as_size(block.declaration->stored_size) + 2 * outputs;
}

void output_sigmas(const BlockInfo& block, const double* x, ConstMatrixView P, double* scratch, double* sigmas) {
  const auto& declaration = *block.declaration;
  const int outputs = static_cast<int>(declaration.outputs.size()), dof = declaration.dof();
  const MatrixView J{scratch, outputs, dof, outputs};
  if (!block.block->output_jacobian({x, declaration.stored_size}, J))
    difference_outputs(block, x, P, J, scratch + outputs * dof);
  const int active = static_cast<int>(block.active.size());
  for (int i = 0; i < outputs; ++i) {
    double variance = 0;
    // Most outputs are of one component: what is times 0 is left out.
    for (int a = 0; a < active; ++a) {
      const double along_a = J(i, block.active[as_size(a)]);
      if (along_a == 0) continue;
      for (int b = 0; b < active; ++b)
        if (const double along_b = J(i, block.active[as_size(b)]); along_b != 0)
          variance += along_a * P(block.first_row + a, block.first_row + b) * along_b;
    }
    sigmas[i] = std::sqrt(std::max(0.0, variance));
  }
}

std::size_t Session::snapshot_size() const {
  StateBytes bytes;
  runtime_->exchange(bytes);
  return sizeof(SnapshotHead) + bytes.size();
}

void Session::snapshot(std::span<std::byte> into) const {
  if (const auto size = snapshot_size(); into.size() != size)
    throw std::invalid_argument("a snapshot of this session has " + std::to_string(size) + " bytes now");
  SnapshotHead head;
  head.composition = composition_->hash();
  head.size = into.size() - sizeof head;
  auto bytes = StateBytes::write(into.subspan(sizeof head));
  runtime_->exchange(bytes);
  head.checksum = runtime::checksum_of(head, into.subspan(sizeof head));
  std::memcpy(into.data(), &head, sizeof head);
}

void Session::restore(std::span<const std::byte> from) {
  SnapshotHead head;
  const SnapshotHead own;
  const auto refuse = [](const std::string& why) {
    throw ConfigError(Diagnostic{Severity::error, "B082", {}, "", "the snapshot cannot be restored: " + why});
  };
  if (from.size() < sizeof head) refuse("it is only " + std::to_string(from.size()) + " bytes long");
  std::memcpy(&head, from.data(), sizeof head);
  if (std::memcmp(head.magic, own.magic, sizeof head.magic) != 0) refuse("these bytes are not a snapshot");
  if (head.composition != composition_->hash())
    refuse("it belongs to another composition, other plugins or another version of this program");
  const std::size_t least = runtime_->arena_size();
  if (head.size < least || from.size() != sizeof head + head.size ||
      (!runtime_->has_more_than_arena() && head.size != least))
    refuse("its size is " + std::to_string(from.size()) + ", not " + std::to_string(sizeof head + head.size));
  if (checksum_of(head, from.subspan(sizeof head)) != head.checksum)
    refuse("its checksum does not match: it is damaged");
  const auto exchange = [&](StateBytes bytes) {
    runtime_->exchange(bytes);
    return bytes;
  };
  // Notes of a history's own snapshots too, which are not in this one.
  const auto exchange_all = [&](StateBytes bytes) {
    runtime_->exchange(bytes);
    runtime_->exchange_account(bytes);
    return bytes;
  };
  std::vector<std::byte> before(exchange_all(StateBytes()).size());
  exchange_all(StateBytes::write(before));
  const StateBytes bytes = exchange(StateBytes::read(from.subspan(sizeof head)));
  if (!bytes.holds() || bytes.size() != head.size) {
    exchange_all(StateBytes::read(before));
    refuse("its content is damaged");
  }
  runtime_->restored();
  for (auto& taken : intake_) taken.newest = no_time;
  instant_ = no_time;
}

}  // namespace binnacle
