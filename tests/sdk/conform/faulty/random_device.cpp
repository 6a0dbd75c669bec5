// SPDX-License-Identifier: Apache-2.0
// Draws from a source of randomness of its own.
// fails: life.repeatable
#include <random>

#include "faulty.hpp"

namespace faulty::random_device {

class Subject final : public Source {
 public:
  using Source::Source;
  SourceStatus next(const MemoryView& memory, SourceOutput& out) const override {
    const auto status = Source::next(memory, out);
    if (status == SourceStatus::sample) out.on(channel)[value] += std::random_device()();
    return status;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("random_device")); }

}  // namespace faulty::random_device
