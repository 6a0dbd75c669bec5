// SPDX-License-Identifier: Apache-2.0
// Differences of distances to points that are known: times of arrival without a clock in common with the sender.
#include "range_difference.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace binnacle::aiding {

namespace {

constexpr double nearest_of_pair = 1e-3;  // m: nearer to an anchor there is no direction

/// Which anchors hang together by the pairs so far.
class Groups {
 public:
  /// false: they did so already.
  bool join(std::int64_t a, std::int64_t b) {
    const int i = group_of(a), j = group_of(b);
    if (i == j) return false;
    for (int k = 0; k < count_; ++k)
      if (groups_[static_cast<std::size_t>(k)] == j) groups_[static_cast<std::size_t>(k)] = i;
    return true;
  }

 private:
  int group_of(std::int64_t key) {
    const auto end = keys_.begin() + count_, found = std::find(keys_.begin(), end, key);
    if (found != end) return groups_[static_cast<std::size_t>(found - keys_.begin())];
    keys_[static_cast<std::size_t>(count_)] = key;
    groups_[static_cast<std::size_t>(count_)] = count_;
    return count_++;
  }
  std::array<std::int64_t, 64> keys_{};
  std::array<int, 64> groups_{};
  int count_ = 0;
};

}  // namespace

ComponentSpec RangeDifference::spec() {
  using parameter::integer, parameter::number;
  ComponentSpec spec;
  spec.type = "range_difference";
  spec.summary =
      "Differences of distances to pairs of anchors, from times of arrival of one signal (TDOA), a row for each.";
  spec.source =
      "Chan and Ho, A simple and efficient estimator for hyperbolic location, IEEE Transactions on Signal Processing "
      "42 "
      "(1994), section II: the covariance of differences with a common reference";
  spec.parameters = {
      number("sigma", "m")
          .above(0)
          .plausible(1e-4, 1e4)
          .about("standard deviation of the white noise of one anchor's time of arrival, as a distance; a difference "
                 "has twice the variance. Not needed if each of 'anchors' has one"),
      Anchors::parameter(), parameter::origin(),
      integer("reference").about("number of the reference anchor, if the channel has no field 'reference'")};
  spec.ports = {
      reads("position", "*").about("position of the sensor: kind position, position.ecef, vector:2:m or vector:3:m"),
      reads("bias", "vector:*:m")
          .optional()
          .about("bias of an anchor's time of arrival as a distance: one for each of 'anchors', in their order")};
  spec.fields = {
      field::level("range_difference", "m").per_row().about("distance to 'anchor' minus distance to 'reference'"),
      field::level("anchor", "1").per_row().about("number of the anchor"),
      field::level("reference", "1")
          .per_row()
          .optional()
          .about("number of the reference anchor, whose distance is subtracted")};
  spec.example = R"json({"channel": "tdoa", "blocks": {"position": "position"}, "sigma": "0.1 m", "reference": 1,
    "anchors": {"1": {"north": 0, "east": 0, "down": -3},
                "2": {"north": 20, "east": 0, "down": -1},
                "3": {"north": 20, "east": 15, "down": -3},
                "4": {"north": 0, "east": 15, "down": -1, "sigma": "0.2 m"}}})json";
  spec.surroundings = R"json({"sources": {"tdoa": {"type": "core/pushed", "max_rows": 3, "fields": {
      "range_difference": {"unit": "m", "per_row": true}, "anchor": {"unit": "1", "per_row": true}}}},
    "blocks": {"position": {"type": "vector", "size": 3, "unit": "m", "init": [7, 4, -0.5], "sigma": 0.5}},
    "sample": {"range_difference": [5.1, 8.7, 4.4], "anchor": [2, 3, 4]}})json";
  return spec;
}

