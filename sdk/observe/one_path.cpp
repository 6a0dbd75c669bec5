// SPDX-License-Identifier: Apache-2.0
#include "one_path.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "binnacle/eigen.hpp"
#include "binnacle/run.hpp"
#include "observe/directions.hpp"
#include "score/sections.hpp"
#include "wording/wording.hpp"

namespace binnacle::observe {

using namespace wording;
using Json = nlohmann::ordered_json;

namespace {

std::string nanoseconds_text(Time t) { return std::to_string(t) + " ns"; }

/// The measurement's "withhold" with the window added.
Json withheld_as_well(const Json& measurement, const Stay& stay) {
  Json withhold = measurement.value("withhold", Json::array());
  Json& windows = withhold.is_object() ? withhold["windows"] : withhold;
  if (windows.is_null()) windows = Json::array();
  const Time first = stay.from + (stay.at_start ? 0 : 1);
  windows.push_back({nanoseconds_text(first), nanoseconds_text(std::max(stay.to, first + 1))});
  return withhold;
}

LoadOptions without_corrections(const std::filesystem::path& config, LoadOptions options, const FilterInfo& filter,
                                const Stay& stay) {
  const Json all = Json::parse(score::load_config(config, options).text());
  const Json& measurements = all.at("filters").at(filter.name).at("measurements");
  const std::string at = join_pointer(join_pointer("/filters", filter.name), "measurements");
  for (const auto& [name, measurement] : measurements.items())
    options.sets.push_back(join_pointer(join_pointer(at, name), "withhold") + "=" +
                           withheld_as_well(measurement, stay).dump());
  for (auto& set : score::by_jacobians(all, filter.name)) options.sets.push_back(std::move(set));  // P grows along it
  return options;
}

/// Goes along the path.
class Walk final : public binnacle::RunObserver, public StepObserver {
 public:
  Walk(const FilterInfo& filter, int index, const Stay& stay, const RunKey& key)
      : index_(index), stay_(stay), key_(key), pattern_(filter), phi_(pattern_.size()) {
    information_.emplace(pattern_, stay.P0, static_cast<int>(filter.measurements.size()), false);
  }

  void begin(Session& session) override { session.attach({index_}, this); }
  bool progress(Time t) override { return key_.goes_on() && t <= stay_.to; }
  Wants wants() const override {
    const Wants always = Wants::transition | Wants::jacobian;
    return is_inside_ ? always : always | Wants::step_covariance;
  }
  void started(Time t, const double*, ConstMatrixView P) override {
    if (is_inside_ && t <= stay_.to) has_restarted_ = true;
    if (!is_inside_ && stay_.at_start && t == stay_.from) enter(P);
  }
  void stepped(const StepRecord& record) override {
    if (!is_inside_ && !stay_.at_start && record.t0 == stay_.from) enter(record.P0);
    if (!is_inside_ || record.t1 > stay_.to) return;
    pattern_.gather(record.Phi, phi_.data());
    information_->step(phi_.data(), record.Qd);
  }
  void offered(const UpdateRecord& record) override {
    if (!is_inside_ || record.outcome != Outcome::withheld) return;
    while (next_ < stay_.accepted.size() && stay_.accepted[next_].t < record.t) ++next_;
    if (next_ == stay_.accepted.size()) return;
    const Accepted& sample = stay_.accepted[next_];
    if (sample.t != record.t || sample.measurement != record.measurement) return;
    const std::vector<int> rows = rows_of(sample, record);
    if (rows.empty()) return;
    H_ = record.H.as()(rows, Eigen::all);
    const auto m = static_cast<int>(rows.size());
    information_->update(sample.measurement, ConstMatrixView{H_.data(), m, record.H.cols, m},
                         ConstMatrixView{sample.R.data(), m, m, m});
    ++next_;
    ++found_;
  }

  OnePath result() const {
    if (!is_inside_ || !is_same_) return {{}, "run again, the filter does not come to the window as it did"};
    if (has_restarted_) return {{}, "without corrections the filter starts anew inside of the window"};
    const std::size_t missing = stay_.accepted.size() - found_;
    if (missing > 0)
      return {{},
              std::to_string(missing) + " of " + std::to_string(stay_.accepted.size()) +
                  " samples cannot be linearized without corrections; a shorter window may do"};
    return {information_->removed(), ""};
  }

 private:
  void enter(ConstMatrixView P) {
    is_inside_ = true;
    is_same_ = P.as() == stay_.P0;
  }
  /// Where the sample's rows are among those of the record; empty where one is missing.
  static std::vector<int> rows_of(const Accepted& sample, const UpdateRecord& record) {
    std::vector<int> rows;
    for (std::size_t i = 0; i < sample.keys.size(); ++i) {
      int k = rows.empty() ? 0 : rows.back() + 1;
      while (k < record.rows && (record.row_groups[k] != sample.groups[i] || record.row_keys[k] != sample.keys[i])) ++k;
      if (k == record.rows) return {};
      rows.push_back(k);
    }
    return rows;
  }

  int index_;
  const Stay& stay_;
  const RunKey& key_;
  smooth::TransitionPattern pattern_;
  std::optional<Information> information_;
  std::vector<double> phi_;
  Eigen::MatrixXd H_;
  std::size_t next_ = 0, found_ = 0;  // of the accepted samples
  bool is_inside_ = false, is_same_ = false, has_restarted_ = false;
};

}  // namespace

OnePath on_one_path(const std::filesystem::path& config, const LoadOptions& options, const RunKey& key, int filter,
                    const FilterInfo& info, const Stay& stay) {
  if (stay.accepted.empty()) return {stay.with_noise.removed(), ""};
  const auto composition = score::load(config, without_corrections(config, options, info, stay));
  Walk walk(composition->filters()[as_size(filter)], filter, stay, key);
  binnacle::RunOptions run_options;
  run_options.seed = key.seed;
  run_options.run = key.run;
  run_options.observer = &walk;
  run_options.feeds_sinks = false;
  run(composition, run_options);
  return walk.result();
}

}  // namespace binnacle::observe
