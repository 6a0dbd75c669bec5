// SPDX-License-Identifier: Apache-2.0
// H is −7 times what it should be; its surroundings specify nothing of its auxiliary channel, which the suite fills itself.
// fails: numbers.measurement.jacobian
#include "faulty.hpp"

namespace {

/// A thermometer whose offset comes on an auxiliary channel: z = x0 + offset.
class Subject final : public faulty::Measurement {
 public:
  static binnacle::ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.inputs = {{"offset",
                    {{"offset", "m", binnacle::FieldKind::level, false, false, "of the reading"}},
                    false,
                    "what is added"}};
    spec.example = R"({"channel": "ranges", "inputs": {"offset": "offsets"}, "blocks": {"p": "position"}})";
    return spec;
  }
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context&, std::byte*,
                             binnacle::legacy::Linearization& out) const override {
    if (!auxiliary[0].available) return binnacle::Result::unsupported("no offset has come");
    if (!std::isfinite(sample.fields[0])) return binnacle::Result::invalid("no reading");
    out.rows = 1;
    out.residual[0] = sample.fields[0] - (x[0][0] + auxiliary[0].fields[0]);
    out.H[0](0, 0) = -7;
    out.R(0, 0) = sigma * sigma;
    return binnacle::Result::ok();
  }
};

}  // namespace

BINNACLE_PLUGIN("auxiliary_unknown", "1.0.0", registry) { registry.add<Subject>(); }
