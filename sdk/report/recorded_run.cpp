// SPDX-License-Identifier: Apache-2.0
#include "report/recorded_run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "binnacle/state_block.hpp"
#include "decimation.hpp"
#include "payload.hpp"
#include "results/run_writer.hpp"
#include "thinned_rows.hpp"
#include "thinned_updates.hpp"

namespace binnacle::report {

/// Of the block whose places are the track, as track_of() takes them: its first two outputs that are such.
struct TrackColumns {
  std::size_t lat, lon;  // north and east of a plane
  bool is_geographic;
};

namespace {

constexpr std::size_t most_track_rows = 16384;
constexpr double earth_radius = 6.371e6;  // how far places are apart, and not where they are

std::optional<TrackColumns> track_columns(const results::FilterResults& filter) {
  const auto find = [&](const std::string& block, const char* output) {
    for (std::size_t i = 0; i < filter.estimates.size(); ++i)
      if (filter.estimates[i].block == block && filter.estimates[i].output == output) return i;
    return filter.estimates.size();
  };
  for (std::size_t i = 0; i < filter.estimates.size(); ++i) {
    const auto& estimate = filter.estimates[i];
    const bool is_lat = estimate.output == "lat" && estimate.unit == "rad";
    if (!is_lat && !(estimate.output == "north" && estimate.unit == "m")) continue;
    const std::size_t other = find(estimate.block, is_lat ? "lon" : "east");
    if (other < filter.estimates.size()) return TrackColumns{i, other, is_lat};
  }
  return std::nullopt;
}

template <class Values>
std::vector<double> chosen(const Values& values, const std::vector<std::size_t>& indices) {
  std::vector<double> chosen;
  for (const auto i : indices) chosen.push_back(values[i]);
  return chosen;
}

/// So many, evenly, the first and the last among them.
std::vector<std::size_t> evenly(std::size_t n, std::size_t most) {
  std::vector<std::size_t> indices;
  const std::size_t kept = std::min(n, most);
  for (std::size_t i = 0; i < kept; ++i) indices.push_back(kept == n ? i : i * (n - 1) / (kept - 1));
  return indices;
}

}  // namespace

class RecordedRun::Filter final : public StepObserver {
 public:
  Filter(const FilterInfo& info, const Limits& limits) : info_(info), most_(limits.most_points) {
    drawn_.series.name = info.name;
    for (const auto& block : info.blocks)
      for (const auto& output : block.declaration->outputs)
        drawn_.series.estimates.push_back({block.name,
                                           output.name,
                                           output.unit,
                                           output.display_unit.empty() ? output.unit : output.display_unit,
                                           output.is_angle,
                                           {},
                                           {},
                                           block.declaration->kind});
    for (const auto& measurement : info.measurements)
      updates_.emplace_back(measurement, limits.most_points, 8 * limits.most_points);
    drawn_.updates.resize(updates_.size());
  }

  std::size_t series() const {
    std::size_t series = 3 * drawn_.series.estimates.size();
    for (const auto& updates : updates_) series += series_of(updates.updates());
    return series;
  }

  /// With what a series may have, as far as it is known before the run.
  void begin(std::size_t points) {
    points_ = points;
    for (std::size_t i = 0; i < drawn_.series.estimates.size(); ++i) estimates_.emplace_back(points);
    track_columns_ = track_columns(drawn_.series);
  }

  void take(const results::ColumnBlock& rows) {
    if (rows.rows() == 0) return;
    if (drawn_.rows == 0) drawn_.series.t = {rows.t().front(), rows.t().front()};
    drawn_.rows += rows.rows();
    drawn_.series.t.back() = rows.t().back();
    const std::size_t n = estimates_.size();
    for (std::size_t i = 0; i < n; ++i) estimates_[i].add(rows.t(), rows.column(i), rows.column(n + i));
    if (track_columns_) take_track(rows);
  }

  void offered(const UpdateRecord& record) override {
    const auto index = static_cast<std::size_t>(record.measurement);
    UpdateFigures& figures = drawn_.updates[index];
    const bool is_linearized = record.residual != nullptr;
    updates_[index].add(record);
    figures.add(results::nearest_seconds(record.t), record.outcome, record.reason,
                is_linearized ? record.nis : std::numeric_limits<double>::quiet_NaN(), is_linearized ? record.rows : 0);
    for (int i = 0; is_linearized && i < record.rows; ++i)
      figures.add_row(record.row_groups[i], record.row_keys[i], record.residual[i], std::sqrt(record.S(i, i)),
                      std::sqrt(record.R(i, i)));
  }

