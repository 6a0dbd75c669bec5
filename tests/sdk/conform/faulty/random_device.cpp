// SPDX-License-Identifier: Apache-2.0
// Draws from a source of randomness of its own.
// fails: life.repeatable
#include <random>

#include "faulty.hpp"

namespace {

class Subject final : public faulty::Source {
 public:
  using Source::Source;
  binnacle::SourceStatus next(const binnacle::MemoryView& memory, binnacle::SourceOutput& out) const override {
    const auto status = Source::next(memory, out);
    if (status == binnacle::SourceStatus::sample) out.on(channel)[value] += std::random_device()();
    return status;
  }
};

}  // namespace

BINNACLE_PLUGIN("random_device", "1.0.0", registry) { registry.add<Subject>(); }
