// SPDX-License-Identifier: Apache-2.0
// Its kind states metres, its components feet as metres a second.
// fails: metadata.declared
#include "faulty.hpp"

namespace faulty::lies_about_unit {

class Subject final : public Block {
 public:
  static ComponentSpec spec() {
    auto spec = Block::spec();
    spec.kind = "vector:3:m";
    return spec;
  }
  explicit Subject(const Binding& binding) : Block(binding) { declared.kind = "vector:3:m"; }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("lies_about_unit")); }

}  // namespace faulty::lies_about_unit
