// SPDX-License-Identifier: Apache-2.0
#include "run/evaluator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "binnacle/unit.hpp"
#include "filter/residual_rows.hpp"
#include "run/implied_state.hpp"
#include "run/outputs.hpp"

namespace binnacle {

namespace {

std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

/// Names, units and norms of the errors of one kind of block.
struct ErrorNames {
  explicit ErrorNames(const StateBlockDeclaration& declaration, const std::string& prefix) {
    for (const auto& component : declaration.error) {
      names.push_back(prefix + "." + component.name);
      units.push_back(component.unit);
      display.push_back(declaration.error_display_unit.empty() ? component.unit : declaration.error_display_unit);
    }
    for (const auto& norm : declaration.norms) {
      names.push_back(prefix + "." + norm.name);
      const auto first = as_size(norm.components.front());
      units.push_back(declaration.error[first].unit);
      display.push_back(display[first]);
    }
  }
  std::vector<std::string> names, units, display;
};

}  // namespace

double quantile(const std::vector<double>& sorted, double p) {
  const double at = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const auto above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

nlohmann::ordered_json statistics(const Series& series, const TimeSpan& span, Time start) {
  std::vector<double> magnitudes;
  double sum = 0, squares = 0, last = 0;
  for (std::size_t i = 0; i < series.t.size(); ++i) {
    if (!span.contains(series.t[i], start)) continue;
    const double value = series.values[i];
    magnitudes.push_back(std::abs(value));
    sum += value;
    squares += value * value;
    last = value;
  }
  if (magnitudes.empty()) return nullptr;
  std::sort(magnitudes.begin(), magnitudes.end());
  const double n = static_cast<double>(magnitudes.size());
  const auto unit = parse_unit(series.display_unit);
  const double scale = 1 / (unit ? unit->scale : 1.0);
  return {{"mean", sum / n * scale},
          {"rms", std::sqrt(squares / n) * scale},
          {"p50", quantile(magnitudes, 0.5) * scale},
          {"p95", quantile(magnitudes, 0.95) * scale},
          {"max", magnitudes.back() * scale},
          {"final", last * scale},
          {"n", magnitudes.size()},
          {"unit", series.display_unit.empty() ? series.unit : series.display_unit}};
}

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Between the two samples around the instant; NaN outside of them.
double interpolated(const std::vector<Time>& t, const std::vector<double>& values, Time at) {
  const auto above = static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), at) - t.begin());
  if (above == t.size()) return not_a_number;
  if (t[above] == at) return values[above];
  if (above == 0) return not_a_number;
  const double fraction = seconds(at - t[above - 1]) / seconds(t[above] - t[above - 1]);
  return values[above - 1] + fraction * (values[above] - values[above - 1]);
}

double over_time(const std::vector<Time>& t, const std::vector<double>& values, const Metric& metric,
                 const TimeSpan& span, Time start) {
  if (metric.statistic == MetricStatistic::at)
    return interpolated(t, values, metric.at_is_from_start ? start + metric.at : metric.at);
  std::vector<double> inside;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (span.contains(t[i], start)) inside.push_back(values[i]);
  if (inside.empty()) return not_a_number;
  double sum = 0, squares = 0;
  for (const double value : inside) {
    sum += value;
    squares += value * value;
  }
  const double n = static_cast<double>(inside.size()), first = inside.front(), last = inside.back();
  for (double& value : inside) value = std::abs(value);
  switch (metric.statistic) {
    case MetricStatistic::mean: return sum / n;
    case MetricStatistic::rms: return std::sqrt(squares / n);
    case MetricStatistic::max: return *std::max_element(inside.begin(), inside.end());
    case MetricStatistic::final: return last;
    case MetricStatistic::drift: return last - first;
    default: break;
  }
  std::sort(inside.begin(), inside.end());
  return quantile(inside, metric.statistic == MetricStatistic::p50 ? 0.5 : 0.95);
}

}  // namespace

