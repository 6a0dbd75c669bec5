// SPDX-License-Identifier: Apache-2.0
// A barometer, as a height.
#include "binnacle/eigen.hpp"
#include "sensor.hpp"

namespace binnacle::aiding_simulator {

namespace {

/// z = h + b + s (h − reference) + n.
class Height final : public Sensor {
 public:
  explicit Height(const Parameters& parameters)
      : noise_(parameters.number("noise")),
        scale_(parameters.number("scale")),
        reference_(parameters.number("reference")),
        lever_arm_(parameters.vector("lever_arm")),
        bias_(read_slow_error(parameters, "bias", "bias", "m", "what the reading is too high")) {}
  void declare(ChannelDeclaration& channel) override {
    height_ = channel.carries(field::level("height", "m").about("as a barometer gives it"));
  }
  std::vector<SlowError> errors() const override {
    return {bias_, {"scale", "1", "scale factor error of the height over the reference", scale_}};
  }
  void measure(const Truth& truth, std::span<const double> e, Noise& noise, SampleWriter& out) const override {
    const double h = position_at(truth, lever_arm_)[2];
    out[height_] = h + e[0] + e[1] * (h - reference_) + noise_ * noise.next();
  }

 private:
  double noise_, scale_, reference_;
  Eigen::Vector3d lever_arm_;
  SlowError bias_;
  OutputField height_;
};

}  // namespace

SensorKind height() {
  using namespace parameter;
  std::vector<ParameterSpec> own = {
      number("noise", "m").at_least(0).defaults("0").about("1-sigma of the white noise"),
      number("scale", "1").at_least(0).defaults("0").about("1-sigma of the scale factor error, drawn once per run"),
      number("reference", "m").defaults("0").about("height at which the scale factor has no effect"),
      lever_arm_parameter()};
  add_slow_error(own, "bias", "m", "bias");
  return {"height", sensor_object("height", std::move(own), "barometer, on the channel NAME.height: height"),
          [](const Parameters& parameters) { return std::make_unique<Height>(parameters); }};
}

}  // namespace binnacle::aiding_simulator
