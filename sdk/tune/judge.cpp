// SPDX-License-Identifier: Apache-2.0
#include "judge.hpp"

#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Core>

#include "algebra/decompositions.hpp"
#include "binnacle/eigen.hpp"
#include "score/sections.hpp"
#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;

namespace {

class Watch final : public StepObserver {
 public:
  Watch(std::vector<JudgedSample>& samples, const std::optional<When>& until, bool is_after)
      : samples_(samples), until_(until), is_after_(is_after) {}
  void started(Time t, const double*, ConstMatrixView) override { until_.started(t); }
  void offered(const UpdateRecord& record) override {
    const bool is_withheld = record.outcome == Outcome::withheld;
    if (until_.is_over(record.t) != is_after_ || (!is_withheld && record.outcome != Outcome::accepted)) return;
    const auto m = as_size(record.rows);
    const double log_det = algebra::Cholesky(record.S.as()).log_determinant();
    const double size = static_cast<double>(m) * std::log(2 * std::numbers::pi);
    samples_.push_back({record.measurement,
                        record.t,
                        is_withheld,
                        record.nis,
                        -0.5 * (record.nis + log_det + size),
                        {record.row_keys, record.row_keys + m},
                        {record.row_groups, record.row_groups + m},
                        {record.residual, record.residual + m}});
  }

 private:
  std::vector<JudgedSample>& samples_;
  Until until_;
  bool is_after_;
};

/// Sums of one measurement.
struct Sums {
  double nis = 0, rows = 0, withheld_nll = 0, withheld_rows = 0;
  struct Group {
    std::string name, unit;
    double squares = 0, count = 0;
  };
  std::vector<Group> groups;  // of withheld rows
};

using Table = std::map<std::string, Sums>;  // by FILTER/MEASUREMENT

Table table_of(const std::vector<Judgement>& all) {
  Table table;
  for (const Judgement& of_config : all)
    for (std::size_t f = 0; f < of_config.filters.size(); ++f) {
      const FilterInfo& filter = of_config.composition->filters()[f];
      for (const JudgedSample& sample : of_config.filters[f]) {
        const MeasurementInfo& info = filter.measurements[as_size(sample.measurement)];
        Sums& sums = table[filter.name + "/" + info.name];
        const auto rows = static_cast<double>(sample.residual.size());
        if (!sample.is_withheld) {
          sums.nis += sample.nis;
          sums.rows += rows;
          continue;
        }
        sums.withheld_nll -= sample.likelihood;
        sums.withheld_rows += rows;
        sums.groups.resize(info.groups.size());
        for (std::size_t i = 0; i < sample.residual.size(); ++i) {
          Sums::Group& group = sums.groups[as_size(sample.groups[i])];
          group.name = info.groups[as_size(sample.groups[i])].name;
          group.unit = info.groups[as_size(sample.groups[i])].unit;
          group.squares += sample.residual[i] * sample.residual[i];
          group.count += 1;
        }
      }
    }
  return table;
}

Json figures(const Sums& sums) {
  Json json = {{"rows", sums.rows}, {"nis_per_row", sums.rows > 0 ? Json(sums.nis / sums.rows) : Json()}};
  if (sums.withheld_rows == 0) return json;
  json["withheld"] = {{"rows", sums.withheld_rows}, {"nll_per_row", sums.withheld_nll / sums.withheld_rows}};
  for (const auto& group : sums.groups)
    if (group.count > 0)
      json["withheld"]["rms"][group.name] = {{"value", std::sqrt(group.squares / group.count)}, {"unit", group.unit}};
  return json;
}

bool are_alike(const JudgedSample& a, const JudgedSample& b) {
  return a.measurement == b.measurement && a.t == b.t && a.is_withheld == b.is_withheld && a.keys == b.keys &&
         a.groups == b.groups;
}

bool is_before(const JudgedSample& a, const JudgedSample& b) {
  return a.t != b.t ? a.t < b.t : a.measurement < b.measurement;
}

}  // namespace

Judgement judge(const Member& member, const std::vector<std::string>& sets, const std::optional<When>& until,
                bool is_after, const RunSettings& settings) {
  LoadOptions load = member.load;
  load.sets.insert(load.sets.end(), sets.begin(), sets.end());
  Judgement judgement{score::load(member.config, load), {}};
  const std::size_t count = judgement.composition->filters().size();
  judgement.filters.resize(count);
  std::vector<std::unique_ptr<Watch>> watches;
  std::vector<StepObserver*> observers;
  for (std::size_t f = 0; f < count; ++f) {
    watches.push_back(std::make_unique<Watch>(judgement.filters[f], until, is_after));
    observers.push_back(watches.back().get());
  }
  observed_run(judgement.composition, observers, settings);
  return judgement;
}

double withheld_nll(const std::vector<Judgement>& all) {
  double sum = 0, rows = 0;
  for (const auto& [name, sums] : table_of(all)) sum += sums.withheld_nll, rows += sums.withheld_rows;
  return rows > 0 ? sum : std::nan("");
}

double withheld_rms(const std::vector<Judgement>& all) {
  double sum = 0, rows = 0;
  for (const auto& [name, sums] : table_of(all))
    for (const auto& group : sums.groups) {
      if (group.count == 0) continue;
      sum += 0.5 * group.count * std::log(group.squares / group.count);
      rows += group.count;
    }
  return rows > 0 ? sum : std::nan("");
}

Json compared(const std::vector<Judgement>& start, const std::vector<Judgement>& end) {
  double likelihood_start = 0, likelihood_end = 0, rows = 0;
  for (std::size_t m = 0; m < start.size(); ++m)
    for (std::size_t f = 0; f < start[m].filters.size(); ++f) {
      auto a = start[m].filters[f].begin(), b = end[m].filters[f].begin();
      while (a != start[m].filters[f].end() && b != end[m].filters[f].end()) {
        if (is_before(*a, *b)) {
          ++a;
        } else if (is_before(*b, *a)) {
          ++b;
        } else {
          if (are_alike(*a, *b) && !a->is_withheld) {
            likelihood_start += a->likelihood;
            likelihood_end += b->likelihood;
            rows += static_cast<double>(a->residual.size());
          }
          ++a, ++b;
        }
      }
    }
  const Table before = table_of(start), after = table_of(end);
  Json measurements = Json::object();
  double rows_start = 0, rows_end = 0;
  for (const auto& [name, sums] : before) {
    measurements[name]["start"] = figures(sums);
    rows_start += sums.rows;
  }
  for (const auto& [name, sums] : after) {
    measurements[name]["end"] = figures(sums);
    rows_end += sums.rows;
  }
  return {{"likelihood",
           {{"start", likelihood_start},
            {"end", likelihood_end},
            {"rows", rows},
            {"rows_start", rows_start},
            {"rows_end", rows_end}}},
          {"measurements", measurements}};
}

}  // namespace binnacle::tune
