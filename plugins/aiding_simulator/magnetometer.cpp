// SPDX-License-Identifier: Apache-2.0
// A magnetometer of three axes.
#include <cmath>

#include "binnacle/eigen.hpp"
#include "sensor.hpp"

namespace binnacle::aiding_simulator {

namespace {

using Eigen::Vector3d;

/// b = S C_bn m + h + n, S = I + symmetric (xx yy zz xy xz yz).
class Magnetometer final : public Sensor {
 public:
  explicit Magnetometer(const Parameters& parameters)
      : noise_(parameters.vector("noise")),
        hard_iron_(parameters.number("hard_iron")),
        soft_iron_(parameters.number("soft_iron")),
        cross_axis_(parameters.number("cross_axis")) {
    const double declination = parameters.number("declination"), inclination = parameters.number("inclination");
    field_n_ =
        parameters.number("strength") * Vector3d(std::cos(inclination) * std::cos(declination),
                                                 std::cos(inclination) * std::sin(declination), std::sin(inclination));
  }
  void declare(ChannelDeclaration& channel) override {
    b_ = channel.carries(field::level("mx", "T").about("magnetic flux density along body x, forward"),
                         field::level("my", "T").about("right"), field::level("mz", "T").about("down"));
  }
  std::vector<SlowError> errors() const override {
    std::vector<SlowError> all;
    for (const char* name : {"hx", "hy", "hz"}) all.push_back({name, "T", "hard iron", hard_iron_});
    for (const char* name : {"sxx", "syy", "szz"}) all.push_back({name, "1", "soft iron and scale", soft_iron_});
    for (const char* name : {"sxy", "sxz", "syz"}) all.push_back({name, "1", "soft iron across axes", cross_axis_});
    return all;
  }
  void measure(const Truth& truth, std::span<const double> e, Noise& noise, SampleWriter& out) const override {
    const Vector3d m = truth.C_nb.transpose() * field_n_;
    const Vector3d n = noise.next3();
    out[b_] = Vector3d(m[0] + e[3] * m[0] + e[6] * m[1] + e[7] * m[2] + e[0] + noise_[0] * n[0],
                       m[1] + e[6] * m[0] + e[4] * m[1] + e[8] * m[2] + e[1] + noise_[1] * n[1],
                       m[2] + e[7] * m[0] + e[8] * m[1] + e[5] * m[2] + e[2] + noise_[2] * n[2]);
  }

 private:
  Vector3d noise_, field_n_;
  double hard_iron_, soft_iron_, cross_axis_;
  OutputFields<3> b_;
};

}  // namespace

SensorKind magnetometer() {
  using namespace parameter;
  return {
      "magnetometer",
      sensor_object("magnetometer",
                    {number("declination", "rad").defaults("0").about("declination of the field, from north to east"),
                     number("inclination", "rad")
                         .at_least(-1.6)
                         .at_most(1.6)
                         .defaults("0")
                         .about("inclination of the field, below the horizon"),
                     number("strength", "T")
                         .above(0)
                         .plausible(1e-6, 1e-3)
                         .defaults("\"50 uT\"")
                         .about("magnetic flux density of the field"),
                     vector("noise", "T", 3).at_least(0).defaults("0").about("1-sigma of the white noise, by axis"),
                     number("hard_iron", "T")
                         .at_least(0)
                         .defaults("0")
                         .about("1-sigma of the three components, drawn once per run"),
                     number("soft_iron", "1")
                         .at_least(0)
                         .defaults("0")
                         .about("1-sigma of the three diagonal elements, drawn once per run"),
                     number("cross_axis", "1")
                         .at_least(0)
                         .defaults("0")
                         .about("1-sigma of the three elements between two axes, drawn once per run")},
                    "magnetometer with three axes, on the channel NAME.magnetometer: mx, my, mz"),
      [](const Parameters& parameters) { return std::make_unique<Magnetometer>(parameters); }};
}

}  // namespace binnacle::aiding_simulator
