// SPDX-License-Identifier: Apache-2.0
// Anchors: points that are known by a number, from the config or from each row of a sample.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "point.hpp"

namespace binnacle::aiding {

/// An anchor as a row sees it.
struct AnchorSight {
  std::int64_t key = 0;
  int index = -1;       // in the order of 'anchors'; −1: it is not listed
  Eigen::Vector3d r;    // m, in the sensor's axes
  double bias = 0;      // m, of the config
  double variance = 0;  // m², of the config; 0: none is given
};

class Anchors {
 public:
  static ParameterSpec parameter();
  /// Of the anchor's number under `key`, and of its place per row under `anchor_…` if `is_placed`.
  static std::vector<FieldSpec> place_fields();

  /// Where places may come from. `rows`: a row's is taken from the channel where it carries one (place_fields()).
  enum class From { config, rows };
  Anchors(const Binding& binding, const SensorPlace& sensor, From from);

  int count() const noexcept { return static_cast<int>(listed_.size()); }
  bool has_places_of_rows() const noexcept { return row_place_.has_value(); }
  /// Whether each of those listed has a variance.
  bool have_variance() const noexcept;
  /// The number of the anchor in a config; throws at `pointer`.
  std::int64_t listed_key(std::int64_t key, const char* pointer) const;
  /// The anchor with the number that stands in `key` of the row. Where that is open it is the one that there is, or the
  /// row's place has no number and the row's own index stands for it. Null: none, and a note says so.
  std::optional<AnchorSight> sight(const MeasurementInput& in, int row, RowField key) const;
  /// The same of a number.
  std::optional<AnchorSight> sight(const Notes& notes, std::int64_t key) const;

  /// Port of biases: a component for each anchor in the order of 'anchors', or one for all. Throws where it does not fit.
  void check_bias(Port bias) const;
  /// Of the anchor in the port's block; −1: it has none.
  static int bias_component(Port bias, const AnchorSight& sight) { return bias.dof() == 1 ? 0 : sight.index; }

 private:
  struct RowPlace {
    strapdown::PlaceKind kind;
    std::array<RowField, 3> fields;
  };
  void read_listed(const Binding& binding);
  void find_row_place(const Binding& binding);

  SensorPlace sensor_;
  std::vector<AnchorSight> listed_;
  std::optional<RowPlace> row_place_;
};

}  // namespace binnacle::aiding
