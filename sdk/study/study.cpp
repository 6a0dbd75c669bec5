// SPDX-License-Identifier: Apache-2.0
#include "study/study.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <exception>
#include <fstream>

#include "binnacle/catalog.hpp"
#include "score/run.hpp"
#include "score/sections.hpp"
#include "study/section.hpp"
#include "tables.hpp"
#include "wording/checksum.hpp"
#include "wording/wording.hpp"

namespace binnacle::study {

using namespace wording;

namespace {

class Hash : public wording::Checksum {
 public:
  using Checksum::add;
  void add(const std::string& text) { add(text.c_str(), text.size() + 1); }
  void add(std::uint64_t number) { add(&number, sizeof(number)); }
  /// A rebuilt program or plugin may give other figures under the same version.
  void add_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::vector<char> buffer(1 << 16);
    while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || file.gcount() > 0)
      add(buffer.data(), static_cast<std::size_t>(file.gcount()));
  }
};

/// What several variants say alike is reported once; what only some say, with their names.
class Gathered {
 public:
  void add(const std::string& variant, const Diagnostics& diagnostics) {
    for (const auto& item : diagnostics.items()) {
      const auto found =
          std::find_if(items_.begin(), items_.end(), [&](const auto& known) { return known.first == item; });
      if (found == items_.end())
        items_.push_back({item, {variant}});
      else
        found->second.push_back(variant);
    }
  }
  Diagnostics merged(std::size_t variants) const {
    Diagnostics diagnostics;
    for (auto [item, names] : items_) {
      if (names.size() < variants) {
        const std::size_t shown = std::min<std::size_t>(names.size(), 3);
        std::string list;
        for (std::size_t i = 0; i < shown; ++i) list += (i ? ", " : "") + in_quotes(names[i]);
        if (names.size() > shown) list += " and " + std::to_string(names.size() - shown) + " more";
        item.message += (names.size() == 1 ? " (variant " : " (variants ") + list + ")";
      }
      diagnostics.add(std::move(item));
    }
    return diagnostics;
  }

 private:
  std::vector<std::pair<Diagnostic, std::vector<std::string>>> items_;
};

/// The heaviest of what the variants threw.
class Failure {
 public:
  void add(const Error& error) {
    const auto weight = [](int status) { return status == 4 ? 3 : status == 3 ? 2 : 1; };
    if (weight(error.exit_status()) > weight(status_) || status_ == 0) status_ = error.exit_status();
  }
  int status() const { return status_; }

 private:
  int status_ = 0;
};

std::vector<Variant> load_variants(const std::filesystem::path& path, const LoadOptions& options,
                                   const std::vector<VariantPatches>& wanted, Diagnostics& warnings) {
  std::vector<Variant> variants;
  Gathered errors, notes;
  Failure failure;
  for (const auto& entry : wanted) {
    LoadOptions load = options;
    load.patches = entry.patches;
    try {
      Variant variant{entry.name, entry.patches, score::load(path, load), {}, {}};
      notes.add(entry.name, variant.composition->warnings());
      variants.push_back(std::move(variant));
    } catch (const Error& error) {
      errors.add(entry.name, error.diagnostics());
      failure.add(error);
    }
  }
  if (failure.status()) throw Error(failure.status(), errors.merged(wanted.size()));
  std::vector<std::shared_ptr<const Composition>> compositions;
  for (const auto& variant : variants) compositions.push_back(variant.composition);
  for (const auto& variant : variants) {
    LoadOptions load = options;
    load.patches = variant.patches;
    const Diagnostics misspelt = misspelt_metrics(*variant.composition, compositions, path, load);
    if (!misspelt.has_errors()) continue;
    errors.add(variant.name, misspelt);
    failure.add(ConfigError(misspelt));
  }
  if (failure.status()) throw Error(failure.status(), errors.merged(wanted.size()));
  warnings.merge(notes.merged(wanted.size()));
  return variants;
}

/// The list of metrics and those that only tables name.
class MetricReader {
 public:
  MetricReader(const Section& section, const MetricReading& reading, std::vector<Variant>& variants)
      : section_(section), reading_(reading), variants_(variants) {}

  void read_list(const std::string& pointer) {
    const Json* list = section_.at(pointer);
    if (!list) return;
    if (!list->is_array()) return read_entry(pointer);
    for (std::size_t i = 0; i < list->size(); ++i) read_entry(join_pointer(pointer, i));
  }

  void read_name(const std::string& pointer) {
    if (const auto name = section_.text(pointer)) add(pointer, *name, "");
  }

  std::vector<StudyMetric> take() { return std::move(metrics_); }

