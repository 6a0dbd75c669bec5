// SPDX-License-Identifier: Apache-2.0
// Points outside: geodetic, earth-centred or local coordinates, in the axes in which a sensor's place is.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/binding.hpp"
#include "binnacle/local_axes.hpp"
#include "binnacle/model_input.hpp"
#include "binnacle/spec.hpp"
#include "strapdown/place.hpp"

namespace binnacle::aiding {

/// `lat lon height`, `x y z` or `north east down`: names in this order, units rad or m.
const std::array<const char*, 3>& coordinate_names(strapdown::PlaceKind kind);
/// The members of a config's object that places a point: all three ways, each optional.
std::vector<ParameterSpec> point_parameters();

/// A point as it is given.
struct Point {
  strapdown::PlaceKind kind;
  Eigen::Vector3d coordinates;
};

/// The place of the sensor, by its port, and the axes that it brings: those of strapdown::cartesian(). A local place is in
/// north, east, down of parameter::origin(), which is needed only where a point is given in other coordinates.
class SensorPlace {
 public:
  /// Throws at `/blocks/PORT` for a block that is no place. The component declares parameter::origin().
  SensorPlace(const Binding& binding, const char* port);

  Port port() const noexcept { return port_; }
  strapdown::PlaceKind kind() const noexcept { return kind_; }
  strapdown::CartesianPlace at(const PortValues& x) const { return strapdown::cartesian(kind_, x[port_]); }
  /// ∂/∂δ of the port by ∂/∂r, of as many components as it has.
  void write(MatrixView H, int row, const Eigen::RowVector3d& by_error) const {
    for (int i = 0; i < port_.dof(); ++i) H(row, i) = by_error[i];
  }
  /// Throws at `pointer` where points of this kind cannot be brought into the sensor's axes.
  void demand(strapdown::PlaceKind given, const std::string& pointer) const;
  /// In the sensor's axes [m].
  Eigen::Vector3d bring(const Point& point) const;
  /// An object of point_parameters(). nullopt: it places nothing. Throws where it does so by halves or twice.
  std::optional<Point> read(const Parameters& object, const std::string& pointer) const;

 private:
  Port port_;
  strapdown::PlaceKind kind_ = strapdown::PlaceKind::local;
  std::optional<geodesy::LocalAxes> local_;
};

}  // namespace binnacle::aiding
