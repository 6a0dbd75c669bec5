// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "binnacle/time.hpp"
#include "binnacle/unit.hpp"
#include "consistency.hpp"
#include "decimation.hpp"
#include "display.hpp"
#include "missing.hpp"
#include "payload.hpp"
#include "score/metric.hpp"

namespace binnacle::report {

namespace {

using results::Error;
using results::Estimate;
using results::FilterResults;
using results::Updates;

using Numbers = std::vector<double>;

constexpr std::size_t most_track_points = 4000;

// ---- small helpers

Numbers picked(const Numbers& values, const std::vector<std::size_t>& indices, double scale = 1) {
  Numbers picked;
  picked.reserve(indices.size());
  for (const auto i : indices) picked.push_back(values[i] / scale);
  return picked;
}

std::pair<std::string, std::string> split_name(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == std::string::npos ? std::pair{std::string(), name}
                                  : std::pair{name.substr(0, dot), name.substr(dot + 1)};
}

bool has_block(const FilterResults& filter, const std::string& name) {
  return std::any_of(filter.estimates.begin(), filter.estimates.end(),
                     [&](const Estimate& estimate) { return estimate.block == name; });
}

// ---- a filter's payload

class FilterPayload {
 public:
  FilterPayload(const FilterResults& filter, const results::RunResults& run, std::size_t points, Extent extent,
                Columns& columns, const std::optional<TrackOrigin>& origin)
      : filter_(filter),
        summary_(at_or_null(at_or_null(run.summary, "filters"), filter.name)),
        config_(run.config),
        points_(points),
        extent_(extent),
        columns_(columns),
        origin_(origin) {}
  FilterPayload(const DrawnFilter& drawn, const results::RunResults& run, std::size_t points, Columns& columns,
                const std::optional<TrackOrigin>& origin)
      : FilterPayload(drawn.series, run, points, Extent::whole, columns, origin) {
    drawn_ = &drawn;
  }

  Json json() {
    Json json{{"name", filter_.name}, {"samples", rows()}};
    json["span"] = span();
    json["windows"] = windows();
    json["blocks"] = blocks();
    json["nees"] = nees();
    json["measurements"] = measurements();
    json["noise"] = adapted_noise();
    if (const auto track = track_of(drawn_ ? drawn_->track : filter_, origin_)) json["track"] = track_json(*track);
    return json;
  }

 private:
  // -- what is said of all, where not all is drawn

  std::size_t rows() const { return drawn_ ? drawn_->rows : filter_.t.size(); }
  const Numbers& times(const Estimate& estimate) const {
    return drawn_ ? drawn_->t[static_cast<std::size_t>(&estimate - filter_.estimates.data())] : filter_.t;
  }
  const DrawnFilter::ErrorFigures* figures(const Error& error) const {
    return drawn_ ? &drawn_->errors[static_cast<std::size_t>(&error - filter_.errors.data())] : nullptr;
  }
  UpdateFigures figures(const Updates& updates) const {
    return drawn_ ? drawn_->updates[static_cast<std::size_t>(&updates - filter_.updates.data())] : figures_of(updates);
  }
  std::size_t count(const Error& error) const { return drawn_ ? figures(error)->n : error.t.size(); }

  // -- time

  Json span() const {
    double from = std::numeric_limits<double>::infinity(), to = -from;
    const auto add = [&](const Numbers& t) {
      if (t.empty()) return;
      from = std::min(from, t.front());
      to = std::max(to, t.back());
    };
    add(filter_.t);
    for (const auto& error : filter_.errors) add(error.t);
    for (const auto& updates : filter_.updates) add(updates.t);
    return from <= to ? Json{from, to} : Json(nullptr);
  }