 private:
  void read_entry(const std::string& pointer) {
    if (!section_.at(pointer)->is_object()) return read_name(pointer);
    section_.check_keys(pointer, {"metric", "unit"}, "a metric");
    const auto name = section_.text(join_pointer(pointer, "metric"));
    if (!name)
      section_.error("B010", pointer, "missing key 'metric': FILTER/BLOCK.OUTPUT/STATISTIC");
    else
      add(join_pointer(pointer, "metric"), *name, join_pointer(pointer, "unit"));
  }

  void add(const std::string& pointer, const std::string& name, const std::string& unit_pointer) {
    const auto is_it = [&](const StudyMetric& known) { return known.name == name; };
    if (std::any_of(metrics_.begin(), metrics_.end(), is_it)) return;
    std::string unit, wrong;
    if (!unit_pointer.empty()) unit = section_.text(unit_pointer).value_or("");
    StudyMetric entry{name, "", "", false};
    bool is_known = false;
    std::vector<int> positions;
    for (auto& variant : variants_) {
      auto metric = reading_(*variant.composition, name);
      positions.push_back(metric ? static_cast<int>(variant.metrics.size()) : -1);
      if (!metric) {
        if (wrong.empty()) wrong = metric.error();
        continue;
      }
      score::Metric shown = *metric;
      std::string misfit = unit.empty() ? "" : show_in(shown, unit);
      if (!misfit.empty() && !is_known) section_.error(parse_unit(unit) ? "B007" : "B008", unit_pointer, misfit);
      is_known = true;
      entry.unit = shown.unit;
      entry.si_unit = shown.si_unit;
      entry.is_chi_squared =
          shown.quantity == score::MetricQuantity::nees || shown.quantity == score::MetricQuantity::nis;
      variant.metrics.push_back(std::move(shown));
    }
    if (!is_known) return section_.error("B027", pointer, wrong);
    for (std::size_t v = 0; v < variants_.size(); ++v) variants_[v].position.push_back(positions[v]);
    metrics_.push_back(std::move(entry));
  }

  const Section& section_;
  const MetricReading& reading_;
  std::vector<Variant>& variants_;
  std::vector<StudyMetric> metrics_;
};

/// The variant's config without the sections that change no figure of a run.
std::string what_is_measured(Json config) {
  config.erase("study");
  config.erase("covariance");
  return config.dump();
}

class StopWatch : public score::RunObserver {
 public:
  explicit StopWatch(const std::function<bool()>& goes_on) : goes_on_(goes_on) {}
  bool wants_records() const override { return false; }
  bool progress(Time) override { return is_going_ = goes_on_(); }
  bool is_going() const { return is_going_; }

 private:
  const std::function<bool()>& goes_on_;
  bool is_going_ = true;
};

}  // namespace

std::vector<double> Results::values(std::size_t variant, std::size_t metric) const {
  std::vector<double> values;
  for (std::size_t run = 0; run < runs_; ++run) {
    const auto& figures = at(variant, run);
    if (figures.state == Figures::State::finished && !std::isnan(figures.values[metric].value))
      values.push_back(figures.values[metric].value);
  }
  return values;
}

bool Study::is_in(const Config& config) { return config.contains("/study"); }

Study Study::load(const std::filesystem::path& path, const StudyOptions& options) {
  const Config config = score::load_config(path, options.load);
  Diagnostics diagnostics;
  const Section section(config, diagnostics);
  Study study;
  if (section.object("/study"))
    section.check_keys("/study", {"runs", "seed", "dimensions", "variants", "metrics", "table", "tables"}, "'study'");
  const auto wanted = variants_of(config, diagnostics);
  study.runs_ = options.runs.value_or(static_cast<int>(section.whole_number("/study/runs", 1).value_or(1)));
  study.seed_ = options.seed.value_or(static_cast<std::uint64_t>(section.whole_number("/study/seed", 0).value_or(1)));
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
  study.variants_ = load_variants(path, options.load, wanted, study.warnings_);
  study.title_ = study.variants_.front().composition->title();

  MetricReader metrics(section, options.read_metric, study.variants_);
  for (const std::string& place :
       {options.section + "/metrics", std::string("/evaluate/metrics"), std::string("/metrics")})
    if (section.at(place)) {
      metrics.read_list(place);
      break;
    }
  const auto tables = table_pointers(section, options.section);
  for (const auto& table : tables)
    for (const auto& pointer : table_metric_pointers(section, table)) metrics.read_name(pointer);
  study.metrics_ = metrics.take();
  if (study.metrics_.empty() && !diagnostics.has_errors())
    section.key_error("B010", options.section,
                      "missing key 'metrics': what a study reports, \"FILTER/BLOCK.OUTPUT/STATISTIC\"");
  std::vector<std::string> names;
  for (const auto& variant : study.variants_) names.push_back(variant.name);
  for (const auto& table : tables) study.tables_.push_back(read_table(section, table, names, study.metrics_));
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);

  study.note_makings();
  study.share();
  return study;
}

