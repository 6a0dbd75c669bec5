// SPDX-License-Identifier: Apache-2.0
#include "run/evaluator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "binnacle/unit.hpp"

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

/// Follows one filter. A reference between two steps is compared with the estimate interpolated on the manifold from
/// the a-posteriori state at the step's begin to the a-priori one at its end, so that scoring never changes the run.
class Evaluator::FilterScore : public StepTape {
 public:
  FilterScore(Runtime& runtime, int filter) : engine_(runtime.engine(filter)), plan_(engine_.plan()) {
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
    for (const auto& reference : references) {
      if (reference.filter != filter) continue;
      if (reference.block >= 0)
        add_channel_reference(reference);
      else
        scored_measurements_.insert(reference.measurement);
    }
    for (std::size_t m = 0; m < plan_.measurements.size(); ++m) add_withheld(static_cast<int>(m));
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
      // The filter may have passed this instant already: then only an estimate at that very time will do.
      if (sample.t == engine_.status().t && plan_.input_channel < 0) {
        score(pending, engine_.state());
        continue;
      }
      pending_.push_back(pending);
    }
  }

  bool wants_covariance() const override { return !pending_.empty(); }

  void stepped(const StepRecord& record) override {
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
    if (record.outcome != Outcome::withheld) return;
    for (auto& group : withheld_) {
      if (group.measurement != record.measurement) continue;
      const int rows = std::min(group.rows == 0 ? record.rows : group.rows, record.rows - group.first_row);
      if (rows < 1 || (group.norms && rows < group.norms->dof())) continue;
      if (!group.norms) {
        double squares = 0;
        for (int i = 0; i < rows; ++i) squares += record.residual[group.first_row + i] * record.residual[group.first_row + i];
        push(group.series, 0, record.t, std::sqrt(squares / std::max(1, rows)));
        continue;
      }
      push_errors(group.series, *group.norms, record.t, record.residual + group.first_row);
    }
  }

  void finish() {
    for (const auto& pending : pending_)
      if (pending.t == engine_.status().t) score(pending, engine_.state());
    pending_.clear();
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
                                       {"dof", plan_.blocks[as_size(reference.plan->block)].active.size()},
                                       {"n", n}};
    }
    if (!consistency.empty()) summary["consistency"] = consistency;
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

 private:
  struct Reference {
    const ReferencePlan* plan = nullptr;
    std::string name;              // of the block
    bool is_whole = false;         // all outputs are told: errors by ⊟
    std::vector<Series> series;
    std::vector<int> output_series;  // per output: index in series, −1
    Series nees;
  };
  struct WithheldGroup {
    int measurement = 0;
    int first_row = 0;
    int rows = 0;
    const StateBlockDeclaration* norms = nullptr;
    std::vector<Series> series;
  };
  struct Pending {
    int reference = 0;
    Time t = no_time;
    std::vector<double> values;
  };

  static std::vector<Series> make_series(const ErrorNames& names) {
    std::vector<Series> series;
    for (std::size_t i = 0; i < names.names.size(); ++i)
      series.push_back({names.names[i], names.units[i], names.display[i], {}, {}});
    return series;
  }

  void add_channel_reference(const ReferencePlan& plan) {
    const auto& block = plan_.blocks[as_size(plan.block)];
    const auto& declaration = block.declaration();
    Reference reference;
    reference.plan = &plan;
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
      reference.series.push_back({name, output.unit, output.display_unit.empty() ? output.unit : output.display_unit,
                                  {}, {}});
    }
    references_.push_back(std::move(reference));
  }

  void add_withheld(int measurement) {
    int first_row = 0;
    for (const auto& part : plan_.measurements[as_size(measurement)].parts) {
      for (const auto& group : part.model->declaration().groups) {
        WithheldGroup entry;
        entry.measurement = measurement;
        entry.first_row = first_row + group.first_row;
        entry.rows = group.rows;
        const BlockPlan* block = group.port >= 0 ? block_like(part.ports[as_size(group.port)]) : nullptr;
        if (block) {
          entry.norms = &block->declaration();
          entry.series = make_series(ErrorNames(block->declaration(), block->name));
        } else {
          const std::string name = plan_.measurements[as_size(measurement)].name + "." + group.name;
          entry.series.push_back({name, group.unit, group.unit, {}, {}});
        }
        withheld_.push_back(std::move(entry));
      }
      first_row += part.model->declaration().max_rows;
    }
  }

  /// The block itself, or for a derived value the block of the filter with the same error components.
  const BlockPlan* block_like(int value) const {
    if (value < 0) return nullptr;
    if (value < static_cast<int>(plan_.blocks.size())) return &plan_.blocks[as_size(value)];
    const auto& kind = plan_.derived[as_size(value) - plan_.blocks.size()].derived->declaration().kind;
    for (const auto& block : plan_.blocks)
      if (block.declaration().kind == kind) return &block;
    return nullptr;
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
    const auto& block = plan_.blocks[as_size(references_[as_size(pending.reference)].plan->block)];
    score_block(pending, state + block.stored_offset, engine_.covariance());
  }

  /// P: a posteriori at the last update before the reference, or at its very time.
  void score_block(const Pending& pending, const double* estimate, MatrixView P) {
    auto& reference = references_[as_size(pending.reference)];
    const auto& block = plan_.blocks[as_size(reference.plan->block)];
    const auto& declaration = block.declaration();
    if (reference.is_whole) {
      if (!block.block->write(pending.values.data(), truth_.data())) return;
      block.block->minus(truth_.data(), estimate, delta_.data());
      push_errors(reference.series, declaration, pending.t, delta_.data());
      score_consistency(reference, block, pending.t, P);
    }
    block.block->read(estimate, outputs_.data());
    for (std::size_t i = 0; i < declaration.outputs.size(); ++i) {
      if (reference.output_series[i] < 0) continue;
      double difference = pending.values[i] - outputs_[i];
      if (declaration.outputs[i].is_angle) difference = std::remainder(difference, 2 * std::numbers::pi);
      push(reference.series, as_size(reference.output_series[i]), pending.t, difference);
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
  std::vector<Reference> references_;
  std::vector<WithheldGroup> withheld_;
  std::set<int> scored_measurements_;
  std::vector<Pending> pending_;
  std::vector<double> delta_, between_, truth_, outputs_, covariance_;
};

Evaluator::Evaluator(Runtime& runtime) : runtime_(runtime) {
  std::set<int> channels;
  for (const auto& reference : runtime.plan().evaluation.references)
    if (reference.channel >= 0) channels.insert(reference.channel);
  for (std::size_t f = 0; f < runtime.plan().filters.size(); ++f)
    scores_.push_back(std::make_unique<FilterScore>(runtime, static_cast<int>(f)));
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
