// SPDX-License-Identifier: Apache-2.0
// How a cell's charge and its RC voltage follow the current.
#pragma once

#include <binnacle/plugin.hpp>

#include <cmath>

/// First-order Thevenin model: a source OCV(s), a resistor R0 and one RC pair in series; I > 0 discharges.
///
///     ds/dt = −η I / Q,   dv/dt = −v / (R1 C1) + I / C1      η = 1 while discharging, the coulombic efficiency else
///
/// With I constant over dt and a = exp(−dt/(R1 C1)):
///
///     s⁺ = s − η I dt / Q,   v⁺ = a v + R1 (1 − a) I,   Φ = diag(1, a).
///
/// White noise n of the measured current, E[n n] = q² δ(t), moves both: ∫ −(η/Q) n and ∫ e^{−(dt−t)/τ} n / C1 have
///
///     Qss = (η/Q)² q² dt,   Qvv = (q/C1)² τ (1 − a²)/2,   Qsv = −(η/Q) (q²/C1) τ (1 − a),   τ = R1 C1.
class Thevenin final : public binnacle::ProcessModel {
 public:
  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    using namespace binnacle::parameter;
    ComponentSpec spec;
    spec.type = "thevenin";
    spec.summary = "State of charge and RC voltage of a battery cell, driven by its current.";
    spec.source =
        "Plett, Extended Kalman filtering for battery management systems of LiPB-based HEV battery packs, Part 2, "
        "J. Power Sources 134, 2004";
    spec.parameters = {
        number("capacity", "A*s").above(0).required().about("Q, charge between empty and full"),
        number("r1", "V/A").above(0).required().about("resistor of the RC pair"),
        number("c1", "A*s/V").above(0).required().about("capacitor of the RC pair"),
        number("coulombic_efficiency", "1")
            .above(0)
            .at_most(1)
            .defaults("1")
            .about("share of the charge that stays while charging"),
        number("current_noise", "A/sqrt(Hz)")
            .at_least(0)
            .defaults("0")
            .about("q, root of the power spectral density of the current sensor's white noise"),
        number("soc_noise", "1/sqrt(s)").at_least(0).defaults("0").about("what else makes the charge wander"),
        number("rc_noise", "V/sqrt(s)").at_least(0).defaults("0").about("what else makes the RC voltage wander")};
    spec.ports = {advances("soc", "vector:1:1", "state of charge, 0 empty, 1 full"),
                  advances("rc", "vector:1:V", "voltage over the RC pair, positive after a discharge")};
    spec.fields = {field::rate("current", "A").about("out of the cell; negative while charging")};
    spec.example = R"json({"input": "current", "blocks": {"soc": "soc", "rc": "rc"}, "capacity": "2.5 A*h",
      "r1": "15 mV/A", "c1": "2000 A*s/V", "coulombic_efficiency": 0.99, "current_noise": "0.05 A/sqrt(Hz)",
      "soc_noise": "1 ppm/sqrt(s)", "rc_noise": "10 uV/sqrt(s)"})json";
    spec.surroundings = R"json({"blocks": {
      "soc": {"type": "vector", "size": 1, "unit": "1", "init": {"x": 0.5}, "sigma": 0.05},
      "rc": {"type": "vector", "size": 1, "unit": "V", "sigma": "20 mV"}}})json";
    return spec;
  }

  explicit Thevenin(const binnacle::Binding& b)
      : soc_(b.port("soc")),
        rc_(b.port("rc")),
        current_(b.field("current")),
        capacity_(b.parameters().number("capacity")),
        r1_(b.parameters().number("r1")),
        c1_(b.parameters().number("c1")),
        efficiency_(b.parameters().number("coulombic_efficiency")),
        q_(squared(b.parameters().number("current_noise"))),
        q_soc_(squared(b.parameters().number("soc_noise"))),
        q_rc_(squared(b.parameters().number("rc_noise"))) {
    phi_vv_ = declaration_.couples(rc_, rc_);  // that of soc on itself is 1: nothing to list
    q_ss_ = declaration_.adds_noise(soc_, soc_);
    q_sv_ = declaration_.adds_noise(soc_, rc_);
    q_vv_ = declaration_.adds_noise(rc_, rc_);
  }

  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    double s = in.x[soc_][0], v = in.x[rc_][0], phi = 1;
    Noise noise;
    for (const auto& sample : in.step.samples) {
      const double I = sample[current_], dt = sample.dt;
      const double loss = (I < 0 ? efficiency_ : 1) / capacity_;  // of charge per charge that flows [1/(A s)]
      const double a = std::exp(-dt / tau()), one_minus_a = -std::expm1(-dt / tau());
      s -= loss * I * dt;
      v = a * v + r1_ * one_minus_a * I;
      phi *= a;
      noise = after(noise, loss, a, one_minus_a, dt);
    }
    if (!std::isfinite(s) || !std::isfinite(v) || !std::isfinite(noise.vv))
      return binnacle::Result::failed("a current or a step beyond all numbers");
    out.x[soc_][0] = s;
    out.x[rc_][0] = v;
    if (auto Phi = out.phi[phi_vv_]) Phi.as<1, 1>()(0) = phi;
    if (out.Qd) {
      out.Qd[q_ss_].as<1, 1>()(0) = noise.ss;
      out.Qd[q_sv_].as<1, 1>()(0) = noise.sv;
      out.Qd[q_vv_].as<1, 1>()(0) = noise.vv;
    }
    return binnacle::Result::ok();
  }

 private:
  struct Noise {
    double ss = 0, sv = 0, vv = 0;  // 1, V, V²
  };

  static double squared(double x) { return x * x; }
  double tau() const { return r1_ * c1_; }

  /// Φ Q Φᵀ + Qd of one more sample.
  Noise after(const Noise& before, double loss, double a, double one_minus_a, double dt) const {
    const double half = tau() * -std::expm1(-2 * dt / tau()) / 2;  // ∫ e^{−2t/τ} dt [s]
    return {before.ss + squared(loss) * q_ * dt + q_soc_ * dt, a * before.sv - loss * q_ / c1_ * tau() * one_minus_a,
            a * a * before.vv + (q_ / squared(c1_) + q_rc_) * half};
  }

  binnacle::Port soc_, rc_;
  binnacle::Field current_;
  binnacle::PhiBlock phi_vv_;
  binnacle::QBlock q_ss_, q_sv_, q_vv_;
  double capacity_, r1_, c1_, efficiency_;  // A s, V/A, A s/V, 1
  double q_, q_soc_, q_rc_;                 // A²/Hz, 1/s, V²/s
};
