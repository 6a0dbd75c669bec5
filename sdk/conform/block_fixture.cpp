// SPDX-License-Identifier: Apache-2.0
// Calls of state blocks.
#include "binnacle/view.hpp"
#include "fixture.hpp"
#include "guarded.hpp"

namespace binnacle::conform {

using testing::append;
using testing::called;
using testing::examine;
using testing::Guarded;
using testing::Inputs;

namespace {

class CallsBlock final : public Fixture {
 public:
  CallsBlock(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial),
        composition_(std::move(composition)),
        value_(parts::block(*composition_, filter_name, component_name)) {}
  std::size_t memory_bytes() const override { return 0; }
  void start(std::byte*) const override {}
  Answer turn(std::uint64_t k, std::byte*, double fill) const override {
    auto random = trial_.random(1000 + k);
    const PortState at = port_states({value_}, random, 0.5).front();
    return call(at.x, 0.3 * at.scale.cwiseProduct(normals(random, at.scale.size())), fill);
  }
  std::vector<std::string> hostile_finite() const override { return {"zero", "tiny 1e-300", "alternating 1e15"}; }
  std::vector<std::string> hostile_nonfinite() const override { return nonfinite_hostilities(); }
  Answer hostile(const std::string& input, std::byte*) const override {
    auto random = trial_.random(1);
    const PortState at = port_states({value_}, random, 0.5).front();
    Eigen::VectorXd delta = normals(random, at.scale.size());
    for (Eigen::Index i = 0; i < delta.size(); ++i)
      delta[i] = hostile_number(input, static_cast<std::size_t>(i), delta[i]);
    return call(at.x, delta, 0.0);
  }

 private:
  Answer call(const std::vector<double>& from, const Eigen::VectorXd& by, double fill) const {
    const StateBlock& block = *value_.block;
    const auto& declared = block.declaration();
    Guarded y(from.size(), fill), back(static_cast<std::size_t>(declared.dof()), fill),
        read(declared.outputs.size(), fill), written(from.size(), fill),
        G(static_cast<std::size_t>(declared.dof() * declared.dof()), fill);
    Inputs inputs;
    const ConstVectorView x = inputs.keep("x", ConstVectorView(from));
    const ConstVectorView delta = inputs.keep("delta", ConstVectorView(by));
    called("plus", [&] { return block.plus(x, delta, y), 0; });
    const ConstVectorView moved = inputs.keep("y", ConstVectorView(y));
    called("minus", [&] { return block.minus(moved, x, back), 0; });
    called("read", [&] { return block.read(moved, read), 0; });
    const ConstVectorView outputs = inputs.keep("the outputs", ConstVectorView(read));
    const Result result = called("write", [&] { return block.write(outputs, written); });
    const int dof = declared.dof();
    const bool has_reset = called("reset_jacobian", [&] {
      return block.reset_jacobian(x, delta, {G.data(), dof, dof, dof});
    });
    const int count = static_cast<int>(declared.outputs.size());
    Guarded J(static_cast<std::size_t>(count * dof), fill);
    const bool has_J = called("output_jacobian", [&] {
      return block.output_jacobian(x, {J.data(), count, dof, count});
    });
    Answer answer;
    answer.damage = inputs.damage("a call of the block");
    examine(y, "plus", fill, answer.damage);
    examine(back, "minus", fill, answer.damage);
    examine(read, "read", fill, answer.damage);
    if (result) examine(written, "write", fill, answer.damage);
    if (has_reset) examine(G, "reset_jacobian", fill, answer.damage);
    if (has_J) examine(J, "output_jacobian", fill, answer.damage);
    for (const auto* part : {&y, &back, &read}) append(answer.numbers, part->values());
    if (result) append(answer.numbers, written.values());
    if (has_reset) append(answer.numbers, G.values());
    if (has_J) append(answer.numbers, J.values());
    return answer;
  }
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  parts::Value value_;
};

}  // namespace

std::unique_ptr<Fixture> block_fixture(Trial& trial, std::shared_ptr<const Composition> composition) {
  return std::make_unique<CallsBlock>(trial, std::move(composition));
}

}  // namespace binnacle::conform