  /// "228 s", "start+60 s", or a number of seconds.
  std::optional<double> time_of(const Json& time) const {
    if (time.is_number()) return time.get<double>();
    if (!time.is_string()) return std::nullopt;
    std::string text = time.get<std::string>();
    double start = 0;
    if (text.starts_with("start+")) {
      const Json& start_s = at_or_null(summary_, "start_s");
      if (!start_s.is_number()) return std::nullopt;
      start = start_s.get<double>();
      text.erase(0, 6);
    }
    const auto parsed = parse_time(text);
    if (!parsed) return std::nullopt;
    constexpr std::int64_t second = nanoseconds_per_second;  // the whole ones apart, which are exact
    return start + (static_cast<double>(*parsed / second) + static_cast<double>(*parsed % second) / 1e9);
  }

  void add_window(Json& list, const std::string& name, const char* kind, const Json& from_to) const {
    if (!from_to.is_array() || from_to.size() != 2) return;
    const auto from = time_of(from_to[0]), to = time_of(from_to[1]);
    if (from && to) list.push_back({{"name", name}, {"kind", kind}, {"from", *from}, {"to", *to}});
  }

  /// What `evaluate` scores by itself, and where a measurement was withheld.
  Json windows() const {
    Json list = Json::array();
    const Json& scored = at_or_null(at_or_null(config_, "evaluate"), "windows");
    if (scored.is_object())
      for (const auto& [name, window] : scored.items()) {
        if (window.is_array()) add_window(list, name, "window", window);
        if (at_or_null(window, "filter") == Json(filter_.name))
          add_window(list, name, "window", at_or_null(window, "span"));
      }
    const Json& measurements = at_or_null(at_or_null(at_or_null(config_, "filters"), filter_.name), "measurements");
    if (measurements.is_object())
      for (const auto& [name, measurement] : measurements.items())
        for (const auto& stretch : at_or_null(measurement, "withhold")) add_window(list, name, "withheld", stretch);
    return list;
  }

  // -- states

  Json blocks() {
    std::vector<std::string> names;
    for (const auto& estimate : filter_.estimates)
      if (std::find(names.begin(), names.end(), estimate.block) == names.end()) names.push_back(estimate.block);
    Json list = Json::array();
    for (const auto& name : names) {
      Json block{{"name", name}, {"errors", Json::array()}, {"estimates", Json::array()}};
      for (const auto& error : filter_.errors)
        if (const auto [of, what] = split_name(error.name); of == name && what != "nees")
          block["errors"].push_back(error_json(error, what));
      for (const auto& estimate : filter_.estimates)
        if (estimate.block == name) block["estimates"].push_back(estimate_json(estimate));
      list.push_back(std::move(block));
    }
    return list;
  }

  Json error_json(const Error& error, const std::string& name) {
    const Display display = display_of(error.unit, error.display_unit, error.values);
    std::vector<Series> series{error.values};
    if (!error.sigma.empty()) series.emplace_back(error.sigma);
    const auto kept = extremes(series, points_);
    Json json{{"name", name}, {"unit", display.unit}, {"n", count(error)}};
    if (error.is_length) json["length"] = true;
    json["t"] = columns_.exact(picked(error.t, kept));
    json["v"] = columns_.plotted(picked(error.values, kept, display.scale));
    if (error.sigma.empty()) return json;
    json["s"] = columns_.plotted(picked(error.sigma, kept, display.scale));
    // Of a length no share is given: its σ is the root of the sum of the components' squares, so 99.7 % is not to be expected.
    if (error.is_length) return json;
    const Within within = drawn_ ? figures(error)->within : within_sigma(error.values, error.sigma);
    if (within.of > 0)
      json["within"] = {{"one", within.one}, {"two", within.two}, {"three", within.three}, {"of", within.of}};
    return json;
  }

  Json estimate_json(const Estimate& estimate) {
    const Display display = display_of(estimate.unit, estimate.display_unit, estimate.values);
    std::vector<Series> series{estimate.values};
    if (!estimate.sigma.empty()) series.emplace_back(estimate.sigma);
    const auto kept = extremes(series, points_);
    Json json{{"name", estimate.output}, {"unit", display.unit}, {"n", rows()}};
    json["t"] = columns_.exact(picked(times(estimate), kept));
    json["v"] = columns_.plotted(picked(estimate.values, kept, display.scale));
    if (!estimate.sigma.empty()) json["s"] = columns_.plotted(picked(estimate.sigma, kept, display.scale));
    if (estimate.is_angle) json["turn"] = 2 * M_PI / display.scale;
    return json;
  }

