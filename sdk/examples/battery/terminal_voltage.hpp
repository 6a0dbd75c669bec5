// SPDX-License-Identifier: Apache-2.0
// What the terminals show of a cell's state.
#pragma once

#include <binnacle/plugin.hpp>

#include <cmath>

#include "ocv_curve.hpp"
#include "thevenin.hpp"

/// z = OCV(s) − v − (R0 + ρ) I + n: s and v as in thevenin, ρ a correction to R0 that a filter may estimate, I the mean
/// current of the last driving interval.
///
///     H_s = OCV'(s),   H_v = −1,   H_ρ = −I,   R = σ² + (R0 σ_I)²
///
/// σ_I is the noise of that mean current. It is in the process model's step too; their correlation is neglected.
class TerminalVoltage final : public binnacle::MeasurementModel {
 public:
  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    using namespace binnacle::parameter;
    ComponentSpec spec;
    spec.type = "terminal_voltage";
    spec.summary = "The voltage between a battery cell's terminals, under load or at rest.";
    spec.source = Thevenin::spec().source;
    spec.parameters = ocv_curve::parameters();
    spec.parameters.push_back(number("r0", "V/A").at_least(0).required().about("series resistance"));
    spec.parameters.push_back(number("sigma", "V").above(0).required().about("of the voltage sensor's white noise"));
    spec.parameters.push_back(
        number("current_sigma", "A").at_least(0).defaults("0").about("noise of a driving interval's mean current"));
    spec.ports = {reads("soc", "vector:1:1", "state of charge"), reads("rc", "vector:1:V", "voltage over the RC pair"),
                  reads("r0_error", "vector:1:V/A").optional().about("correction to r0, for a cell that ages")};
    spec.fields = {field::level("voltage", "V").about("between the terminals")};
    spec.driving_rates = {field::rate("current", "A").about("out of the cell")};
    spec.example = R"json({"channel": "voltage", "blocks": {"soc": "soc", "rc": "rc", "r0_error": "r0_error"},
      "ocv_soc": [0, 0.1, 0.5, 0.9, 1], "ocv": ["3 V", "3.45 V", "3.7 V", "4.05 V", "4.2 V"], "r0": "20 mV/A",
      "sigma": "5 mV", "current_sigma": "50 mA"})json";
    spec.surroundings = R"json({"blocks": {
      "soc": {"type": "vector", "size": 1, "unit": "1", "init": {"x": 0.4}, "sigma": 0.01},
      "rc": {"type": "vector", "size": 1, "unit": "V", "sigma": "10 mV"},
      "r0_error": {"type": "vector", "size": 1, "unit": "V/A", "sigma": "1 mV/A"}}})json";
    return spec;
  }

  explicit TerminalVoltage(const binnacle::Binding& b)
      : soc_(b.port("soc")),
        rc_(b.port("rc")),
        r0_error_(b.port("r0_error")),
        voltage_(b.field("voltage")),
        current_(b.driving_rate("current")),
        ocv_(ocv_curve::of(b.parameters())),
        r0_(b.parameters().number("r0")),
        variance_(std::pow(b.parameters().number("sigma"), 2) +
                  std::pow(r0_ * b.parameters().number("current_sigma"), 2)) {
    declaration_.rows(1).reads(soc_).reads(rc_).reads(r0_error_).group(binnacle::rows::these("voltage", 1, "V"));
  }

  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    if (!in.u.rates) return binnacle::Result::unsupported("no current has been measured yet");
    const double I = in.u.rates[current_];
    const OcvCurve::Value ocv = ocv_.at(in.x[soc_][0]);
    const double r0 = r0_error_.is_bound() ? r0_ + in.x[r0_error_][0] : r0_;
    const double residual = in.sample[voltage_] - (ocv.volts - in.x[rc_][0] - r0 * I);
    if (!std::isfinite(residual)) return binnacle::Result::invalid("a voltage or a current beyond all numbers");
    out.rows = 1;
    out.residual[0] = residual;
    out.R(0, 0) = variance_;
    if (auto H = out.H[soc_]) H(0, 0) = ocv.slope;
    if (auto H = out.H[rc_]) H(0, 0) = -1;
    if (auto H = out.H[r0_error_]) H(0, 0) = -I;
    return binnacle::Result::ok();
  }

 private:
  binnacle::Port soc_, rc_, r0_error_;
  binnacle::Field voltage_;
  binnacle::DrivingRate current_;
  OcvCurve ocv_;
  double r0_;        // V/A
  double variance_;  // V²
};
