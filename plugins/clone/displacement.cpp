// SPDX-License-Identifier: Apache-2.0
// Displacements along a path that is known: what measures them, simulated.
#include "displacement.hpp"

#include <utility>

#include "binnacle/geodesy.hpp"
#include "elapsed.hpp"
#include "random/normal.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::clone {

namespace {

using Eigen::Map;
using Eigen::Vector3d;
using Eigen::Vector4d;

FieldSpec place(const char* name, const char* unit, const char* text) {
  return field::level(name, unit).optional().about(text);
}

}  // namespace

ComponentSpec Displacement::spec() {
  ComponentSpec spec;
  spec.type = "displacement";
  spec.summary = "Displacements along a known path with noise: simulated visual odometry or scan matching.";
  spec.parameters = {
      parameter::time("every").above(0).required().about("shortest interval"),
      parameter::choice("frame", {"body", "navigation", "ecef"})
          .defaults("\"body\"")
          .about("axes of the displacement: those of the body at the start of the interval; north, east, down there "
                 "(the axes of a local path); or earth-centred"),
      parameter::vector("lever_arm", "m", 3)
          .plausible(0, 100)
          .defaults("[0, 0, 0]")
          .about("lever arm from the point of the path to the sensor, body axes"),
      parameter::vector("sigma", "m", 3).at_least(0).defaults("0").about("standard deviation of the noise, by axis"),
      parameter::number("relative", "1")
          .at_least(0)
          .defaults("0")
          .about("relative noise: adds (relative * length of the displacement)^2 to each variance")};
  spec.inputs = {
      input("path",
            {place("lat", "rad", "geodetic latitude, WGS-84; alternative to x y z"),
             place("lon", "rad", "longitude, east positive"), place("height", "m", "height above the ellipsoid"),
             place("x", "m", "position in local axes"), place("y", "m", "position in local axes"),
             place("z", "m", "position in local axes"), place("roll", "rad", "attitude, for body axes"),
             place("pitch", "rad", "attitude"), place("yaw", "rad", "attitude")})
          .about("position and attitude over time, for example the truth of a simulation")};
  spec.example = R"json({"input": "drive.truth", "every": "1 s", "sigma": "3 cm"})json";
  return spec;
}

Displacement::Displacement(const Binding& binding)
    : every_(binding.parameters().time("every")),
      is_in_body_axes_(binding.parameters().text("frame") == "body"),
      is_in_ecef_(binding.parameters().text("frame") == "ecef"),
      sigma_(binding.parameters().vector("sigma")),
      lever_arm_(binding.parameters().vector("lever_arm")),
      relative_(binding.parameters().number("relative")) {
  const Input path = binding.input("path");
  geodetic_ = binding.fields(path, "lat", "lon", "height");
  local_ = binding.fields(path, "x", "y", "z");
  angles_ = binding.fields(path, "roll", "pitch", "yaw");
  if (!geodetic_.is_bound() && !local_.is_bound())
    throw ComponentError("the path has no position: neither lat, lon, height nor x, y, z", "/input");
  if (is_in_body_axes_ && !angles_.is_bound())
    throw ComponentError("body axes need roll, pitch and yaw of the path; or say \"frame\": \"navigation\"", "/input");
  needs_attitude_ = is_in_body_axes_ || !lever_arm_.isZero(0.0);
  if (needs_attitude_ && !angles_.is_bound())
    throw ComponentError("a lever arm needs roll, pitch and yaw of the path", "/lever_arm");
  if (is_in_ecef_ && !geodetic_.is_bound())
    throw ComponentError("\"frame\": \"ecef\" is for a path on the earth: lat, lon, height", "/frame");
  ChannelDeclaration displacement, velocity("velocity");
  displacement.max_interval = velocity.max_interval = every_;
  const auto way = [](const char* name) { return field::increment(name, "m").about("displacement over the interval"); };
  const auto sd = [](const char* name) { return field::level(name, "m").about("its standard deviation"); };
  const auto mean = [](const char* name) { return field::rate(name, "m/s").about("displacement by the interval"); };
  d_ = displacement.carries(way("dx"), way("dy"), way("dz"));
  if (sigma_.minCoeff() > 0) d_sigma_ = displacement.carries(sd("dx_sd"), sd("dy_sd"), sd("dz_sd"));
  v_ = velocity.carries(mean("vx"), mean("vy"), mean("vz"));
  displacement_ = declaration_.emits(std::move(displacement));
  velocity_ = declaration_.emits(std::move(velocity));
  memory_ = declaration_.keeps<Memory>();
}

void Displacement::initialise(std::uint64_t seed, const MemoryView& memory) const {
  memory[memory_].random = random::stream(seed, "displacement");
}

Vector3d Displacement::position(const SampleView& sample, const Vector4d& attitude) const {
  const Vector3d place = sample[geodetic_.is_bound() ? geodetic_ : local_];
  if (lever_arm_.isZero(0.0)) return place;
  const Vector3d lever_arm_n = strapdown::dcm_from_quaternion(attitude) * lever_arm_;
  return geodetic_.is_bound() ? geodesy::position_plus(place, lever_arm_n) : Vector3d(place + lever_arm_n);
}

Vector3d Displacement::way(const Memory& from, const Vector3d& to) const {
  const Map<const Vector3d> then(from.position);
  if (is_in_ecef_) return geodesy::ecef_from_lla(to) - geodesy::ecef_from_lla(then);
  const Vector3d d = geodetic_.is_bound() ? Vector3d(geodesy::C_en(then[0], then[1]).transpose() *
                                                     (geodesy::ecef_from_lla(to) - geodesy::ecef_from_lla(then)))
                                          : Vector3d(to - then);
  if (!is_in_body_axes_) return d;
  return strapdown::dcm_from_quaternion(Map<const Vector4d>(from.attitude)).transpose() * d;
}

void Displacement::on(const TransformInput& in, Emitter& emitter) const {
  Memory& memory = in.memory[memory_];
  const SampleView& sample = in.sample;
  const Vector3d angles = needs_attitude_ ? sample[angles_] : Vector3d::Zero();
  const Vector4d attitude = strapdown::quaternion_from_euler(angles);
  const Vector3d here = position(sample, attitude);
  // A sample that is not complete begins and ends nothing.
  if (!here.allFinite() || !angles.allFinite()) return;
  const bool begins = memory.t == no_time || sample.t < memory.t;
  const Time length = elapsed(memory.t, sample.t);
  if (!begins && length < every_) return;
  if (!begins) {
    Vector3d d = way(memory, here);
    const double squares = relative_ * relative_ * d.squaredNorm();
    const Vector3d sigma = (sigma_.array().square() + squares).sqrt();
    for (int i = 0; i < 3; ++i) d[i] += sigma[i] * random::normal(memory.random);
    SampleWriter& displacement = emitter.on(displacement_);
    SampleWriter& velocity = emitter.on(velocity_);
    displacement.t = velocity.t = sample.t;
    displacement.t0 = velocity.t0 = memory.t;
    displacement[d_] = d;
    if (d_sigma_.is_bound()) displacement[d_sigma_] = sigma;
    velocity[v_] = d / seconds(length);
    emitter.emit(displacement_);
    emitter.emit(velocity_);
  }
  memory.t = sample.t;
  Map<Vector3d>(memory.position) = here;
  if (is_in_body_axes_) Map<Vector4d>(memory.attitude) = attitude;
}

}  // namespace binnacle::clone