void Study::note_makings() {
  const auto note = [this](const std::string& what, const auto& add) {
    Hash hash;
    add(hash);
    makings_.push_back({what, hash.value()});
  };
  note("program", [](Hash& hash) { hash.add_file("/proc/self/exe"); });
  for (const auto& plugin : variants_.front().composition->catalog().plugins())
    note("plugin " + in_quotes(plugin.name), [&plugin](Hash& hash) {
      if (plugin.file.empty())
        hash.add(plugin.version);
      else
        hash.add_file(plugin.file);
    });
  note("seed", [this](Hash& hash) { hash.add(seed_); });
  note("config", [this](Hash& hash) {
    for (const auto& variant : variants_) {
      hash.add(variant.name);
      hash.add(variant.composition->hash());
      hash.add(what_is_measured(Json::parse(variant.composition->config())));
    }
    for (const auto& metric : metrics_) hash.add(metric.name);
  });
  Hash all;
  for (const auto& making : makings_) all.add(making.hash);
  hash_ = all.value();
}

void Study::share() {
  std::vector<std::shared_ptr<const Composition>> compositions;
  for (const auto& variant : variants_) compositions.push_back(variant.composition);
  share_sources(compositions);
  for (std::size_t v = 0; v < compositions.size(); ++v) {
    const auto draws_the_same = [&](const std::vector<std::size_t>& group) {
      const Composition& other = *compositions[group.front()];
      return score::can_run_together(other) && score::can_run_together(*compositions[v]) &&
             have_same_sources(other, *compositions[v]);
    };
    const auto group = std::ranges::find_if(groups_, draws_the_same);
    if (group == groups_.end())
      groups_.push_back({v});
    else
      group->push_back(v);
  }
  std::ranges::stable_sort(groups_, std::greater<>(), &std::vector<std::size_t>::size);
}

namespace {

/// One line.
std::string what_was_thrown(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    const auto items = error.diagnostics().sorted();
    return items.empty() ? error.what() : items.front().message;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "a plugin threw what is no exception of the standard library";
  }
}

/// Alone, as any variant may be run.
score::RunOutcome run_alone(const score::RunRequest& request) {
  score::RunOutcome outcome;
  try {
    outcome.result = score::run(request.composition, request.options);
  } catch (...) {
    outcome.thrown = std::current_exception();
  }
  return outcome;
}

}  // namespace

Figures Study::figures_of(const Variant& variant, const score::RunOutcome& outcome) const {
  Figures figures;
  const auto broke = [&figures](const std::string& why) {
    figures.state = Figures::State::failed;
    figures.failure = why;
    figures.values.clear();
    return figures;
  };
  if (outcome.thrown) return broke(what_was_thrown(outcome.thrown));
  const auto& result = outcome.result;
  if (!result.failures.empty()) return broke(result.failures.items().front().message);
  for (std::size_t i = 0; i < metrics_.size(); ++i) {
    const int position = variant.position[i];
    figures.values.push_back(position < 0 ? score::MetricValue{std::nan(""), 0, 0}
                                          : result.metrics[static_cast<std::size_t>(position)]);
    if (position >= 0 && !std::isfinite(figures.values.back().value))
      return broke("there is nothing to make metric " + in_quotes(metrics_[i].name) + " of");
  }
  figures.state = Figures::State::finished;
  figures.verdict = result.verdict;
  return figures;
}

std::vector<Figures> Study::carry_out(const std::vector<std::size_t>& variants, int run,
                                      const std::function<bool()>& goes_on) const {
  std::deque<StopWatch> watches;
  std::vector<score::RunRequest> requests;
  for (const std::size_t index : variants) {
    const Variant& variant = variants_[index];
    auto& request = requests.emplace_back();
    request.composition = variant.composition;
    request.options.seed = seed_;
    request.options.run = run;
    request.options.observer = &watches.emplace_back(goes_on);
    request.options.metrics = variant.metrics;
    request.options.feeds_sinks = false;
    request.options.wants_summary = false;
  }
  const auto outcomes = requests.size() == 1 ? std::vector{run_alone(requests.front())} : score::run_together(requests);
  std::vector<Figures> all;
  for (std::size_t i = 0; i < variants.size(); ++i)
    all.push_back(watches[i].is_going() || outcomes[i].thrown ? figures_of(variants_[variants[i]], outcomes[i])
                                                              : Figures());
  return all;
}

}  // namespace binnacle::study
