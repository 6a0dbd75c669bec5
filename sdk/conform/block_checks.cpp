// SPDX-License-Identifier: Apache-2.0
// numbers.block: the laws of a manifold.
#include <numbers>

#include "fixture.hpp"
#include "guarded.hpp"

namespace binnacle::conform {

namespace {

struct BlockSubject {
  explicit BlockSubject(Trial& trial)
      : composition(compose_example(trial)), value(parts::block(*composition, filter_name, component_name)) {}
  PortState at(Trial& trial, std::uint64_t stream, double spread) const {
    auto random = trial.random(stream);
    return port_states({value}, random, spread).front();
  }
  /// Half a turn is the end of a rotation's chart.
  bool turns() const {
    const auto& declared = value.block->declaration();
    return declared.dof() == 3 && declared.stored_size > 3 && declared.error.front().unit == "rad";
  }
  std::shared_ptr<const Composition> composition;
  parts::Value value;
};

void laws(Trial& trial) {
  const BlockSubject subject(trial);
  for (int repeat = 0; repeat < trial.repeats(5); ++repeat) {
    const PortState at = subject.at(trial, 100 + static_cast<std::uint64_t>(repeat), repeat == 0 ? 0.0 : 1.0);
    auto random = trial.random(200 + static_cast<std::uint64_t>(repeat));
    for (const double size : {0.0, 1e-8, 1e-4, 0.1, 1.0})
      if (!trial.expect_none(testing::check_laws(at, size * at.scale.cwiseProduct(normals(random, at.dof()))))) return;
    if (!subject.turns()) continue;
    Eigen::VectorXd delta = normals(random, 3);
    delta *= (std::numbers::pi - 1e-3) / delta.norm();
    if (!trial.expect_none(testing::check_laws(at, delta, {1e-8, 1e-8}))) return;
  }
}

void readable(Trial& trial) {
  const BlockSubject subject(trial);
  if (subject.value.block->declaration().outputs.empty()) Trial::not_applicable("it has no readable output");
  for (int repeat = 0; repeat < trial.repeats(10); ++repeat)
    if (!trial.expect_none(testing::check_readable(subject.at(trial, 300 + static_cast<std::uint64_t>(repeat), 1.0))))
      return;
}

void reset(Trial& trial) {
  const BlockSubject subject(trial);
  for (int repeat = 0; repeat < trial.repeats(5); ++repeat) {
    const PortState at = subject.at(trial, 400 + static_cast<std::uint64_t>(repeat), 0.5);
    auto random = trial.random(500 + static_cast<std::uint64_t>(repeat));
    const Eigen::VectorXd delta = 0.1 * at.scale.cwiseProduct(normals(random, at.dof()));
    if (!trial.expect_none(testing::check_reset(at, delta, 0.2, 1e-5))) return;
  }
}

void outputs(Trial& trial) {
  const BlockSubject subject(trial);
  const auto& declared = subject.value.block->declaration();
  Eigen::MatrixXd J(declared.outputs.size(), declared.dof());
  int given = 0;
  for (int repeat = 0; repeat < trial.repeats(5); ++repeat) {
    const PortState at = subject.at(trial, 600 + static_cast<std::uint64_t>(repeat), 1.0);
    given += testing::called("output_jacobian", [&] {
      return at.block->output_jacobian(at.x, {J.data(), static_cast<int>(J.rows()), static_cast<int>(J.cols()),
                                              static_cast<int>(J.rows())});
    });
    if (!trial.expect_none(testing::check_output_jacobian(at, 1e-3, 1e-3))) return;
  }
  if (given == 0) Trial::not_applicable("it gives no Jacobian of its outputs: the kernel takes differences");
}

}  // namespace

std::vector<Check> block_checks() {
  const std::vector<Role> roles = {Role::state_block};
  return {
      check("numbers.block.laws", 2, roles, {"life.repeatable"},
            "[+] and [-] are each other's inverse at the identity, for small and large errors, near half a turn", laws),
      check("numbers.block.readable", 2, roles, {"numbers.block.laws"}, "write(read(x)) = x", readable),
      check("numbers.block.reset", 3, roles, {"numbers.block.laws"}, "the reset Jacobian is that of [+] and [-]",
            reset),
      check("numbers.block.outputs", 3, roles, {"numbers.block.laws"},
            "the Jacobian of the outputs is that of read() and [+]", outputs),
  };
}

}  // namespace binnacle::conform
