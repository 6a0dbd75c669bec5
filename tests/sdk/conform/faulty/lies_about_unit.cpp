// SPDX-License-Identifier: Apache-2.0
// Its kind states metres, its components feet as metres a second.
// fails: metadata.declared
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Block {
 public:
  static binnacle::ComponentSpec spec() {
    auto spec = Block::spec();
    spec.kind = "vector:3:m";
    return spec;
  }
  explicit Subject(const binnacle::Binding& binding) : Block(binding) { declared.kind = "vector:3:m"; }
};

}  // namespace

BINNACLE_PLUGIN("lies_about_unit", "1.0.0", registry) { registry.add<Subject>(); }
