// SPDX-License-Identifier: Apache-2.0
// A pose in the plane whose injected error turns what remains, a derived point on it, ranges to beacons that are seen from it, and a
// linear measurement with any R. A test may light a fuse: CURVED_FUSE holds the address of the number of calls until one throws.
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "binnacle/plugin.hpp"

namespace {

using namespace binnacle;

void spark() {
  const char* const text = std::getenv("CURVED_FUSE");
  if (!text) return;
  long* const fuse = reinterpret_cast<long*>(std::strtoull(text, nullptr, 16));
  if (--*fuse == 0) throw std::runtime_error("the fuse has blown");
}

/// (north, east, heading) and an error (a, b, φ) in its own axes: x ⊞ δ = x · Exp(δ) of SE(2).
class Pose final : public StateBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "curved_pose";
    spec.summary = "A pose in the plane.";
    spec.kind = "curved_pose";
    spec.example = "{}";
    return spec;
  }
  explicit Pose(const Binding&) {
    declaration_.kind = "curved_pose";
    declaration_.stored_size = 3;
    for (const auto& [name, unit] : {std::pair("north", "m"), std::pair("east", "m"), std::pair("heading", "rad")}) {
      declaration_.error.push_back({name, unit});
      declaration_.outputs.push_back(output(name, unit));
    }
  }
  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    spark();
    const double phi = delta[2], s = ratio(phi), c = coratio(phi);
    const double a = s * delta[0] - c * delta[1], b = c * delta[0] + s * delta[1], heading = x[2];
    result[0] = x[0] + std::cos(heading) * a - std::sin(heading) * b;
    result[1] = x[1] + std::sin(heading) * a + std::cos(heading) * b;
    result[2] = heading + phi;
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    const double phi = std::remainder(y[2] - x[2], 2 * std::numbers::pi), s = ratio(phi), c = coratio(phi);
    const double n = y[0] - x[0], e = y[1] - x[1];
    const double a = std::cos(x[2]) * n + std::sin(x[2]) * e, b = -std::sin(x[2]) * n + std::cos(x[2]) * e;
    delta[0] = (s * a + c * b) / (s * s + c * c);
    delta[1] = (s * b - c * a) / (s * s + c * c);
    delta[2] = phi;
  }
  void read(ConstVectorView x, VectorView outputs) const override {
    for (int i = 0; i < 3; ++i) outputs[i] = x[i];
  }
  Result write(ConstVectorView outputs, VectorView x) const override {
    for (int i = 0; i < 3; ++i) x[i] = outputs[i];
    return Result::ok();
  }
  /// The right Jacobian of SE(2): Solà, Deray, Atchuthan, A micro Lie theory, 2018, equation (163).
  bool reset_jacobian(ConstVectorView /*x*/, ConstVectorView delta, MatrixView G) const override {
    spark();
    const double phi = delta[2], s = ratio(phi), c = coratio(phi);
    // (φ − sin φ)/φ² and (1 − cos φ)/φ².
    const double t = std::abs(phi) < 1e-4 ? phi / 6 : (phi - std::sin(phi)) / (phi * phi);
    const double u = std::abs(phi) < 1e-4 ? 0.5 : (1 - std::cos(phi)) / (phi * phi);
    G.as().setIdentity();
    G(0, 0) = G(1, 1) = s;
    G(0, 1) = c;
    G(1, 0) = -c;
    G(0, 2) = t * delta[0] - u * delta[1];
    G(1, 2) = u * delta[0] + t * delta[1];
    return true;
  }

 private:
  static double ratio(double phi) { return std::abs(phi) < 1e-6 ? 1 - phi * phi / 6 : std::sin(phi) / phi; }
  static double coratio(double phi) { return std::abs(phi) < 1e-6 ? phi / 2 : (1 - std::cos(phi)) / phi; }

  StateBlockDeclaration declaration_;
};

/// p + C(heading) l.
class Tip final : public DerivedBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "curved_tip";
    spec.summary = "A point of a pose.";
    spec.parameters = {parameter::vector("lever_arm", "m", 2).required().about("in its own axes")};
    spec.kind = "vector:2:m";
    spec.ports = {reads("pose", "curved_pose", "what it is a point of")};
    spec.example = R"({"blocks": {"pose": "pose"}, "lever_arm": [1, 2]})";
    return spec;
  }
  explicit Tip(const Binding& binding)
      : pose_(binding.port("pose")), lever_arm_(binding.parameters().vector("lever_arm")) {
    declaration_.yields("vector:2:m", 2, {{"x", "m"}, {"y", "m"}}).reads(pose_);
  }
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    spark();
    const ConstVectorView x = in.x[pose_];
    const double c = std::cos(x[2]), s = std::sin(x[2]), l = lever_arm_[0], k = lever_arm_[1];
    out.value[0] = x[0] + c * l - s * k;
    out.value[1] = x[1] + s * l + c * k;
    if (const MatrixView J = out.J[pose_]) {
      J(0, 0) = c, J(0, 1) = -s, J(0, 2) = -c * k - s * l;
      J(1, 0) = s, J(1, 1) = c, J(1, 2) = -s * k + c * l;
    }
    return Result::ok();
  }

 private:
  Port pose_;
  Eigen::Vector2d lever_arm_;
};

