// SPDX-License-Identifier: Apache-2.0
#include "observe/window.hpp"

#include <algorithm>
#include <utility>

#include "binnacle/eigen.hpp"
#include "wording/wording.hpp"

namespace binnacle::observe {

using namespace wording;

Stay::Stay(const smooth::TransitionPattern& pattern, std::string stay_name, Time begin, Eigen::MatrixXd P,
           int measurements)
    : name(std::move(stay_name)),
      from(begin),
      to(begin),
      P0(std::move(P)),
      with_noise(pattern, P0, measurements, false),
      without_noise(pattern, P0, measurements, true) {}

FilterWatch::FilterWatch(const FilterInfo& filter, std::vector<Window> windows)
    : filter_(filter),
      pattern_(filter),
      windows_(std::move(windows)),
      is_pending_(windows_.size(), true),
      phi_(pattern_.size()) {}

Wants FilterWatch::wants() const {
  Wants wants = Wants::nothing;
  if (std::ranges::find(is_pending_, true) != is_pending_.end()) wants = Wants::step_covariance;
  if (!open_.empty() || wants != Wants::nothing) wants = wants | Wants::transition | Wants::jacobian | Wants::reset;
  return wants;
}

void FilterWatch::open(const Window& window, std::string name, Time t, ConstMatrixView P, bool at_start) {
  Stay& stay = stays_.emplace_back(pattern_, std::move(name), t, P.as(), static_cast<int>(filter_.measurements.size()));
  stay.at_start = at_start;
  stay.until = end(window);
  open_.push_back(&stay);
}

void FilterWatch::started(Time t, const double*, ConstMatrixView P) {
  const bool anew = start_ != no_time;
  if (!anew) start_ = t;
  for (Stay* stay : open_) stay->restarted = true;
  const std::vector<Stay*> ended = std::exchange(open_, {});
  for (std::size_t w = 0; w < windows_.size(); ++w) {
    const Window& window = windows_[w];
    if (begin(window) > t || end(window) <= t) continue;
    is_pending_[w] = false;
    open(window, anew ? window.name + ", from the new start" : window.name, t, P, true);
  }
}

void FilterWatch::stepped(const StepRecord& record) {
  for (std::size_t w = 0; w < windows_.size(); ++w) {
    if (!is_pending_[w] || begin(windows_[w]) >= record.t1) continue;
    is_pending_[w] = false;
    if (end(windows_[w]) > record.t0) open(windows_[w], windows_[w].name, record.t0, record.P0, false);
  }
  std::erase_if(open_, [&](const Stay* stay) { return record.t1 > stay->until; });
  if (open_.empty()) return;
  pattern_.gather(record.Phi, phi_.data());
  for (Stay* stay : open_) {
    stay->to = record.t1;
    stay->with_noise.step(phi_.data(), record.Qd);
    stay->without_noise.step(phi_.data(), record.Qd);
  }
}

void FilterWatch::offered(const UpdateRecord& record) {
  if (record.outcome != Outcome::accepted || open_.empty()) return;
  const std::size_t rows = as_size(record.rows);
  Accepted sample{record.measurement, record.t, {}, {}, record.R.as()};
  sample.groups.assign(record.row_groups, record.row_groups + rows);
  sample.keys.assign(record.row_keys, record.row_keys + rows);
  for (Stay* stay : open_) {
    stay->to = record.t;
    const bool is_whole = stay->with_noise.update(record.measurement, record.H, record.R) &&
                          stay->without_noise.update(record.measurement, record.H, record.R);
    stay->singular += !is_whole;
    if (record.reset) {
      stay->with_noise.reset(record.reset);
      stay->without_noise.reset(record.reset);
    }
    stay->history.add(record.t, stay->with_noise.removed());
    stay->accepted.push_back(sample);
  }
}

void FilterWatch::inflated(const InflationRecord& record) {
  for (Stay* stay : open_) {
    ++stay->opened;
    if (record.variances) stay->with_noise.inflate(record.variances);
  }
}

}  // namespace binnacle::observe
