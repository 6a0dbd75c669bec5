// SPDX-License-Identifier: Apache-2.0
#include "allan_channel.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "binnacle/composition.hpp"
#include "binnacle/run.hpp"
#include "binnacle/section.hpp"
#include "binnacle/unit.hpp"
#include "output.hpp"
#include "table.hpp"

namespace binnacle::command {

namespace {

/// Shows the channel to the run's observer; what else a config has is left alone.
class Subscription final : public Section {
 public:
  explicit Subscription(std::string channel) : channel_(std::move(channel)) {}
  std::vector<std::string> keys() const override {
    return {"reference", "evaluate", "record", "study", "covariance", "metrics", "tune"};
  }
  std::vector<std::string> filter_keys() const override { return {"implied_states", "smoother"}; }
  std::shared_ptr<const SectionData> read(CompositionDraft& draft) const override {
    const auto& channels = draft.channels();
    for (std::size_t i = 0; i < channels.size(); ++i)
      if (channels[i].name == channel_) draft.subscribe(static_cast<int>(i), "--channel");
    return nullptr;
  }

 private:
  std::string channel_;
};

std::shared_ptr<const Composition> composition_with(const std::string& config, LoadOptions options,
                                                    const std::string& channel) {
  options.sections = {std::make_shared<Subscription>(channel)};
  LoadOptions bare = options;
  bare.sets.insert(bare.sets.end(), {"/filters={}", "/sinks=null"});
  try {
    return Composition::load(config, bare);
  } catch (const Error&) {  // something subscribes to a filter
    return Composition::load(config, options);
  }
}

int channel_of(const Composition& composition, const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < composition.channels().size(); ++i) {
    if (composition.channels()[i].name == name) return static_cast<int>(i);
    names.push_back(composition.channels()[i].name);
  }
  const std::string near = closest(name, names);
  throw UsageError("--channel: there is no channel '" + name + "'" +
                   (near.empty() ? "" : "; did you mean '" + near + "'?") + " (channels: " + joined(names) + ")");
}

class Collector final : public RunObserver {
 public:
  Collector(const ChannelInfo& info, double full, const std::function<bool()>& goes_on)
      : full_(full), goes_on_(goes_on) {
    channel.name = info.name;
    for (std::size_t f = 0; f < info.declaration->fields.size(); ++f) {
      const FieldSpec& field = info.declaration->fields[f];
      if (field.is_per_row) continue;
      is_increment_.push_back(field.kind == FieldKind::increment);
      position_.push_back(info.position[f]);
      AllanField& of = channel.fields.emplace_back();
      of.name = field.name;
      of.unit = !is_increment_.back() ? field.unit : field.unit == "m/s" ? "m/s^2" : field.unit + "/s";
    }
  }
  void sampled(int, const SampleView& sample) override {
    Row row{sample.t, {}};
    for (const int position : position_) row.values.push_back(sample.fields[position]);
    if (variances_.empty()) {
      first_.push_back(std::move(row));
      if (first_.size() == enough) begin_variances();
    } else {
      take(row);
    }
  }
  bool progress(Time) override { return goes_on_(); }
  void finished() override {
    if (variances_.empty() && first_.size() > 2) begin_variances();
    for (std::size_t f = 0; f < variances_.size(); ++f) {
      channel.fields[f].points = variances_[f].points();
      channel.fields[f].fit = allan::fit(channel.fields[f].points, channel.interval);
    }
    if (last_ != no_time) channel.seconds = seconds(last_ - begin_);
  }
  AllanChannel channel;

 private:
  static constexpr std::size_t enough = 1000;  // samples, to know the interval
  struct Row {
    Time t;
    std::vector<double> values;
  };

  void begin_variances() {
    std::vector<Time> steps;
    for (std::size_t i = 1; i < first_.size(); ++i) steps.push_back(first_[i].t - first_[i - 1].t);
    std::ranges::nth_element(steps, steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
    interval_ = std::max<Time>(1, steps[steps.size() / 2]);
    channel.interval = seconds(interval_);
    const double full = std::clamp(full_ / channel.interval, 1.0, 1e6);
    for (std::size_t f = 0; f < channel.fields.size(); ++f)
      variances_.emplace_back(channel.interval, static_cast<std::int64_t>(full));
    for (const Row& row : first_) take(row);
    first_.clear();
  }

  void take(const Row& row) {
    if (last_ == no_time) {
      begin_ = row.t;
    } else {
      const Time step = row.t - last_;
      if (2 * step < interval_) {
        ++channel.repeated;
        return;
      }
      if (2 * step > 3 * interval_) {
        ++channel.gaps;
        channel.missing += seconds(step - interval_);
        for (auto& variances : variances_) variances.interrupt();
      }
    }
    last_ = row.t;
    ++channel.samples;
    for (std::size_t f = 0; f < variances_.size(); ++f) {
      const double value = is_increment_[f] ? row.values[f] / channel.interval : row.values[f];
      if (std::isfinite(value)) {
        variances_[f].add(value);
      } else {
        ++channel.fields[f].invalid;
        variances_[f].interrupt();
      }
    }
  }

  double full_;
  const std::function<bool()>& goes_on_;
  Time interval_ = 0, begin_ = no_time, last_ = no_time;
  std::vector<Row> first_;
  std::vector<int> position_;
  std::vector<bool> is_increment_;
  std::vector<allan::Variances> variances_;
};

}  // namespace

AllanChannel allan_channel(const std::string& config, const LoadOptions& options, const std::string& channel,
                           double full, std::uint64_t seed, const std::function<bool()>& goes_on) {
  const auto composition = composition_with(config, options, channel);
  const int index = channel_of(*composition, channel);
  Collector collector(composition->channels()[static_cast<std::size_t>(index)], full, goes_on);
  if (collector.channel.fields.empty())
    throw UsageError("--channel: '" + channel + "' has no fields of its samples as a whole, only of their rows");
  RunOptions run_options;
  run_options.seed = seed;
  run_options.observer = &collector;
  run_options.feeds_sinks = false;
  collector.channel.warnings = run(composition, run_options).warnings;
  return std::move(collector.channel);
}

}  // namespace binnacle::command
