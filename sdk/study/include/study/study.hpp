// SPDX-License-Identifier: Apache-2.0
// Study: variants of one config, each run many times, and what is to be reported of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/config.hpp"
#include "binnacle/trust.hpp"
#include "score/metric.hpp"
#include "study/statistics.hpp"
#include "study/variants.hpp"

namespace binnacle::score {
struct RunOutcome;
}

namespace binnacle::study {

struct Variant {
  std::string name;
  std::vector<std::string> patches;
  std::shared_ptr<const Composition> composition;
  std::vector<score::Metric> metrics;  // those of the study that it has
  std::vector<int> position;           // per metric of the study: in `metrics`, −1
};

struct StudyMetric {
  std::string name;
  std::string unit;  // for display
  std::string si_unit;
  bool is_chi_squared = false;
};

/// `value`: the statistic; `improvement`: by how many percent it lies below the baseline's; `ratio`: over it.
enum class Show { value, improvement, ratio };

struct Cell {
  int variant = -1;  // −1: an empty cell
  int baseline = -1;
  int metric = 0;
  OverRuns statistic = OverRuns::rms;
  Show show = Show::value;
  bool is_reversed = false;  // estimate minus truth
  std::string unit;          // "%" of an improvement; "" of an empty cell
  std::string text;          // printed instead of a figure: "aliased"
};

struct TablePlan {
  std::string title;
  std::vector<std::string> rows, columns;
  std::vector<std::vector<Cell>> cells;
  std::vector<std::vector<double>> paper;  // empty, or like cells; NaN where the paper has none
  bool shows_errors = true;
};

/// What came of one run: the unit of work, made anywhere and put together in order.
struct Figures {
  enum class State { open, finished, failed } state = State::open;
  std::vector<score::MetricValue> values;  // per metric of the study, NaN where the variant does not have it
  std::string failure;                     // one line
  Verdict verdict = Verdict::ok;           // of a finished run
};

/// By (variant, run).
class Results {
 public:
  Results(std::size_t variants, std::size_t runs) : runs_(runs), figures_(variants * runs) {}
  std::size_t runs() const { return runs_; }
  Figures& at(std::size_t variant, std::size_t run) { return figures_[variant * runs_ + run]; }
  const Figures& at(std::size_t variant, std::size_t run) const { return figures_[variant * runs_ + run]; }
  /// The metric's values of all finished runs, in the order of the runs [SI].
  std::vector<double> values(std::size_t variant, std::size_t metric) const;

 private:
  std::size_t runs_;
  std::vector<Figures> figures_;
};

/// What a metric's name means to a composition, or one line that says why nothing.
using MetricReading = std::function<Parsed<score::Metric>(const Composition&, std::string_view)>;

struct StudyOptions {
  LoadOptions load;
  std::optional<int> runs;  // instead of the config's
  std::optional<std::uint64_t> seed;
  std::string section = "/study";  // where metrics and tables stand; variants are always those of "study"
  MetricReading read_metric = [](const Composition& composition, std::string_view text) {
    return score::read_metric(composition, text);
  };
};

/// Something that the figures of a run depend on.
struct Making {
  std::string what;
  std::uint64_t hash = 0;
};

/// Immutable; share it between threads.
class Study {
 public:
  /// Everything that is wrong with any variant, metric or table is reported at once. Throws as Composition::load does.
  static Study load(const std::filesystem::path& config, const StudyOptions& options = {});
  /// Whether the config has a "study" at all.
  static bool is_in(const Config& config);

  const std::string& title() const { return title_; }
  int runs() const { return runs_; }
  std::uint64_t seed() const { return seed_; }
  const std::vector<Variant>& variants() const { return variants_; }
  const std::vector<StudyMetric>& metrics() const { return metrics_; }
  const std::vector<TablePlan>& tables() const { return tables_; }
  const Diagnostics& warnings() const { return warnings_; }
  /// Of everything that the figures of a run depend on: compositions, metrics, seed, this program and the plugins.
  std::uint64_t hash() const { return hash_; }
  /// The same by what it is of: "program", "plugin 'csv'", "seed", "config".
  const std::vector<Making>& makings() const { return makings_; }

  /// All variants, those together whose runs draw the same samples: sources of the same types at the same places of the
  /// config, with the same parameters as resolved. The largest first.
  const std::vector<std::vector<std::size_t>>& groups() const { return groups_; }

  /// Runs variants of one group once, side by side over the same samples; in their order, and to the bit as each alone.
  /// `goes_on` is asked now and then; once it says false, the figures stay open. What breaks is listed in the figures of
  /// that variant, never thrown.
  std::vector<Figures> carry_out(const std::vector<std::size_t>& variants, int run,
                                 const std::function<bool()>& goes_on) const;

 private:
  void note_makings();
  void share();
  Figures figures_of(const Variant& variant, const score::RunOutcome& outcome) const;

  std::string title_;
  int runs_ = 1;
  std::uint64_t seed_ = 1;
  std::vector<Variant> variants_;
  std::vector<std::vector<std::size_t>> groups_;
  std::vector<StudyMetric> metrics_;
  std::vector<TablePlan> tables_;
  Diagnostics warnings_;
  std::vector<Making> makings_;
  std::uint64_t hash_ = 0;
};

}  // namespace binnacle::study