/// Follows one filter. A reference between two steps is compared with the estimate interpolated on the manifold from
/// the a-posteriori state at the step's begin to the a-priori one at its end, so that scoring never changes the run.
class Evaluator::FilterScore : public StepObserver {
 public:
  /// `next` sees the same step observer; null: nobody.
  FilterScore(Runtime& runtime, int filter, StepObserver* next)
      : engine_(runtime.engine(filter)), plan_(engine_.plan()), next_(next) {
    const auto& references = runtime.plan().evaluation.references;
    std::size_t dof = 1, stored = 1, outputs = 1;
    for (const auto& block : plan_.blocks) {
      dof = std::max(dof, as_size(block.dof()));
      stored = std::max(stored, as_size(block.declaration().stored_size));
      outputs = std::max(outputs, block.declaration().outputs.size());
    }
    delta_.resize(dof);
    between_.resize(stored);
    truth_.resize(stored);
    outputs_.resize(outputs);
    covariance_.resize(dof * (dof + 1));
    for (const auto& implied_state : plan_.implied_states)
      implied_states_.emplace_back(implied_state, plan_.blocks[as_size(implied_state.block)]);
    for (const auto& reference : references) {
      if (reference.filter != filter) continue;
      if (reference.block >= 0)
        add_channel_reference(reference);
      else
        scored_measurements_.insert(reference.measurement);
    }
    for (std::size_t m = 0; m < plan_.measurements.size(); ++m) add_withheld(static_cast<int>(m));
    std::set<std::string> names;
    for (std::size_t r = 0; r < references_.size(); ++r)
      for (std::size_t i = 0; i < references_[r].series.size(); ++i)
        if (names.insert(references_[r].series[i].name).second)
          subjects_.push_back({&references_[r].series[i], static_cast<int>(r), static_cast<int>(i)});
    for (const auto& group : withheld_)
      if (scored_measurements_.contains(group.measurement))
        for (const auto& series : group.series)
          if (names.insert(series.name).second) subjects_.push_back({&series, -1, 0});
    for (std::size_t m = 0; m < plan_.measurements.size(); ++m)
      if (plan_.measurements[m].noise) add_noise(static_cast<int>(m));
    for (const auto& group : noise_)
      if (names.insert(group.series.name).second) subjects_.push_back({&group.series, -1, 0});
    engine_.attach(this);
  }
  ~FilterScore() override { engine_.attach(nullptr); }

  void reference(int channel, const SampleView& sample) {
    for (std::size_t i = 0; i < references_.size(); ++i) {
      const auto& plan = *references_[i].plan;
      if (plan.channel != channel) continue;
      if (!engine_.started() || sample.t < engine_.status().start) continue;
      Pending pending;
      pending.reference = static_cast<int>(i);
      pending.t = sample.t;
      bool is_told = false, is_finite = true;
      pending.values.assign(plan.fields.size(), 0.0);
      for (std::size_t k = 0; k < plan.fields.size(); ++k) {
        if (plan.fields[k] < 0) continue;
        pending.values[k] = sample.fields[plan.fields[k]];
        is_finite = is_finite && std::isfinite(pending.values[k]);
        is_told = is_told || !plan.invalid || pending.values[k] != *plan.invalid;
      }
      if (!is_told || !is_finite) continue;
      if (plan.implied_state >= 0) {
        pending_of_implied_states_.push_back(pending);
        score_implied_state(plan.implied_state);
        continue;
      }
      // The filter may have passed this instant already: then only an estimate at that very time will do.
      if (sample.t == engine_.status().t && plan_.input_channel < 0) {
        score(pending, engine_.state());
        continue;
      }
      pending_.push_back(pending);
    }
  }

  Wants wants() const override {
    Wants all = next_ ? next_->wants() : Wants::nothing;
    if (!pending_.empty()) all = all | Wants::step_covariance;
    if (!implied_states_.empty()) all = all | Wants::jacobian | Wants::update_covariance;
    return all;
  }

  void started(Time t, const double* x, MatrixView P) override {
    if (next_) next_->started(t, x, P);
  }
  void restored(Time t, const double* x, MatrixView P) override {
    if (next_) next_->restored(t, x, P);
  }
  void inflated(const InflationRecord& record) override {
    if (next_) next_->inflated(record);
  }