  Json nees() {
    Json list = Json::array();
    for (const auto& error : filter_.errors) {
      const auto [block, what] = split_name(error.name);
      if (what != "nees" || (block != score::state_name && !has_block(filter_, block))) continue;
      const Json& group = at_or_null(at_or_null(summary_, "consistency"), block);
      const double dof = at_or_null(group, "dof").is_number() ? group["dof"].get<double>() : 0;
      const auto kept = extremes({error.values}, points_);
      const auto [low, high] = chi_squared_95(dof);
      Json json{{"name", block}, {"n", count(error)}, {"dof", dof}, {"low", low}, {"high", high}};
      json["t"] = columns_.exact(picked(error.t, kept));
      json["v"] = columns_.plotted(picked(error.values, kept));
      std::size_t inside = 0;
      for (const double value : drawn_ ? figures(error)->nees : error.values) inside += value >= low && value <= high;
      json["inside"] = inside;
      list.push_back(std::move(json));
    }
    return list;
  }

  // -- measurements

  Json measurements() {
    Json list = Json::array();
    for (const auto& updates : filter_.updates) list.push_back(updates_json(updates));
    return list;
  }

  struct Rows {
    Numbers t, residual, sigma, noise;
    std::vector<std::uint8_t> outcome;
    std::int32_t group = 0;
    std::int64_t key = 0;
  };

  static std::vector<Rows> rows_of(const Updates& updates) {
    std::map<std::pair<std::int32_t, std::int64_t>, Rows> rows;
    std::size_t row = 0;
    for (std::size_t i = 0; i < updates.t.size(); ++i)
      for (std::int32_t r = 0; r < updates.rows[i]; ++r, ++row) {
        auto& of = rows[{updates.group[row], updates.key[row]}];
        of.group = updates.group[row];
        of.key = updates.key[row];
        of.t.push_back(updates.t[i]);
        of.residual.push_back(updates.residual[row]);
        of.sigma.push_back(updates.sigma[row]);
        of.noise.push_back(updates.noise[row]);
        of.outcome.push_back(static_cast<std::uint8_t>(updates.outcome[i]));
      }
    std::vector<Rows> list;
    for (auto& [name, of] : rows) list.push_back(std::move(of));
    return list;
  }

  Json updates_json(const Updates& updates) {
    const UpdateFigures all = figures(updates);
    Json json{{"name", updates.measurement}, {"n", offered(updates, all)}};
    json["outcomes"] = outcomes_json(updates, all);
    json["reasons"] = extent_ == Extent::whole ? reasons_json(all) : Json::array();
    json["nis"] = nis_json(updates, all);
    json["residuals"] = Json::array();
    json["noise"] = Json::array();
    const auto rows = rows_of(updates);
    for (std::size_t g = 0; g < updates.groups.size(); ++g) {
      std::vector<const Rows*> of_group;
      for (const auto& of : rows)
        if (of.group == static_cast<std::int32_t>(g)) of_group.push_back(&of);
      if (of_group.size() > most_row_plots)
        add_crowd(updates.groups[g], of_group, all, json);
      else
        for (const auto* of : of_group) add_rows(updates.groups[g], *of, of_group.size(), all, json);
    }
    return json;
  }

  /// What the summary holds of the measurement, where it knows more than the series.
  const Json& summary_of(const Updates& updates) const {
    return at_or_null(at_or_null(summary_, "measurements"), updates.measurement);
  }

  static std::size_t count_in(const Json& figures, const char* name) {
    const Json& count = at_or_null(figures, name);
    return count.is_number() ? count.get<std::size_t>() : 0;
  }

  std::size_t offered(const Updates& updates, const UpdateFigures& all) const {
    return extent_ == Extent::whole ? all.samples() : count_in(summary_of(updates), "offered");
  }

