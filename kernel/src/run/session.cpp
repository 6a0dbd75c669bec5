// SPDX-License-Identifier: Apache-2.0
#include "binnacle/session.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/index.hpp"
#include "base/text.hpp"
#include "binnacle/outputs.hpp"
#include "run/runtime.hpp"

namespace binnacle {

namespace {

using namespace runtime;

using base::as_size;

struct SnapshotHead {
  char magic[8] = {'b', 'i', 'n', 's', 'n', 'a', 'p', '1'};
  std::uint64_t composition = 0;
  std::uint64_t size = 0;
};

[[noreturn]] void no_such(const char* code, const std::string& what, std::string_view name,
                          const std::vector<std::string>& names) {
  throw ConfigError(Diagnostic{Severity::error,
                               code,
                               {},
                               "",
                               "there is no " + what + " '" + std::string(name) + "'" + base::suggestion(name, names)});
}

}  // namespace

Session::Session(std::shared_ptr<const Composition> composition, std::uint64_t seed, int run)
    : composition_(std::move(composition)) {
  runtime_ = std::make_unique<Runtime>(composition_->plan());
  std::size_t scratch = 1;
  for (const auto& filter : composition_->filters())
    for (const auto& block : filter.blocks) scratch = std::max(scratch, output_sigma_scratch(block));
  scratch_.assign(scratch, 0.0);
  reset(seed, run);
}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

void Session::reset(std::uint64_t seed, int run) { runtime_->reset(seed, run); }

int Session::channel(std::string_view name) const {
  const int index = composition_->plan().channel(name);
  if (index >= 0) return index;
  std::vector<std::string> names;
  for (const auto& channel : composition_->channels()) names.push_back(channel.name);
  no_such("B020", "channel", name, names);
}

int Session::filter(std::string_view name) const {
  std::vector<std::string> names;
  for (std::size_t f = 0; f < composition_->filters().size(); ++f) {
    names.push_back(composition_->filters()[f].name);
    if (names.back() == name) return static_cast<int>(f);
  }
  no_such("B027", "filter", name, names);
}

Session::Block Session::block(std::string_view name) const {
  std::vector<std::string> names;
  const auto& filters = composition_->filters();
  for (std::size_t f = 0; f < filters.size(); ++f)
    for (std::size_t b = 0; b < filters[f].blocks.size(); ++b) {
      const std::string& block = filters[f].blocks[b].name;
      names.push_back(filters[f].name + "/" + block);
      if (names.back() == name || (filters.size() == 1 && block == name))
        return {static_cast<int>(f), static_cast<int>(b)};
    }
  no_such("B015", "block", name, names);
}

void Session::push(int channel, Time t0, Time t, std::span<const double> fields) {
  const auto& plan = composition_->plan().channels.at(as_size(channel));
  if (static_cast<int>(fields.size()) != plan.epoch_fields)
    throw std::invalid_argument("channel '" + plan.name + "' has " + std::to_string(plan.epoch_fields) +
                                " fields; got " + std::to_string(fields.size()));
  SampleView sample;
  sample.t = t;
  sample.t0 = t0;
  sample.fields = fields.data();
  sample.available = true;
  push(channel, sample);
}

void Session::push(int channel, const SampleView& sample) {
  add(channel, sample);
  runtime_->end_instant(sample.t);
}

void Session::add(int channel, const SampleView& sample) {
  const auto& plan = composition_->plan().channels.at(as_size(channel));
  if (sample.rows < 0 || sample.rows > plan.declaration.max_rows)
    throw std::invalid_argument("channel '" + plan.name + "' takes at most " +
                                std::to_string(plan.declaration.max_rows) + " rows; got " +
                                std::to_string(sample.rows));
  runtime_->deliver(channel, sample);
}
void Session::commit(Time t) { runtime_->end_instant(t); }

bool Session::started(int filter) const { return runtime_->engine(filter).started(); }
bool Session::healthy(int filter) const { return !runtime_->engine(filter).broken(); }
std::string Session::diagnosis(int filter) const { return runtime_->engine(filter).diagnosis(); }
Time Session::start_time(int filter) const { return runtime_->engine(filter).status().start; }
Time Session::time(int filter) const { return runtime_->engine(filter).status().t; }

void Session::read(Block block, std::span<double> outputs) const {
  const auto& engine = runtime_->engine(block.filter);
  const auto& plan = engine.plan().blocks[as_size(block.block)];
  plan.block->read(engine.state() + plan.stored_offset, outputs.data());
}

void Session::read_sigma(Block block, std::span<double> sigmas) const {
  const auto& engine = runtime_->engine(block.filter);
  const BlockInfo& info = composition_->filters().at(as_size(block.filter)).blocks.at(as_size(block.block));
  output_sigmas(info, engine.state() + info.stored_offset, engine.covariance(), scratch_.data(), sigmas.data());
}

MatrixView Session::covariance(Block block) const {
  const auto& engine = runtime_->engine(block.filter);
  const auto& plan = engine.plan().blocks[as_size(block.block)];
  const MatrixView P = engine.covariance();
  const int active = static_cast<int>(plan.active.size());
  return {P.data + plan.first + static_cast<std::ptrdiff_t>(plan.first) * P.stride, active, active, P.stride};
}

MatrixView Session::covariance(int filter) const { return runtime_->engine(filter).covariance(); }

std::span<const double> Session::state(int filter) const {
  const auto& engine = runtime_->engine(filter);
  return {engine.state(), as_size(engine.plan().stored_size)};
}

MeasurementCounts Session::counts(int filter, int measurement) const {
  const Ledger& ledger = runtime_->engine(filter).ledger(measurement);
  MeasurementCounts counts;
  counts.offered = ledger.offered;
  std::copy(std::begin(ledger.outcomes), std::end(ledger.outcomes), counts.by_outcome);
  counts.before_start = ledger.before_start;
  counts.recoveries = ledger.recoveries;
  counts.rows_left_out = ledger.rows_left_out;
  counts.nis_count = ledger.nis_count;
  const double n = static_cast<double>(ledger.nis_count);
  counts.nis_mean = n > 0 ? ledger.nis_sum / n : std::numeric_limits<double>::quiet_NaN();
  counts.dof_mean = n > 0 ? static_cast<double>(ledger.dof_sum) / n : 0.0;
  counts.last_reason = ledger.last_reason;
  return counts;
}

void Session::attach(int filter, StepObserver* observer) { runtime_->engine(filter).attach(observer); }

std::size_t Session::snapshot_size() const { return sizeof(SnapshotHead) + runtime_->arena_size(); }

void Session::snapshot(std::span<std::byte> into) const {
  if (into.size() != snapshot_size())
    throw std::invalid_argument("a snapshot of this composition has " + std::to_string(snapshot_size()) + " bytes");
  SnapshotHead head;
  head.composition = composition_->hash();
  head.size = runtime_->arena_size();
  std::memcpy(into.data(), &head, sizeof head);
  std::memcpy(into.data() + sizeof head, runtime_->arena(), runtime_->arena_size());
}

void Session::restore(std::span<const std::byte> from) {
  SnapshotHead head;
  const SnapshotHead own;
  const auto refuse = [](const std::string& why) {
    throw ConfigError(Diagnostic{Severity::error, "B082", {}, "", "the snapshot cannot be restored: " + why});
  };
  if (from.size() < sizeof head) refuse("it is only " + std::to_string(from.size()) + " bytes long");
  std::memcpy(&head, from.data(), sizeof head);
  if (std::memcmp(head.magic, own.magic, sizeof head.magic) != 0) refuse("these bytes are no snapshot");
  if (head.composition != composition_->hash())
    refuse("it was taken of another composition, or with other plugins or another version of this program");
  if (head.size != runtime_->arena_size() || from.size() != snapshot_size())
    refuse("its size is " + std::to_string(from.size()) + ", not " + std::to_string(snapshot_size()));
  std::memcpy(runtime_->arena(), from.data() + sizeof head, runtime_->arena_size());
}

}  // namespace binnacle
