// SPDX-License-Identifier: Apache-2.0
// Draws from a source of randomness of its own.
// fails: life.repeatable
#include <random>

#include "faulty.hpp"

namespace {

class Subject final : public faulty::Source {
 public:
  using Source::Source;
  binnacle::SourceStatus next(std::byte* memory, binnacle::SampleSlot* slots, int& channel) const override {
    const auto status = Source::next(memory, slots, channel);
    if (status == binnacle::SourceStatus::sample) slots[0].fields[0] += std::random_device()();
    return status;
  }
};

}  // namespace

BINNACLE_PLUGIN("random_device", "1.0.0", registry) { registry.add<Subject>(); }