  std::vector<std::size_t> outcome_counts(const Updates& updates, const UpdateFigures& all) const {
    std::vector<std::size_t> counts(all.counts().begin(), all.counts().end());
    if (extent_ == Extent::thinned)
      for (std::size_t o = 0; o < counts.size(); ++o)
        counts[o] = count_in(summary_of(updates), results::outcome_names[o]);
    return counts;
  }

  Json outcomes_json(const Updates& updates, const UpdateFigures& all) {
    const auto codes = codes_of(updates.outcome);
    const auto counts = outcome_counts(updates, all);
    const auto kept = extremes_of_kinds({}, codes, points_);
    std::vector<std::uint8_t> shown;
    for (const auto i : kept) shown.push_back(codes[i]);
    return {{"t", columns_.exact(picked(updates.t, kept))}, {"o", columns_.bytes(shown)}, {"counts", counts}};
  }

  static std::vector<std::uint8_t> codes_of(const std::vector<Outcome>& outcomes) {
    std::vector<std::uint8_t> codes;
    codes.reserve(outcomes.size());
    for (const auto outcome : outcomes) codes.push_back(static_cast<std::uint8_t>(outcome));
    return codes;
  }

  /// [ { "outcome", "reason", "count" } ], the most frequent first.
  static Json reasons_json(const UpdateFigures& all) {
    std::vector<std::pair<std::size_t, std::pair<int, std::string>>> sorted;
    for (const auto& [what, count] : all.reasons()) sorted.emplace_back(count, what);
    std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    Json list = Json::array();
    for (const auto& [count, what] : sorted)
      list.push_back({{"outcome", what.first}, {"reason", what.second}, {"count", count}});
    return list;
  }

  Json nis_json(const Updates& updates, const UpdateFigures& all) {
    Numbers t, nis, dof;
    std::vector<std::uint8_t> outcome;
    for (std::size_t i = 0; i < updates.t.size(); ++i) {
      if (!std::isfinite(updates.nis[i]) || updates.rows[i] <= 0) continue;
      t.push_back(updates.t[i]);
      nis.push_back(updates.nis[i]);
      dof.push_back(updates.rows[i]);
      outcome.push_back(static_cast<std::uint8_t>(updates.outcome[i]));
    }
    if (t.empty()) return nullptr;
    const auto& bounds = all.bounds();
    const auto kept = extremes_of_kinds({nis}, outcome, points_);
    Json json{{"n", extent_ == Extent::whole ? all.with_nis() : offered(updates, all)}};
    json["t"] = columns_.exact(picked(t, kept));
    json["v"] = columns_.plotted(picked(nis, kept));
    std::vector<std::uint8_t> shown;
    Numbers low, high;
    for (const auto i : kept) {
      shown.push_back(outcome[i]);
      const auto [l, h] = bounds.at(static_cast<std::int32_t>(dof[i]));
      low.push_back(l);
      high.push_back(h);
    }
    json["o"] = columns_.bytes(shown);
    if (bounds.size() == 1) {
      json["dof"] = dof.front();
      json["low"] = low.front();
      json["high"] = high.front();
    } else {
      json["lows"] = columns_.plotted(low);
      json["highs"] = columns_.plotted(high);
    }
    if (extent_ == Extent::thinned) {
      json["mean"] = mean_of_summary(summary_of(updates));
      return json;
    }
    json["accepted"] = all.accepted();
    json["inside"] = all.inside();
    if (all.accepted() == 0) return json;
    json["mean"] = mean_json(all.mean_nis(), all.mean_dof(), static_cast<double>(all.accepted()));
    const MovingMean moving = all.moving_mean();
    if (!moving.t.empty())
      json["moving"] = {{"t", columns_.exact(moving.t)},
                        {"v", columns_.plotted(moving.mean)},
                        {"low", moving.low},
                        {"high", moving.high}};
    return json;
  }

  static Json mean_json(double mean, double dof, double n) {
    const auto [low, high] = mean_chi_squared_99(dof, n);
    return {{"value", mean}, {"dof", dof}, {"low", low}, {"high", high}};
  }

