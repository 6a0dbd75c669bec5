// SPDX-License-Identifier: Apache-2.0
// A plugin whose spec contradicts itself.
#include "components.hpp"

namespace {

class Contradiction final : public binnacle::StateBlock {
 public:
  static binnacle::ComponentSpec spec() {
    auto spec = loader_test::Still::spec();
    spec.type = "contradiction";
    spec.parameters = {binnacle::parameter::number("tau", "s").above(0).defaults("\"-1 s\"").about("time"),
                       binnacle::parameter::number("angle", "deg").about("no SI unit")};
    return spec;
  }
  explicit Contradiction(const binnacle::Binding& binding) : still_(binding) {}
  const binnacle::StateBlockDeclaration& declaration() const noexcept override { return still_.declaration(); }
  void plus(binnacle::ConstVectorView x, binnacle::ConstVectorView delta, binnacle::VectorView result) const override {
    still_.plus(x, delta, result);
  }
  void minus(binnacle::ConstVectorView y, binnacle::ConstVectorView x, binnacle::VectorView delta) const override {
    still_.minus(y, x, delta);
  }
  void read(binnacle::ConstVectorView x, binnacle::VectorView outputs) const override { still_.read(x, outputs); }
  binnacle::Result write(binnacle::ConstVectorView outputs, binnacle::VectorView x) const override {
    return still_.write(outputs, x);
  }

 private:
  loader_test::Still still_;
};

}  // namespace

BINNACLE_PLUGIN("bad_spec", "1", registry) { registry.add<Contradiction>(); }
