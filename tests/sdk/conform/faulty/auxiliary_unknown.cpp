// SPDX-License-Identifier: Apache-2.0
// H is −7 times what it should be; its surroundings specify nothing of its auxiliary channel, which the suite fills itself.
// fails: numbers.measurement.jacobian
#include "faulty.hpp"

#include <cmath>

namespace faulty::auxiliary_unknown {

/// A thermometer whose offset comes on an auxiliary channel: z = x0 + offset.
class Subject final : public Measurement {
 public:
  static ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.inputs = {
        {"offset", {{"offset", "m", FieldKind::level, false, false, "of the reading"}}, false, "what is added"}};
    spec.example = R"({"channel": "ranges", "inputs": {"offset": "offsets"}, "blocks": {"p": "position"}})";
    return spec;
  }
  explicit Subject(const Binding& binding)
      : Measurement(binding), offsets_(binding.input("offset")), offset_(binding.field(offsets_, "offset")) {}
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const SampleView& offset = in.auxiliary[offsets_];
    if (!offset.available) return Result::unsupported("no offset has come");
    if (!std::isfinite(in.sample[range])) return Result::invalid("no reading");
    out.rows = 1;
    out.residual[0] = in.sample[range] - (in.x[p][0] + offset[offset_]);
    if (const auto H = out.H[p]) H(0, 0) = -7;
    out.R(0, 0) = sigma * sigma;
    return Result::ok();
  }

 private:
  Input offsets_;
  Field offset_;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("auxiliary_unknown")); }

}  // namespace faulty::auxiliary_unknown
