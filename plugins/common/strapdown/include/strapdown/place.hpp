// SPDX-License-Identifier: Apache-2.0
// Places as blocks have them (geodetic, earth-centred, local), and the way from one to another.
#pragma once

#include <Eigen/Core>

#include <optional>
#include <string_view>

#include "binnacle/eigen.hpp"
#include "binnacle/view.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/local_axes.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::strapdown {

enum class PlaceKind { geodetic, ecef, local };

/// Of a block: "position" (lat, lon, height; errors north, east, down there), "position.ecef", "vector:1:m" to "vector:3:m"
/// (north, east, down in local axes that do not turn, or whatever axes the vector has). None of another.
inline std::optional<PlaceKind> place_kind(std::string_view kind) {
  if (kind == "position") return PlaceKind::geodetic;
  if (kind == "position.ecef") return PlaceKind::ecef;
  if (kind == "vector:1:m" || kind == "vector:2:m" || kind == "vector:3:m") return PlaceKind::local;
  return std::nullopt;
}

/// A place in Cartesian axes [m]: in ECEF where it is geodetic or ECEF, else in its own axes, and then a vector of fewer
/// components is 0 in those that it lacks.
struct CartesianPlace {
  Eigen::Vector3d r;
  Eigen::Matrix3d by_error;  // ∂r/∂δ; of a local vector its first columns
};

inline CartesianPlace cartesian(PlaceKind kind, ConstVectorView x) {
  if (kind == PlaceKind::geodetic) return {ecef_from_lla(x.as<3>()), C_en(x[0], x[1])};
  CartesianPlace place{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()};
  for (int i = 0; i < x.size(); ++i) place.r[i] = x[i];
  return place;
}

/// The way d [m] from one place to another, and its derivatives by the errors of both.
struct Way {
  Eigen::Vector3d d;
  Eigen::Matrix3d by_from, by_to;
};

/// In Cartesian axes, those of cartesian(), in which both are.
inline Way cartesian_way(const CartesianPlace& from, const CartesianPlace& to) {
  return {to.r - from.r, -from.by_error, to.by_error};
}

/// In north, east, down at the begin; from a local one in its own axes. With C = C_en(from):
///     d = Cᵀ (r_to − r_from)      ∂d/∂δr_to = Cᵀ      ∂d/∂δ_from = −I + [d×] Θ, δ_from in north, east, down
/// Θ (axes_per_metre) is how north, east and down turn as the begin moves.
inline Way navigation_way(PlaceKind kind, ConstVectorView from, const CartesianPlace& to) {
  if (kind == PlaceKind::local) return cartesian_way(cartesian(kind, from), to);
  const bool is_geodetic = kind == PlaceKind::geodetic;
  const Eigen::Vector3d lla = is_geodetic ? Eigen::Vector3d(from.as<3>()) : lla_from_ecef(from.as<3>());
  const Eigen::Vector3d begin = is_geodetic ? ecef_from_lla(lla) : Eigen::Vector3d(from.as<3>());
  const Eigen::Matrix3d C = C_en(lla[0], lla[1]);
  Way way{C.transpose() * (to.r - begin), {}, C.transpose() * to.by_error};
  way.by_from = -Eigen::Matrix3d::Identity() + skew(way.d) * axes_per_metre(lla);
  if (!is_geodetic) way.by_from = (way.by_from * C.transpose()).eval();
  return way;
}

}  // namespace binnacle::strapdown
