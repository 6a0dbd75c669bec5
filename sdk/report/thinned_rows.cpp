// SPDX-License-Identifier: Apache-2.0
#include "thinned_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace binnacle::report {

namespace {

/// Where the least and the greatest of a stretch are; NaN is passed over. Both `end` where there is nothing else.
struct Extremes {
  std::size_t least, greatest;
};
Extremes extremes_of(const double* values, std::size_t begin, std::size_t end) {
  while (begin < end && std::isnan(values[begin])) ++begin;
  Extremes at{begin, begin};
  if (begin == end) return at;
  double least = values[begin], greatest = least;
  for (std::size_t i = begin + 1; i < end; ++i) {
    if (values[i] < least) least = values[i], at.least = i;
    if (values[i] > greatest) greatest = values[i], at.greatest = i;
  }
  return at;
}

/// The places of a stretch that are kept, ascending, each once.
class Places {
 public:
  void add(const Extremes& extremes, std::size_t end) {
    if (extremes.least == end) return;
    add(extremes.least);
    add(extremes.greatest);
  }
  const std::size_t* begin() const { return places_.data(); }
  const std::size_t* end() const { return places_.data() + count_; }

 private:
  void add(std::size_t place) {
    std::size_t at = count_;
    while (at > 0 && places_[at - 1] > place) --at;
    if (at > 0 && places_[at - 1] == place) return;
    std::copy_backward(places_.begin() + static_cast<std::ptrdiff_t>(at),
                       places_.begin() + static_cast<std::ptrdiff_t>(count_),
                       places_.begin() + static_cast<std::ptrdiff_t>(count_) + 1);
    places_[at] = place;
    ++count_;
  }
  std::array<std::size_t, 5> places_{};
  std::size_t count_ = 0;
};

}  // namespace

ThinnedSeries::ThinnedSeries(std::size_t most_points) : most_(std::max<std::size_t>(16, most_points)) {}

void ThinnedSeries::keep(std::size_t row, double t, double value, double sigma) {
  if (row_.size() == row_.capacity()) {  // no further than it may grow
    const std::size_t room = std::min(most_ + 6, 64 + 2 * row_.size());
    row_.reserve(room);
    for (auto* values : {&t_, &values_, &sigma_}) values->reserve(room);
  }
  row_.push_back(row);
  t_.push_back(t);
  values_.push_back(value);
  sigma_.push_back(sigma);
}

void ThinnedSeries::add(std::span<const double> t, std::span<const double> values, std::span<const double> sigma) {
  if (t.empty()) return;
  for (std::size_t begin = 0; begin < t.size();) {
    // As far as the stretch goes on: one that began with the rows before may keep more until it is thinned again.
    const std::size_t end = std::min(t.size(), begin + (width_ - rows_ % width_));
    are_parts_ = are_parts_ || end - begin < width_;
    Places places;
    places.add(extremes_of(values.data(), begin, end), end);
    if (!sigma.empty()) places.add(extremes_of(sigma.data(), begin, end), end);
    if (width_ == 1 || rows_ == 0) places.add({begin, begin}, end);  // all of them; the first
    for (const std::size_t i : places)
      keep(rows_ + i - begin, t[i], values[i], sigma.empty() ? std::numeric_limits<double>::quiet_NaN() : sigma[i]);
    rows_ += end - begin;
    begin = end;
    if (row_.size() > most_) make_room();
  }
  last_t_ = t.back();
  last_value_ = values.back();
  last_sigma_ = sigma.empty() ? std::numeric_limits<double>::quiet_NaN() : sigma.back();
}

void ThinnedSeries::finish() {
  if (rows_ > 0 && (row_.empty() || row_.back() + 1 < rows_)) keep(rows_ - 1, last_t_, last_value_, last_sigma_);
}

/// A stretch that came in several blocks kept more than it may; only if that is not it, they become longer.
void ThinnedSeries::make_room() {
  if (std::exchange(are_parts_, false)) thin();
  while (row_.size() > most_ - most_ / 4) {
    width_ *= 2;
    thin();
  }
}

/// What is kept of what was kept is what would be kept of all.
void ThinnedSeries::thin() {
  std::size_t kept = 0;
  for (std::size_t begin = 0, end = 0; begin < row_.size(); begin = end) {
    const std::uint64_t stretch = row_[begin] / width_;
    while (end < row_.size() && row_[end] / width_ == stretch) ++end;
    Places places;
    places.add(extremes_of(values_.data(), begin, end), end);
    places.add(extremes_of(sigma_.data(), begin, end), end);
    if (begin == 0) places.add({0, 0}, end);
    for (const std::size_t i : places) {
      row_[kept] = row_[i];
      t_[kept] = t_[i];
      values_[kept] = values_[i];
      sigma_[kept] = sigma_[i];
      ++kept;
    }
  }
  row_.resize(kept);
  for (auto* values : {&t_, &values_, &sigma_}) values->resize(kept);
}

ThinnedPath::ThinnedPath(std::size_t most_points, double scale_x, double scale_y)
    : most_(std::max<std::size_t>(16, most_points)), scale_x_(scale_x), scale_y_(scale_y) {}

bool ThinnedPath::is_apart(std::size_t from, double x, double y) const {
  const double east = (x - x_[from]) * scale_x_, north = (y - y_[from]) * scale_y_;
  return !(east * east + north * north < step_ * step_);
}

void ThinnedPath::add(double t, double x, double y, double sigma_x, double sigma_y) {
  is_last_kept_ = t_.empty() || is_apart(t_.size() - 1, x, y);
  if (!is_last_kept_) {
    const double row[] = {t, x, y, sigma_x, sigma_y};
    std::copy(std::begin(row), std::end(row), last_);
    return;
  }
  t_.push_back(t);
  x_.push_back(x);
  y_.push_back(y);
  sigma_x_.push_back(sigma_x);
  sigma_y_.push_back(sigma_y);
  while (t_.size() > most_) thin();
}

void ThinnedPath::finish() {
  if (is_last_kept_) return;
  step_ = 0;
  add(last_[0], last_[1], last_[2], last_[3], last_[4]);
}

/// A millimetre, what a page tells apart, or twice as far as before. Where places are no numbers no step helps: then every other goes.
void ThinnedPath::thin() {
  step_ = std::max(1e-3, 2 * step_);
  const auto keep = [&](const auto& is_kept) {
    std::size_t kept = 1;
    for (std::size_t i = 1; i < t_.size(); ++i) {
      if (!is_kept(kept, i)) continue;
      for (auto* values : {&t_, &x_, &y_, &sigma_x_, &sigma_y_}) (*values)[kept] = (*values)[i];
      ++kept;
    }
    for (auto* values : {&t_, &x_, &y_, &sigma_x_, &sigma_y_}) values->resize(kept);
  };
  keep([&](std::size_t kept, std::size_t i) { return is_apart(kept - 1, x_[i], y_[i]); });
  if (step_ > 1e9 && t_.size() > most_) keep([](std::size_t, std::size_t i) { return i % 2 == 0; });
}

}  // namespace binnacle::report