  void stepped(const StepRecord& record) override {
    if (next_) next_->stepped(record);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      if (pending_[i].t < record.t0) continue;
      if (pending_[i].t >= record.t1) {
        pending_[kept++] = pending_[i];
        continue;
      }
      const auto& block = plan_.blocks[as_size(references_[as_size(pending_[i].reference)].plan->block)];
      const double* x0 = record.x0 + block.stored_offset;
      const double* x1 = record.x1 + block.stored_offset;
      const double fraction = seconds(pending_[i].t - record.t0) / seconds(record.t1 - record.t0);
      block.block->minus(x1, x0, delta_.data());
      for (int c = 0; c < block.dof(); ++c) delta_[as_size(c)] *= fraction;
      block.block->plus(x0, delta_.data(), between_.data());
      score_block(pending_[i], between_.data(), record.P0);
    }
    pending_.resize(kept);
  }

  void offered(const UpdateRecord& record) override {
    if (next_) next_->offered(record);
    for (std::size_t r = 0; r < implied_states_.size(); ++r)
      if (implied_states_[r].take(record, record.P0 ? record.P0 : engine_.covariance()))
        score_implied_state(static_cast<int>(r));
    if (record.outcome != Outcome::withheld) {
      keep_noise(record);
      return;
    }
    for (auto& group : withheld_) {
      if (group.measurement != record.measurement) continue;
      const auto [first, rows] = rows_of(record, group.group);
      if (rows < 1 || (group.norms && rows < group.norms->dof())) continue;
      if (!group.norms) {
        double squares = 0;
        for (int i = 0; i < rows; ++i) squares += record.residual[first + i] * record.residual[first + i];
        push(group.series, 0, record.t, std::sqrt(squares / std::max(1, rows)));
        continue;
      }
      push_errors(group.series, *group.norms, record.t, record.residual + first);
    }
  }

  void finish() {
    for (const auto& pending : pending_)
      if (pending.t == engine_.status().t) score(pending, engine_.state());
    pending_.clear();
    pending_of_implied_states_.clear();
  }

  nlohmann::ordered_json summary(const EvaluationPlan& evaluation, int filter) const {
    nlohmann::ordered_json summary;
    summary["reference"] = figures(evaluation.span);
    nlohmann::ordered_json windows = nlohmann::ordered_json::object();
    for (const auto& window : evaluation.windows)
      if (window.filter < 0 || window.filter == filter) windows[window.name] = figures(window.span);
    if (!windows.empty()) summary["windows"] = windows;
    nlohmann::ordered_json withheld = nlohmann::ordered_json::object();
    for (const auto& group : withheld_)
      for (const auto& series : group.series) {
        auto value = statistics(series, evaluation.span, engine_.status().start);
        if (!value.is_null())
          withheld[plan_.measurements[as_size(group.measurement)].name][series.name] = std::move(value);
      }
    if (!withheld.empty()) summary["withheld"] = withheld;
    nlohmann::ordered_json consistency = nlohmann::ordered_json::object();
    for (const auto& reference : references_) {
      double sum = 0;
      std::size_t n = 0;
      for (std::size_t i = 0; i < reference.nees.t.size(); ++i)
        if (evaluation.span.contains(reference.nees.t[i], engine_.status().start)) {
          sum += reference.nees.values[i];
          ++n;
        }
      if (n > 0)
        consistency[reference.name] = {{"nees_mean", sum / static_cast<double>(n)},
                                       {"dof", reference.block->active.size()},
                                       {"n", n}};
    }
    if (!consistency.empty()) summary["consistency"] = consistency;
    nlohmann::ordered_json noise = nlohmann::ordered_json::object();
    for (const auto& group : noise_) {
      auto value = statistics(group.series, evaluation.span, engine_.status().start);
      if (!value.is_null()) noise[group.series.name] = std::move(value);
    }
    if (!noise.empty()) summary["noise"] = noise;
    return summary;
  }

  /// All series that stand under "reference", once per name: channels first, then what was withheld.
  std::vector<const Series*> reference_series() const {
    std::vector<const Series*> all;
    std::set<std::string> names;
    const auto add = [&](const std::vector<Series>& list) {
      for (const auto& series : list)
        if (names.insert(series.name).second) all.push_back(&series);
    };
    for (const auto& reference : references_) add(reference.series);
    for (const auto& group : withheld_)
      if (scored_measurements_.contains(group.measurement)) add(group.series);
    return all;
  }
  Time start() const { return engine_.status().start; }

  std::vector<Scored> scored() const {
    std::vector<Scored> all;
    for (std::size_t i = 0; i < subjects_.size(); ++i) {
      const auto& subject = subjects_[i];
      Scored entry{subject.series->name,
                   subject.series->unit,
                   subject.series->display_unit,
                   static_cast<int>(i),
                   false,
                   subject.reference >= 0,
                   false};
      entry.has_nees = entry.has_sigma && is_component(subject);
      if (entry.display_unit.empty()) entry.display_unit = entry.unit;
      all.push_back(std::move(entry));
    }
    for (std::size_t r = 0; r < references_.size(); ++r)
      if (references_[r].is_whole)
        all.push_back({references_[r].name, "1", "1", static_cast<int>(r), true, false, true});
    return all;
  }

  std::vector<RecordColumn> implied_state_columns() const {
    std::vector<RecordColumn> columns;
    for (const auto& implied_state : implied_states_) {
      const auto& value = implied_state.plan().value;
      for (const char* suffix : {"", ".sigma"})
        for (const auto& output : value.declaration().outputs)
          columns.push_back({value.name + "." + output.name + suffix, output.unit});
    }
    return columns;
  }
  void latest_implied_states(Time t, double* values) {
    for (auto& implied_state : implied_states_) {
      const auto& value = implied_state.plan().value;
      const auto count = value.declaration().outputs.size();
      if (implied_state.t() == t) {
        std::vector<double> scratch(output_sigma_scratch(value));
        value.block->read(implied_state.value(), values);
        output_sigmas(value, implied_state.value(), implied_state.covariance(), scratch.data(), values + count);
      } else {
        std::fill_n(values, 2 * count, not_a_number);
      }
      values += 2 * count;
    }
  }

  std::vector<RecordColumn> noise_columns() const {
    std::vector<RecordColumn> columns;
    for (const auto& group : noise_) columns.push_back({group.series.name, group.series.unit});
    return columns;
  }
  void latest_noise(double* values) const {
    for (const auto& group : noise_)
      *values++ = group.series.values.empty() ? not_a_number : group.series.values.back();
  }

  void watch(const Metric& metric) {
    if (metric.quantity == MetricQuantity::error || metric.quantity == MetricQuantity::nis || metric.of_block) return;
    keep_sigmas(references_[as_size(subjects_[as_size(metric.subject)].reference)]);
  }
  void keep_sigmas() {
    for (auto& reference : references_) keep_sigmas(reference);
  }

  void tell_errors(int filter, RunObserver& observer) const {
    for (const auto& subject : subjects_) {
      const auto& series = *subject.series;
      std::span<const double> sigma;
      if (subject.reference >= 0 && !references_[as_size(subject.reference)].sigmas.empty())
        sigma = references_[as_size(subject.reference)].sigmas[as_size(subject.index)];
      observer.scored(filter, {series.name, series.unit, series.display_unit, series.t, series.values, sigma});
    }
    for (const auto& reference : references_)
      if (reference.is_whole)
        observer.scored(filter, {reference.name + ".nees", "1", "1", reference.nees.t, reference.nees.values, {}});
  }

  MetricValue value(const Metric& metric, const TimeSpan& span) const {
    if (metric.quantity == MetricQuantity::nis) {
      const auto& ledger = engine_.tally(metric.subject);
      const double n = static_cast<double>(ledger.nis_count);
      if (ledger.nis_count == 0) return {not_a_number, 0, 0};
      return {ledger.nis_sum / n, static_cast<double>(ledger.dof_sum) / n, n};
    }
    if (metric.of_block) {
      const auto& reference = references_[as_size(metric.subject)];
      const auto dof = reference.block->active.size();
      return {over_time(reference.nees.t, reference.nees.values, metric, span, start()), static_cast<double>(dof), 1};
    }
    const auto& subject = subjects_[as_size(metric.subject)];
    if (metric.statistic == MetricStatistic::drift && subject.reference >= 0 && is_component(subject) &&
        references_[as_size(subject.reference)].block->declaration().kind == "attitude")
      return {over_time(subject.series->t, with_whole_turns(subject), metric, span, start()), 0, 0};
    if (metric.quantity == MetricQuantity::error)
      return {over_time(subject.series->t, subject.series->values, metric, span, start()), 0, 0};
    auto values = references_[as_size(subject.reference)].sigmas[as_size(subject.index)];
    if (metric.quantity == MetricQuantity::sigma)
      return {over_time(subject.series->t, values, metric, span, start()), 0, 0};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double ratio = subject.series->values[i] / values[i];
      values[i] = ratio * ratio;
    }
    return {over_time(subject.series->t, values, metric, span, start()), 1, 1};
  }

 private:
  struct Reference {
    const ReferencePlan* plan = nullptr;
    const BlockPlan* block = nullptr;  // or the implied state's
    std::string name;                  // of it
    bool is_whole = false;             // all outputs are told: errors by ⊟
    std::vector<Series> series;
    std::vector<int> output_series;  // per output: index in series, −1
    Series nees;
    std::vector<std::vector<double>> sigmas;  // per series, beside its values; empty when nobody asked for them
  };
  /// A series once per name, and where its sigma is to be found.
  struct Subject {
    const Series* series = nullptr;
    int reference = -1;  // −1: withheld
    int index = 0;       // among the reference's series
  };
  struct WithheldGroup {
    int measurement = 0;
    int group = 0;  // of the rows, counted through the parts
    const StateBlockDeclaration* norms = nullptr;
    std::vector<Series> series;
  };
  /// What a noise estimator made of R: the root of its mean diagonal over a group of rows.
  struct NoiseGroup {
    int measurement = 0;
    int group = 0;
    Series series;
  };
  struct Pending {
    int reference = 0;
    Time t = no_time;
    std::vector<double> values;
  };

  void keep_sigmas(Reference& reference) {
    reference.sigmas.resize(reference.series.size());
    std::size_t scratch = sigma_scratch_.size(), widest = sigmas_.size();
    const auto& block = *reference.block;
    scratch = std::max(scratch, output_sigma_scratch(block));
    widest = std::max(widest, block.declaration().outputs.size());
    sigma_scratch_.resize(scratch);
    sigmas_.resize(widest);
  }

  bool is_component(const Subject& subject) const {
    const auto& reference = references_[as_size(subject.reference)];
    return reference.is_whole && subject.index < reference.block->declaration().dof();
  }

  /// The component of an attitude's error with whole turns about its axis added, so that it never jumps by one.
  std::vector<double> with_whole_turns(const Subject& subject) const {
    constexpr double turn = 2 * std::numbers::pi;
    const auto& series = references_[as_size(subject.reference)].series;
    std::vector<double> values = subject.series->values;
    std::array<double, 3> last{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::array<double, 3> now = {series[0].values[i], series[1].values[i], series[2].values[i]};
      const double angle = std::hypot(now[0], now[1], now[2]);
      if (i > 0 && angle > 0) {
        // Of all vectors that are this rotation, now·(1 + 2πk/angle), the one nearest to the last.
        const double along = (last[0] * now[0] + last[1] * now[1] + last[2] * now[2]) / angle;
        const double stretch = (angle + turn * std::round((along - angle) / turn)) / angle;
        for (double& component : now) component *= stretch;
      }
      last = now;
      values[i] = now[as_size(subject.index)];
    }
    return values;
  }

  /// The 1-σ of errors and norms, in the order of push_errors(). The variance of a norm is the sum of its components'.
  static void push_error_sigmas(Reference& reference, const BlockPlan& block, MatrixView P) {
    const auto& declaration = block.declaration();
    std::vector<double> variances(declaration.error.size(), 0.0);
    for (std::size_t a = 0; a < block.active.size(); ++a) {
      const int row = block.first + static_cast<int>(a);
      variances[as_size(block.active[a])] = P(row, row);
    }
    std::size_t index = 0;
    for (const double variance : variances) reference.sigmas[index++].push_back(std::sqrt(variance));
    for (const auto& norm : declaration.norms) {
      double sum = 0;
      for (const int c : norm.components) sum += variances[as_size(c)];
      reference.sigmas[index++].push_back(std::sqrt(sum));
    }
  }

  static std::vector<Series> make_series(const ErrorNames& names) {
    std::vector<Series> series;
    for (std::size_t i = 0; i < names.names.size(); ++i)
      series.push_back({names.names[i], names.units[i], names.display[i], {}, {}});
    return series;
  }

  void add_channel_reference(const ReferencePlan& plan) {
    const auto& block = plan.implied_state < 0 ? plan_.blocks[as_size(plan.block)]
                                               : plan_.implied_states[as_size(plan.implied_state)].value;
    const auto& declaration = block.declaration();
    Reference reference;
    reference.plan = &plan;
    reference.block = &block;
    reference.name = block.name;
    reference.is_whole = std::all_of(plan.fields.begin(), plan.fields.end(), [](int field) { return field >= 0; });
    if (reference.is_whole) reference.series = make_series(ErrorNames(declaration, block.name));
    for (std::size_t i = 0; i < declaration.outputs.size(); ++i) {
      const auto& output = declaration.outputs[i];
      const std::string name = block.name + "." + output.name;
      const bool is_there = std::any_of(reference.series.begin(), reference.series.end(),
                                        [&](const Series& series) { return series.name == name; });
      if (plan.fields[i] < 0 || !output.is_scored || is_there) {
        reference.output_series.push_back(-1);
        continue;
      }
      reference.output_series.push_back(static_cast<int>(reference.series.size()));
      reference.series.push_back(
          {name, output.unit, output.display_unit.empty() ? output.unit : output.display_unit, {}, {}});
    }
    references_.push_back(std::move(reference));
  }

  /// The first row of a group in a sample, and how many there are.
  static std::pair<int, int> rows_of(const UpdateRecord& record, int group) {
    const auto [first, last] = std::equal_range(record.row_groups, record.row_groups + record.rows, group);
    return {static_cast<int>(first - record.row_groups), static_cast<int>(last - first)};
  }

  void add_withheld(int measurement) {
    const MeasurementPlan& plan = plan_.measurements[as_size(measurement)];
    const auto groups = residual_rows_of(plan_, plan);
    for (std::size_t index = 0; index < groups.size(); ++index) {
      const auto& group = groups[index];
      if (group.kind.empty()) continue;
      WithheldGroup entry;
      entry.measurement = measurement;
      entry.group = static_cast<int>(index);
      if (group.like) {
        entry.norms = &group.like->declaration();
        entry.series = make_series(ErrorNames(*entry.norms, group.like->name));
      } else {
        entry.series.push_back({plan.name + "." + group.kind, group.unit, group.unit, {}, {}});
      }
      withheld_.push_back(std::move(entry));
    }
  }

  void add_noise(int measurement) {
    const MeasurementPlan& plan = plan_.measurements[as_size(measurement)];
    const auto groups = residual_rows_of(plan_, plan);
    for (std::size_t index = 0; index < groups.size(); ++index) {
      const auto& group = groups[index];
      if (group.kind.empty()) continue;
      NoiseGroup entry;
      entry.measurement = measurement;
      entry.group = static_cast<int>(index);
      const bool is_shown = group.like && !group.like->declaration().error_display_unit.empty();
      entry.series = {plan.name + (groups.size() > 1 ? "." + group.name : "") + ".noise",
                      group.unit,
                      is_shown ? group.like->declaration().error_display_unit : group.unit,
                      {},
                      {}};
      noise_.push_back(std::move(entry));
    }
  }

  void keep_noise(const UpdateRecord& record) {
    if (!record.R || record.outcome == Outcome::rejected) return;
    for (auto& group : noise_) {
      if (group.measurement != record.measurement) continue;
      const auto [first, rows] = rows_of(record, group.group);
      if (rows < 1) continue;
      double sum = 0;
      for (int i = 0; i < rows; ++i) sum += record.R(first + i, first + i);
      group.series.t.push_back(record.t);
      group.series.values.push_back(std::sqrt(sum / rows));
    }
  }

  static void push(std::vector<Series>& series, std::size_t index, Time t, double value) {
    series[index].t.push_back(t);
    series[index].values.push_back(value);
  }

  static void push_errors(std::vector<Series>& series, const StateBlockDeclaration& declaration, Time t,
                          const double* delta) {
    std::size_t index = 0;
    for (std::size_t c = 0; c < declaration.error.size(); ++c) push(series, index++, t, delta[c]);
    for (const auto& norm : declaration.norms) {
      double squares = 0;
      for (const int c : norm.components) squares += delta[c] * delta[c];
      push(series, index++, t, std::sqrt(squares));
    }
  }

  void score(const Pending& pending, const double* state) {
    const auto& block = *references_[as_size(pending.reference)].block;
    score_block(pending, state + block.stored_offset, engine_.covariance());
  }

  /// An implied state is of its instant: only a reference of that very time tells whether it is right.
  void score_implied_state(int index) {
    auto& implied_state = implied_states_[as_size(index)];
    std::erase_if(pending_of_implied_states_, [&](const Pending& pending) {
      if (references_[as_size(pending.reference)].plan->implied_state != index) return false;
      if (pending.t == implied_state.t()) score_block(pending, implied_state.value(), implied_state.covariance());
      return pending.t <= implied_state.t();
    });
  }

  /// P: a posteriori at the last update before the reference, or at its very time.
  void score_block(const Pending& pending, const double* estimate, MatrixView P) {
    auto& reference = references_[as_size(pending.reference)];
    const auto& block = *reference.block;
    const auto& declaration = block.declaration();
    if (reference.is_whole) {
      if (!block.block->write(pending.values.data(), truth_.data())) return;
      block.block->minus(truth_.data(), estimate, delta_.data());
      push_errors(reference.series, declaration, pending.t, delta_.data());
      if (!reference.sigmas.empty()) push_error_sigmas(reference, block, P);
      score_consistency(reference, block, pending.t, P);
    }
    block.block->read(estimate, outputs_.data());
    if (!reference.sigmas.empty()) output_sigmas(block, estimate, P, sigma_scratch_.data(), sigmas_.data());
    for (std::size_t i = 0; i < declaration.outputs.size(); ++i) {
      if (reference.output_series[i] < 0) continue;
      double difference = pending.values[i] - outputs_[i];
      if (declaration.outputs[i].is_angle) difference = std::remainder(difference, 2 * std::numbers::pi);
      push(reference.series, as_size(reference.output_series[i]), pending.t, difference);
      if (!reference.sigmas.empty()) reference.sigmas[as_size(reference.output_series[i])].push_back(sigmas_[i]);
    }
  }

  /// NEES of the active components: δᵀ P⁻¹ δ by Cholesky; left out where P is singular.
  void score_consistency(Reference& reference, const BlockPlan& block, Time t, MatrixView P) {
    const int n = static_cast<int>(block.active.size());
    if (n == 0) return;
    double* const L = covariance_.data();
    double* const y = L + n * n;
    double nees = 0;
    for (int j = 0; j < n; ++j) {
      for (int i = j; i < n; ++i) {
        double sum = P(block.first + i, block.first + j);
        for (int k = 0; k < j; ++k) sum -= L[i + k * n] * L[j + k * n];
        if (i == j) {
          if (!(sum > 0)) return;
          L[i + j * n] = std::sqrt(sum);
        } else {
          L[i + j * n] = sum / L[j + j * n];
        }
      }
    }
    for (int i = 0; i < n; ++i) {
      double sum = delta_[as_size(block.active[as_size(i)])];
      for (int k = 0; k < i; ++k) sum -= L[i + k * n] * y[k];
      y[i] = sum / L[i + i * n];
      nees += y[i] * y[i];
    }
    reference.nees.t.push_back(t);
    reference.nees.values.push_back(nees);
  }

  nlohmann::ordered_json figures(const TimeSpan& span) const {
    nlohmann::ordered_json figures = nlohmann::ordered_json::object();
    for (const Series* series : reference_series()) {
      auto value = statistics(*series, span, start());
      if (!value.is_null()) figures[series->name] = std::move(value);
    }
    return figures;
  }

  Engine& engine_;
  const FilterPlan& plan_;
  StepObserver* next_;
  std::vector<Reference> references_;
  std::vector<WithheldGroup> withheld_;
  std::vector<NoiseGroup> noise_;
  std::set<int> scored_measurements_;
  std::vector<Pending> pending_, pending_of_implied_states_;
  std::vector<ImpliedState> implied_states_;
  std::vector<Subject> subjects_;
  std::vector<double> delta_, between_, truth_, outputs_, covariance_, sigma_scratch_, sigmas_;
};