  void scored(const score::ErrorSeries& errors) {
    auto& error = drawn_.series.errors.emplace_back();
    error.name = errors.name;
    error.unit = errors.unit;
    error.display_unit = errors.display_unit.empty() ? errors.unit : errors.display_unit;
    error.is_length = results::is_norm(info_, errors.name);
    error.is_component = results::component_of(info_, errors).first != nullptr;
    auto& figures = drawn_.errors.emplace_back();
    figures.n = errors.t.size();
    if (!error.is_length) figures.within = within_sigma(errors.values, errors.sigma);
    if (errors.name.ends_with(".nees")) figures.nees.assign(errors.values.begin(), errors.values.end());
    std::vector<Series> series{errors.values};
    if (!errors.sigma.empty()) series.emplace_back(errors.sigma);
    const auto kept = extremes(series, most_);
    for (const auto i : kept) error.t.push_back(results::nearest_seconds(errors.t[i]));
    error.values = chosen(errors.values, kept);
    if (!errors.sigma.empty()) error.sigma = chosen(errors.sigma, kept);
    keep_of_reference(errors);
  }

  const DrawnFilter& drawn() {
    for (std::size_t i = 0; i < estimates_.size(); ++i) {
      estimates_[i].finish();
      auto [t, values, sigma] = std::move(estimates_[i]).taken();
      drawn_.t.push_back(std::move(t));
      drawn_.series.estimates[i].values = std::move(values);
      drawn_.series.estimates[i].sigma = std::move(sigma);
    }
    for (const auto& updates : updates_) drawn_.series.updates.push_back(updates.updates());
    if (path_) finish_track();
    return drawn_;
  }

 private:
  void take_track(const results::ColumnBlock& rows) {
    const auto [lat, lon, is_geographic] = *track_columns_;
    const auto x = rows.column(lon), y = rows.column(lat);
    const auto sigma_x = rows.column(estimates_.size() + lon), sigma_y = rows.column(estimates_.size() + lat);
    if (!path_)
      path_.emplace(most_track_rows, is_geographic ? earth_radius * std::cos(y.front()) : 1,
                    is_geographic ? earth_radius : 1);
    for (std::size_t i = 0; i < rows.rows(); ++i) path_->add(rows.t()[i], x[i], y[i], sigma_x[i], sigma_y[i]);
  }

  void finish_track() {
    path_->finish();
    results::FilterResults& track = drawn_.track;
    track.t = path_->t();
    auto lat = drawn_.series.estimates[track_columns_->lat], lon = drawn_.series.estimates[track_columns_->lon];
    lat.values = path_->y();
    lat.sigma = path_->sigma_y();
    lon.values = path_->x();
    lon.sigma = path_->sigma_x();
    track.estimates = {std::move(lat), std::move(lon)};
  }

  /// The reference's path is drawn from errors at common times.
  void keep_of_reference(const score::ErrorSeries& errors) {
    if (!track_columns_) return;
    const std::string& block = drawn_.series.estimates[track_columns_->lat].block;
    if (errors.name != block + ".north" && errors.name != block + ".east") return;
    auto& error = drawn_.track.errors.emplace_back();
    error.name = errors.name;
    const auto kept = evenly(errors.t.size(), most_);
    for (const auto i : kept) error.t.push_back(results::nearest_seconds(errors.t[i]));
    error.values = chosen(errors.values, kept);
  }

  const FilterInfo& info_;
  std::size_t most_, points_ = 0;
  DrawnFilter drawn_;
  std::vector<ThinnedSeries> estimates_;
  std::vector<ThinnedUpdates> updates_;  // by measurement
  std::optional<TrackColumns> track_columns_;
  std::optional<ThinnedPath> path_;
};

RecordedRun::RecordedRun(const Composition& composition, const Limits& limits) : limits_(limits) {
  std::size_t series = 0;
  for (const auto& filter : score::filters_of(composition)) {
    filters_.push_back(std::make_unique<Filter>(filter, limits));
    series += filters_.back()->series();
  }
  for (auto& filter : filters_) filter->begin(most_points(series, limits));
}

RecordedRun::~RecordedRun() = default;

void RecordedRun::take(int filter, const results::ColumnBlock& rows) {
  filters_[static_cast<std::size_t>(filter)]->take(rows);
}

StepObserver* RecordedRun::step_observer(int filter) { return filters_[static_cast<std::size_t>(filter)].get(); }

void RecordedRun::scored(int filter, const score::ErrorSeries& errors) {
  filters_[static_cast<std::size_t>(filter)]->scored(errors);
}

std::string RecordedRun::page(const results::Json& summary, const results::Json& config,
                              const results::Json& provenance, std::optional<results::StudyResults> study) {
  results::Results results;
  auto& run = results.run.emplace();
  run.summary = summary;
  run.config = config;
  for (const char* key : {"version", "command", "seed", "run", "plugins", "created"})  // as in run.nc
    if (provenance.contains(key)) run.provenance[key] = provenance[key];
  results.study = std::move(study);
  std::vector<const DrawnFilter*> drawn;
  for (auto& filter : filters_) drawn.push_back(&filter->drawn());
  return page_of(results, drawn, limits_);
}

}  // namespace binnacle::report
