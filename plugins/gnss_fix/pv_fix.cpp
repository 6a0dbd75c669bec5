// SPDX-License-Identifier: Apache-2.0
// Position and velocity of a GNSS filter, with their full covariance: loose coupling.
#include "pv_fix.hpp"

#include <string>

#include "strapdown/earth.hpp"

namespace binnacle::gnss_fix {

namespace {

using Eigen::Matrix3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr const char* names[6] = {"x", "y", "z", "vx", "vy", "vz"};

}  // namespace

ComponentSpec PvFix::spec() {
  ComponentSpec spec;
  spec.type = "pv_fix";
  spec.summary =
      "Position and velocity in ECEF axes from a GNSS filter, with the full covariance of the six components.";
  spec.source = "paper 003, section 4.2 and equation (11)";
  spec.parameters = {parameter::list("covariance", parameter::text("component"))
                         .defaults(
                             R"(["position.x", "position.y", "position.z", "velocity.x", "velocity.y", "velocity.z"])")
                         .about("error components of the channel for x y z vx vy vz, as BLOCK.COMPONENT of the filter"),
                     parameter::number("inflate", "1")
                         .at_least(1)
                         .defaults("1")
                         .about("factor on the covariance, because a filter's errors are correlated in time and its "
                                "covariance does not show this")};
  spec.ports = {
      reads("position", "position").about("position of the antenna: a position block, or a lever_arm"),
      reads("velocity", "velocity.ned").about("velocity of the antenna: a velocity block, or a lever_arm_velocity")};
  for (int i = 0; i < 6; ++i)
    spec.fields.push_back(field::level(names[i], i < 3 ? "m" : "m/s").about(i < 3 ? "ECEF position" : "ECEF velocity"));
  spec.example = R"json({"channel": "gps", "blocks": {"position": "position", "velocity": "velocity"},
    "fields": {"x": "position.x", "y": "position.y", "z": "position.z", "vx": "velocity.vx", "vy": "velocity.vy", "vz": "velocity.vz"}})json";
  spec.surroundings = R"json({"sources": {"gps": {"type": "core/pushed",
      "fields": {"position.x": {"unit": "m"}, "position.y": {"unit": "m"}, "position.z": {"unit": "m"},
                 "velocity.vx": {"unit": "m/s"}, "velocity.vy": {"unit": "m/s"}, "velocity.vz": {"unit": "m/s"}},
      "covariance": ["position.x", "position.y", "position.z", "velocity.x", "velocity.y", "velocity.z"]}},
    "sample": {"x": -3976219.1, "y": 3382371.6, "z": 3652511.2, "vx": 5, "vy": -3, "vz": 2}})json";
  return spec;
}

PvFix::PvFix(const Binding& binding)
    : position_(binding.port("position")),
      velocity_(binding.port("velocity")),
      z_(binding.fields("x", "y", "z", "vx", "vy", "vz")),
      scale_(binding.parameters().number("inflate")) {
  declaration_.rows(6).reads(position_).reads(velocity_);
  declaration_.group(rows::of("position", position_)).group(rows::of("velocity", velocity_));

  const auto& there = binding.covariance();
  covariance_size_ = static_cast<int>(there.size());
  const auto& wanted = binding.parameters().list("covariance");
  if (wanted.size() != 6) throw ComponentError("six error components, of x y z vx vy vz", "/covariance");
  if (there.empty()) throw ComponentError("the channel attaches no covariance to its samples");
  for (std::size_t i = 0; i < 6; ++i) {
    components_[i] = -1;
    std::string all;
    for (std::size_t k = 0; k < there.size(); ++k) {
      if (there[k].name == wanted[i].text) components_[i] = static_cast<int>(k);
      all += (k ? ", " : "") + there[k].name;
    }
    if (components_[i] < 0)
      throw ComponentError("the channel's covariance has no component '" + wanted[i].text + "' for " + names[i] +
                               "; it has " + all,
                           "/covariance/" + std::to_string(i));
  }
}

Result PvFix::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const auto z = in.sample[z_];
  if (!z.allFinite()) return Result::invalid("a position or velocity is not finite");
  if (!in.sample.covariance) return Result::unsupported("the sample comes without a covariance");
  if (!(z.head<3>().norm() > 6.3e6 && z.head<3>().norm() < 1e8))
    return Result::invalid("the position is not near the earth");
  const Eigen::Vector3d lla = strapdown::lla_from_ecef(z.head<3>());
  const Matrix3d C_ne = strapdown::C_en(lla[0], lla[1]).transpose();
  out.rows = 6;
  out.residual.segment(0, 3).as<3>() = strapdown::position_minus(lla, in.x[position_].as<3>());
  out.residual.segment(3, 3).as<3>() = C_ne * z.tail<3>() - in.x[velocity_].as<3>();
  if (const MatrixView H = out.H[position_]) H.as<6, 3>().topRows<3>().setIdentity();
  if (const MatrixView H = out.H[velocity_]) H.as<6, 3>().bottomRows<3>().setIdentity();

  Matrix6d sigma;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 6; ++i)
      sigma(i, j) = in.sample.covariance[components_[static_cast<std::size_t>(i)] +
                                         components_[static_cast<std::size_t>(j)] * covariance_size_];
  if (!sigma.allFinite() || !(sigma.diagonal().array() > 0).all())
    return Result::invalid("a variance of its covariance is 0, negative or not finite");
  auto R = out.R.as<6, 6>();
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i)
      R.block<3, 3>(3 * i, 3 * j) = scale_ * (C_ne * sigma.block<3, 3>(3 * i, 3 * j) * C_ne.transpose());
  R = (0.5 * (R + R.transpose())).eval();
  return Result::ok();
}

}  // namespace binnacle::gnss_fix