Evaluator::Evaluator(Runtime& runtime, const std::vector<StepObserver*>& observers) : runtime_(runtime) {
  std::set<int> channels;
  for (const auto& reference : runtime.plan().evaluation.references)
    if (reference.channel >= 0) channels.insert(reference.channel);
  for (std::size_t f = 0; f < runtime.plan().filters.size(); ++f)
    scores_.push_back(
        std::make_unique<FilterScore>(runtime, static_cast<int>(f), f < observers.size() ? observers[f] : nullptr));
  runtime_.listen(this, {channels.begin(), channels.end()});
}

Evaluator::~Evaluator() { runtime_.listen(nullptr, {}); }

void Evaluator::sampled(int channel, const SampleView& sample) {
  for (auto& score : scores_) score->reference(channel, sample);
}

void Evaluator::finish() {
  for (auto& score : scores_) score->finish();
}

nlohmann::ordered_json Evaluator::filter_summary(int filter) const {
  return scores_[as_size(filter)]->summary(runtime_.plan().evaluation, filter);
}

std::vector<RecordColumn> Evaluator::noise_columns(int filter) const {
  return scores_[as_size(filter)]->noise_columns();
}

std::vector<RecordColumn> Evaluator::implied_state_columns(int filter) const {
  return scores_[as_size(filter)]->implied_state_columns();
}