RangeDifference::RangeDifference(const Binding& binding)
    : sensor_(binding, "position"),
      anchors_(binding, sensor_, Anchors::From::config),
      bias_(binding.port("bias")),
      difference_(binding.row_field("range_difference")),
      anchor_(binding.row_field("anchor")),
      reference_(binding.row_field("reference")),
      most_(std::min(anchors_.count() - 1, limit)) {
  if (anchors_.count() < 2) throw ComponentError("a difference needs two anchors; one is listed", "/anchors");
  if (binding.parameters().has("reference"))
    fixed_reference_ = anchors_.listed_key(binding.parameters().integer("reference"), "/reference");
  if (fixed_reference_.has_value() == reference_.is_bound())
    throw ComponentError(reference_.is_bound()
                             ? "the channel carries the field 'reference' too: it would be a second one"
                             : "missing key 'reference': the channel carries no field 'reference' either",
                         reference_.is_bound() ? "/reference" : "");
  if (binding.parameters().has("sigma"))
    variance_ = binding.parameters().number("sigma") * binding.parameters().number("sigma");
  else if (!anchors_.have_variance())
    throw ComponentError("missing key 'sigma': not each of 'anchors' has one", "");
  if (bias_.is_bound() && bias_.dof() != anchors_.count())
    throw ComponentError("its block has " + std::to_string(bias_.dof()) + " components where 'anchors' lists " +
                             std::to_string(anchors_.count()) + "; a difference does not contain a common bias",
                         "/blocks/bias");
  declaration_.rows(most_).reads(sensor_.port()).reads(bias_).group(rows::like("range_difference", "m"));
}

bool RangeDifference::arrive(const MeasurementInput& in, const strapdown::CartesianPlace& place,
                             Arrival& arrival) const {
  const Eigen::Vector3d d = place.r - arrival.anchor.r;
  const double length = d.norm();
  if (!(length > nearest_of_pair) || !std::isfinite(length)) {
    in.notes.leave("a row is left out: the sensor is at an anchor, or its position is not finite");
    return false;
  }
  const int bias = bias_.is_bound() ? arrival.anchor.index : -1;
  arrival.range = length + arrival.anchor.bias + (bias >= 0 ? in.x[bias_][bias] : 0.0);
  arrival.variance = arrival.anchor.variance > 0 ? arrival.anchor.variance : variance_;
  arrival.by_error = d.transpose() / length * place.by_error;
  return true;
}

std::optional<RangeDifference::Pair> RangeDifference::pair(const MeasurementInput& in,
                                                           const strapdown::CartesianPlace& place, int row) const {
  const auto of = anchors_.sight(in, row, anchor_);
  const auto reference =
      fixed_reference_ ? anchors_.sight(in.notes, *fixed_reference_) : anchors_.sight(in, row, reference_);
  if (!of || !reference) return std::nullopt;
  if (!std::isfinite(in.sample(row, difference_))) {
    in.notes.leave("a row is left out: its difference is not finite");
    return std::nullopt;
  }
  Pair pair{{*of, 0, 0, {}}, {*reference, 0, 0, {}}};
  if (!arrive(in, place, pair.of) || !arrive(in, place, pair.reference)) return std::nullopt;
  return pair;
}

Result RangeDifference::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const strapdown::CartesianPlace place = sensor_.at(in.x);
  const MatrixView by_position = out.H[sensor_.port()], by_bias = out.H[bias_];
  Pairs pairs;
  Groups groups;
  int count = 0;
  for (int row = 0; row < in.sample.rows && count < most_; ++row) {
    const std::optional<Pair> next = pair(in, place, row);
    if (!next) continue;
    const auto& [of, reference] = *next;
    if (!groups.join(of.anchor.key, reference.anchor.key)) {
      in.notes.leave("a row is left out: its difference is a sum of others of this sample and has no information");
      continue;
    }
    pairs[static_cast<std::size_t>(count)] = *next;
    out.residual[count] = in.sample(row, difference_) - (of.range - reference.range);
    out.row_keys[static_cast<std::size_t>(count)] =
        fixed_reference_ ? of.anchor.key : of.anchor.key * 1000 + reference.anchor.key;
    if (by_position) sensor_.write(by_position, count, of.by_error - reference.by_error);
    if (by_bias) by_bias(count, of.anchor.index) = 1, by_bias(count, reference.anchor.index) = -1;
    for (int other = 0; other <= count; ++other) {
      const auto& [a, c] = pairs[static_cast<std::size_t>(other)];
      const auto shared = [](const Arrival& x, const Arrival& y) {
        return x.anchor.key == y.anchor.key ? x.variance : 0.0;
      };
      out.R(count, other) = out.R(other, count) =
          shared(of, a) + shared(reference, c) - shared(of, c) - shared(reference, a);
    }
    ++count;
  }
  out.rows = count;
  return count > 0 ? Result::ok() : Result::unsupported("no row has a difference that can be used");
}

}  // namespace binnacle::aiding