  static Json mean_of_summary(const Json& figures) {
    const Json &mean = at_or_null(figures, "nis_mean"), &dof = at_or_null(figures, "dof");
    if (!mean.is_number() || !dof.is_number()) return nullptr;
    return mean_json(mean.get<double>(), dof.get<double>(), static_cast<double>(count_in(figures, "accepted")));
  }

  static std::string row_name(const Updates::Group& group, std::int64_t key, std::size_t rows) {
    return rows < 2 ? group.name : group.name + " " + std::to_string(key);
  }

  /// A row by itself: its residual within ±3 √S, and its √R where that changes.
  void add_rows(const Updates::Group& group, const Rows& rows, std::size_t rows_of_group, const UpdateFigures& all,
                Json& json) {
    const Display display = display_of(group.unit, "", rows.residual);
    const std::string name = row_name(group, rows.key, rows_of_group);
    const auto kept = extremes_of_kinds({rows.residual, rows.sigma}, rows.outcome, points_);
    Json residual{{"name", name}, {"unit", display.unit}, {"n", figures_at(all, rows).n}};
    residual["t"] = columns_.exact(picked(rows.t, kept));
    residual["v"] = columns_.plotted(picked(rows.residual, kept, display.scale));
    residual["s"] = columns_.plotted(picked(rows.sigma, kept, display.scale));
    residual["o"] = columns_.bytes(kinds_at(rows, kept));
    residual["within"] = within_of({&rows}, all);
    json["residuals"].push_back(std::move(residual));
    add_noise(group, name, rows, figures_at(all, rows), json);
  }

  static const UpdateFigures::Row& figures_at(const UpdateFigures& all, const Rows& rows) {
    return all.rows().at({rows.group, rows.key});
  }

  void add_noise(const Updates::Group& group, const std::string& name, const Rows& rows, const UpdateFigures::Row& all,
                 Json& json) {
    const double least = all.least_noise, greatest = all.greatest_noise;
    const Display display = display_of(group.unit, "", rows.noise);
    Json noise{{"name", name}, {"unit", display.unit}, {"n", all.n}};
    if (greatest - least <= 1e-9 * greatest)
      noise["constant"] = greatest / display.scale;
    else {
      const auto kept = extremes({rows.noise}, points_);
      noise["t"] = columns_.exact(picked(rows.t, kept));
      noise["v"] = columns_.plotted(picked(rows.noise, kept, display.scale));
    }
    json["noise"].push_back(std::move(noise));
  }

  static std::vector<std::uint8_t> kinds_at(const Rows& rows, const std::vector<std::size_t>& indices) {
    std::vector<std::uint8_t> kinds;
    for (const auto i : indices) kinds.push_back(rows.outcome[i]);
    return kinds;
  }

  /// Of what was accepted; a gate is there to keep the others out.
  Json within_of(const std::vector<const Rows*>& rows, const UpdateFigures& all) const {
    if (extent_ == Extent::thinned) return nullptr;
    Within within;
    for (const auto* of : rows) within.add(figures_at(all, *of).within);
    return within.of == 0 ? Json(nullptr)
                          : Json{{"one", within.one}, {"two", within.two}, {"three", within.three}, {"of", within.of}};
  }

  /// Many rows of one kind: residuals in units of their own √S.
  void add_crowd(const Updates::Group& group, const std::vector<const Rows*>& crowded, const UpdateFigures& all,
                 Json& json) {
    struct Point {
      double t, ratio;
      std::uint8_t outcome;
    };
    std::vector<Point> points;
    std::size_t n = 0;
    for (const auto* rows : crowded) n += figures_at(all, *rows).n;
    for (const auto* rows : crowded)
      for (std::size_t i = 0; i < rows->t.size(); ++i)
        points.push_back({rows->t[i], rows->residual[i] / rows->sigma[i], rows->outcome[i]});
    std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.t < b.t; });
    Rows crowd;
    for (const auto& point : points) {
      crowd.t.push_back(point.t);
      crowd.residual.push_back(point.ratio);
      crowd.outcome.push_back(point.outcome);
    }
    const auto kept = extremes_of_kinds({crowd.residual}, crowd.outcome, points_);
    Json residual{{"name", group.name}, {"unit", "σ"}, {"n", n}, {"of", crowded.size()}};
    residual["t"] = columns_.exact(picked(crowd.t, kept));
    residual["v"] = columns_.plotted(picked(crowd.residual, kept));
    residual["o"] = columns_.bytes(kinds_at(crowd, kept));
    residual["bound"] = 3;
    residual["within"] = within_of(crowded, all);
    json["residuals"].push_back(std::move(residual));
  }