/// A x.
class Mix final : public DerivedBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "curved_mix";
    spec.summary = "Two linear combinations; not curved at all.";
    spec.parameters = {parameter::matrix("A", "1").required().about("of two rows")};
    spec.kind = "vector:2:m";
    spec.ports = {reads("x", "vector:*:m", "what is mixed")};
    spec.example = R"({"blocks": {"x": "x"}, "A": [[1, 0], [0, 1]]})";
    return spec;
  }
  explicit Mix(const Binding& binding) : x_(binding.port("x")), A_(binding.parameters().matrix("A")) {
    declaration_.yields("vector:2:m", 2, {{"x", "m"}, {"y", "m"}}).reads(x_);
  }
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    for (int i = 0; i < 2; ++i) {
      out.value[i] = 0;
      for (int k = 0; k < x_.dof(); ++k) out.value[i] += A_(i, k) * in.x[x_][k];
    }
    if (const MatrixView J = out.J[x_]) J.as() = A_;
    return Result::ok();
  }

 private:
  Port x_;
  Eigen::MatrixXd A_;
};

/// Ranges to beacons, with an offset that all of them have.
class Ranges final : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "curved_ranges";
    spec.summary = "Ranges to beacons.";
    spec.parameters = {
        parameter::matrix("beacons", "m").required().about("north, east of each"),
        parameter::number("sigma", "m").above(0).required().about("of each range"),
        parameter::number("correlation", "1").defaults("0").about("of any two"),
        parameter::number("vanishes_beyond", "m").defaults("1e9").about("a row is gone where its range is larger"),
        parameter::number("refuses_beyond", "m").defaults("1e9").about("the sample, where a range is larger")};
    spec.ports = {reads("tip", "vector:2:m", "from where"), reads("offset", "vector:1:m", "of all ranges").optional()};
    for (int i = 0; i < 3; ++i) spec.fields.push_back(field::level("z" + std::to_string(i), "m").about("range"));
    spec.example = R"({"channel": "z", "blocks": {"tip": "tip"}, "beacons": [[0, 1], [1, 0], [1, 1]], "sigma": 1})";
    return spec;
  }
  explicit Ranges(const Binding& binding)
      : tip_(binding.port("tip")),
        offset_(binding.port("offset")),
        z_(binding.fields("z0", "z1", "z2")),
        beacons_(binding.parameters().matrix("beacons")),
        sigma_(binding.parameters().number("sigma")),
        correlation_(binding.parameters().number("correlation")),
        vanishes_beyond_(binding.parameters().number("vanishes_beyond")),
        refuses_beyond_(binding.parameters().number("refuses_beyond")) {
    declaration_.rows(3).reads(tip_).reads(offset_).group(rows::like("range", "m"));
    calls_ = declaration_.keeps<long>();
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    ++in.memory[calls_];
    spark();
    in.notes.leave("a note of each call");
    const Eigen::Vector3d z = in.sample[z_];
    for (int i = 0; i < 3; ++i) {
      const double n = beacons_(i, 0) - in.x[tip_][0], e = beacons_(i, 1) - in.x[tip_][1], range = std::hypot(n, e);
      if (range > refuses_beyond_) return Result::unsupported("a beacon is too far");
      if (range > vanishes_beyond_) continue;
      const int row = out.rows++;
      out.row_keys[static_cast<std::size_t>(row)] = i;
      out.residual[row] = z[i] - range - (offset_.is_bound() ? in.x[offset_][0] : 0.0);
      if (const MatrixView H = out.H[tip_]) H(row, 0) = -n / range, H(row, 1) = -e / range;
      if (const MatrixView H = out.H[offset_]) H(row, 0) = 1;
      for (int k = 0; k <= row; ++k) out.R(row, k) = out.R(k, row) = sigma_ * sigma_ * (k == row ? 1 : correlation_);
    }
    return Result::ok();
  }

 private:
  Port tip_, offset_;
  Fields<3> z_;
  Eigen::MatrixXd beacons_;
  double sigma_, correlation_, vanishes_beyond_, refuses_beyond_;
  Memory<long> calls_;
};

/// z = H x + y + v, cov v = R.
class Linear final : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "curved_linear";
    spec.summary = "Not curved at all.";
    spec.parameters = {parameter::matrix("H", "1").required().about("of x"),
                       parameter::matrix("R", "1").required().about("of the noise")};
    spec.ports = {reads("x", "vector:*:*", "what is seen"), reads("y", "vector:2:*", "what is added").optional()};
    for (int i = 0; i < 2; ++i) spec.fields.push_back(field::level("z" + std::to_string(i), "").about("seen"));
    spec.example = R"({"channel": "z", "blocks": {"x": "x"}, "H": [[1, 0], [0, 1]], "R": [[1, 0], [0, 1]]})";
    return spec;
  }
  explicit Linear(const Binding& binding)
      : x_(binding.port("x")),
        y_(binding.port("y")),
        z_(binding.fields("z0", "z1")),
        H_(binding.parameters().matrix("H")),
        R_(binding.parameters().matrix("R")) {
    declaration_.rows(2).reads(x_).reads(y_).group(rows::like("seen", "m"));
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    out.rows = 2;
    for (int i = 0; i < 2; ++i) {
      double seen = y_.is_bound() ? in.x[y_][i] : 0.0;
      for (int k = 0; k < x_.dof(); ++k) seen += H_(i, k) * in.x[x_][k];
      out.residual[i] = in.sample[z_][i] - seen;
    }
    if (const MatrixView H = out.H[x_]) H.as() = H_;
    if (const MatrixView H = out.H[y_]) H.as().setIdentity();
    out.R.as() = R_;
    return Result::ok();
  }

 private:
  Port x_, y_;
  Fields<2> z_;
  Eigen::MatrixXd H_, R_;
};

}  // namespace

BINNACLE_PLUGIN("curved", "1.0.0", registry) {
  registry.add<Pose>();
  registry.add<Tip>();
  registry.add<Mix>();
  registry.add<Ranges>();
  registry.add<Linear>();
}
