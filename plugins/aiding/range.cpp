// SPDX-License-Identifier: Apache-2.0
// Distances to points that are known.
#include "range.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace binnacle::aiding {

namespace {

constexpr double nearest_anchor = 1e-3;  // m: nearer to an anchor there is no direction

}  // namespace

ComponentSpec Range::spec() {
  using parameter::integer, parameter::number;
  ComponentSpec spec;
  spec.type = "range";
  spec.summary = "Distances to known points such as ultra-wideband anchors or acoustic transponders, a row for each.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 7.1.4";
  spec.parameters = {number("sigma", "m")
                         .above(0)
                         .plausible(1e-4, 1e4)
                         .about("standard deviation of a range's white noise; not needed if each anchor or the channel "
                                "(range_sd, range_variance) has one"),
                     number("relative", "1")
                         .at_least(0)
                         .defaults("0")
                         .about("relative noise: adds (relative * range)^2 to each variance"),
                     Anchors::parameter(), parameter::origin(),
                     integer("max_rows")
                         .at_least(1)
                         .at_most(256)
                         .defaults("16")
                         .about("largest number of rows used of a sample; if 'anchors' lists some, their number")};
  spec.ports = {
      reads("position", "*").about("position of the sensor: kind position, position.ecef, vector:2:m or vector:3:m"),
      reads("bias", "vector:*:m")
          .optional()
          .about("bias of the measured ranges: one for each of 'anchors', in their order, or one for all")};
  spec.fields = {field::level("range", "m").per_row().about("measured distance"),
                 field::level("anchor", "1").per_row().optional().about("number of the anchor"),
                 field::level("range_sd", "m").per_row().optional().about("its standard deviation"),
                 field::level("range_variance", "m^2").per_row().optional().about("variance of the range")};
  for (FieldSpec& field : Anchors::place_fields()) spec.fields.push_back(std::move(field));
  spec.example = R"json({"channel": "uwb", "blocks": {"position": "position", "bias": "range_bias"}, "sigma": "0.1 m",
    "anchors": {"105": {"lat": "52.5 deg", "lon": "13.4 deg", "height": "81 m"},
                "107": {"lat": "52.5001 deg", "lon": "13.4 deg", "height": "84 m", "bias": "5 cm"},
                "108": {"lat": "52.5 deg", "lon": "13.4002 deg", "height": "82 m", "sigma": "0.2 m"}},
    "noise": {"type": "huber", "by": "row"}})json";
  spec.surroundings = R"json({"sources": {"uwb": {"type": "core/pushed", "max_rows": 3, "fields": {
      "range": {"unit": "m", "per_row": true}, "anchor": {"unit": "1", "per_row": true}}}},
    "blocks": {
    "position": {"type": "navigation/position", "init": {"lat": "52.50003 deg", "lon": "13.40006 deg", "height": "80 m"}, "sigma": 0.5},
    "range_bias": {"type": "vector", "size": 3, "unit": "m", "sigma": 0.1}},
    "sample": {"range": [5.4, 9.4, 10.3], "anchor": [105, 107, 108]}})json";
  return spec;
}

Range::Range(const Binding& binding)
    : sensor_(binding, "position"),
      anchors_(binding, sensor_, Anchors::From::rows),
      bias_(binding.port("bias")),
      range_(binding.row_field("range")),
      anchor_(binding.row_field("anchor")),
      sd_of_row_(binding.row_field("range_sd")),
      variance_of_row_(binding.row_field("range_variance")),
      relative_(binding.parameters().number("relative")),
      most_(anchors_.count() > 0 ? anchors_.count() : static_cast<int>(binding.parameters().integer("max_rows"))) {
  if (!anchor_.is_bound() && anchors_.count() > 1)
    throw ComponentError("the channel carries no field 'anchor', and 'anchors' lists " +
                             std::to_string(anchors_.count()) + ": a range has no anchor",
                         "/fields");
  if (sd_of_row_.is_bound() && variance_of_row_.is_bound())
    throw ComponentError("the channel carries both 'range_sd' and 'range_variance': recognize one of them", "/fields");
  if (binding.parameters().has("sigma")) {
    variance_ = binding.parameters().number("sigma") * binding.parameters().number("sigma");
  } else if (!anchors_.have_variance() && !sd_of_row_.is_bound() && !variance_of_row_.is_bound()) {
    throw ComponentError("missing key 'sigma': neither the channel nor each anchor has one", "");
  }
  anchors_.check_bias(bias_);
  declaration_.rows(most_).reads(sensor_.port()).reads(bias_).group(rows::like("range", "m"));
}

double Range::variance(const SampleView& sample, int row, const AnchorSight& anchor) const {
  double variance = anchor.variance > 0 ? anchor.variance : variance_;
  if (sd_of_row_.is_bound()) {
    const double sigma = sample(row, sd_of_row_);
    if (!std::isnan(sigma)) variance = sigma > 0 ? sigma * sigma : -1;
  } else if (variance_of_row_.is_bound() && !std::isnan(sample(row, variance_of_row_))) {
    variance = sample(row, variance_of_row_);
  }
  const double by_length = relative_ * sample(row, range_);
  return variance > 0 ? variance + by_length * by_length : -1;
}

Result Range::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const strapdown::CartesianPlace place = sensor_.at(in.x);
  const MatrixView by_position = out.H[sensor_.port()], by_bias = out.H[bias_];
  int count = 0;
  for (int row = 0; row < in.sample.rows; ++row) {
    const std::optional<AnchorSight> anchor = anchors_.sight(in, row, anchor_);
    if (!anchor) continue;
    const auto keys = out.row_keys.begin();
    if (std::find(keys, keys + count, anchor->key) != keys + count) {
      in.notes.leave("a row is left out: its anchor has one in this sample already");
      continue;
    }
    if (count == most_) {
      in.notes.leave("rows are left out: a sample has more than 'max_rows'");
      break;
    }
    const double z = in.sample(row, range_), variance = this->variance(in.sample, row, *anchor);
    if (!std::isfinite(z) || !(variance > 0) || !std::isfinite(variance)) {
      in.notes.leave("a row is left out: its range is not finite, or its variance not positive and finite");
      continue;
    }
    const Eigen::Vector3d d = place.r - anchor->r;
    const double length = d.norm();
    if (!(length > nearest_anchor) || !std::isfinite(length)) {
      in.notes.leave("a row is left out: the sensor is at the anchor, or its position is not finite");
      continue;
    }
    const int bias = bias_.is_bound() ? Anchors::bias_component(bias_, *anchor) : -1;
    out.residual[count] = z - (length + anchor->bias + (bias >= 0 ? in.x[bias_][bias] : 0.0));
    out.R(count, count) = variance;
    out.row_keys[static_cast<std::size_t>(count)] = anchor->key;
    if (by_position) sensor_.write(by_position, count, d.transpose() / length * place.by_error);
    if (by_bias && bias >= 0) by_bias(count, bias) = 1;
    ++count;
  }
  out.rows = count;
  return count > 0 ? Result::ok() : Result::unsupported("no row has a range to an anchor that can be used");
}

}  // namespace binnacle::aiding