  /// Errors named "match.velocity.noise" are no errors but the √R that an estimator came to.
  Json adapted_noise() {
    Json list = Json::array();
    for (const auto& error : filter_.errors) {
      const auto [of, what] = split_name(error.name);
      if (what != "noise" || has_block(filter_, of)) continue;
      list.push_back(error_json(error, of));
    }
    return list;
  }

  // -- map

  Json path_json(const Path& path, const std::vector<double>& shade, double step) {
    auto kept = spaced(path.east, path.north, step);
    // A track that jumps to and fro has more points than its extent suggests.
    for (double wider = 2 * step; kept.size() > most_track_points; wider *= 2)
      kept = spaced(path.east, path.north, wider);
    return {{"points", kept.size()},
            {"t", columns_.exact(picked(path.t, kept))},
            {"e", columns_.plotted(picked(path.east, kept))},
            {"n", columns_.plotted(picked(path.north, kept))},
            {"shade", shade.empty() ? Json(nullptr) : Json(columns_.plotted(picked(shade, kept)))}};
  }

  Json track_json(const Track& track) {
    double extent = 0;
    for (const auto* values : {&track.estimate.east, &track.estimate.north}) {
      const auto [low, high] = std::minmax_element(values->begin(), values->end());
      if (low != values->end()) extent = std::max(extent, *high - *low);
    }
    const double step = std::max(1e-3, extent / static_cast<double>(most_track_points) * 2);
    Json json{{"block", track.block}, {"estimate", path_json(track.estimate, track.sigma, step)}};
    if (std::isfinite(track.lat)) json["origin"] = {{"lat", track.lat * 180 / M_PI}, {"lon", track.lon * 180 / M_PI}};
    if (!track.reference.t.empty()) json["reference"] = path_json(track.reference, track.error, step);
    return json;
  }

  const FilterResults& filter_;
  const Json& summary_;
  const Json& config_;
  std::size_t points_;
  Extent extent_;
  Columns& columns_;
  const std::optional<TrackOrigin>& origin_;
  const DrawnFilter* drawn_ = nullptr;  // null: filter_ is all there is
};

/// Counters beyond 2^53 do not survive a script's numbers.
Json as_text(const Json& provenance) {
  Json shown = provenance;
  for (const char* key : {"seed", "run"})
    if (shown.is_object() && shown.contains(key) && shown[key].is_number()) shown[key] = shown[key].dump();
  return shown;
}

Json run_json(const results::RunResults& run, std::size_t points) {
  return {{"summary", run.summary},
          {"config", run.config},
          {"provenance", as_text(run.provenance)},
          {"points", points},
          {"filters", Json::array()}};
}

}  // namespace

Json run_payload(const results::RunResults& run, const std::vector<const DrawnFilter*>& drawn, const Limits& limits,
                 Columns& columns) {
  const std::size_t points = points_per_series(drawn, limits);
  Json json = run_json(run, points);
  const std::optional<TrackOrigin> none;
  for (const auto* filter : drawn) json["filters"].push_back(FilterPayload(*filter, run, points, columns, none).json());
  return json;
}

Json run_payload(const results::RunResults& run, const Limits& limits, Extent extent, Columns& columns,
                 const std::optional<TrackOrigin>& origin) {
  const std::size_t points = points_per_series(run.filters, limits);
  Json json = run_json(run, points);
  for (const auto& filter : run.filters)
    json["filters"].push_back(FilterPayload(filter, run, points, extent, columns, origin).json());
  return json;
}

}  // namespace binnacle::report