void Evaluator::latest_implied_states(int filter, Time t, double* values) const {
  scores_[as_size(filter)]->latest_implied_states(t, values);
}

void Evaluator::latest_noise(int filter, double* values) const { scores_[as_size(filter)]->latest_noise(values); }

std::vector<Scored> Evaluator::scored(int filter) const { return scores_[as_size(filter)]->scored(); }

void Evaluator::keep_sigmas() {
  for (auto& score : scores_) score->keep_sigmas();
}

void Evaluator::tell_errors(RunObserver& observer) const {
  for (std::size_t f = 0; f < scores_.size(); ++f) scores_[f]->tell_errors(static_cast<int>(f), observer);
}

void Evaluator::watch(const std::vector<Metric>& metrics) {
  for (const auto& metric : metrics) scores_[as_size(metric.filter)]->watch(metric);
}

MetricValue Evaluator::value(const Metric& metric) const {
  return scores_[as_size(metric.filter)]->value(metric, runtime_.plan().evaluation.span);
}

nlohmann::ordered_json Evaluator::across_windows() const {
  const auto& evaluation = runtime_.plan().evaluation;
  std::map<std::string, std::map<std::string, std::vector<double>>> collected;
  std::vector<std::string> order;
  std::map<std::string, std::string> units;
  for (std::size_t f = 0; f < scores_.size(); ++f)
    for (const auto& window : evaluation.windows) {
      if (window.filter >= 0 && window.filter != static_cast<int>(f)) continue;
      for (const Series* series : scores_[f]->reference_series()) {
        const auto value = statistics(*series, window.span, scores_[f]->start());
        if (value.is_null()) continue;
        if (!collected.contains(series->name)) order.push_back(series->name);
        units[series->name] = value["unit"];
        for (const char* key : {"rms", "max", "final"})
          collected[series->name][key].push_back(std::abs(value[key].get<double>()));
      }
    }
  nlohmann::ordered_json across = nlohmann::ordered_json::object();
  for (const auto& name : order) {
    nlohmann::ordered_json entry = nlohmann::ordered_json::object();
    for (auto& [key, values] : collected[name]) {
      std::sort(values.begin(), values.end());
      double sum = 0;
      for (const double value : values) sum += value;
      entry[key] = {{"mean", sum / static_cast<double>(values.size())},
                    {"p50", quantile(values, 0.5)},
                    {"max", values.back()}};
      entry["n"] = values.size();
    }
    entry["unit"] = units[name];
    across[name] = std::move(entry);
  }
  return across;
}

}  // namespace binnacle
