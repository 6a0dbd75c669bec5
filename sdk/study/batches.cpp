// SPDX-License-Identifier: Apache-2.0
#include "batches.hpp"

#include <algorithm>

namespace binnacle::study {

namespace {

/// As even as can be.
void add_parts(const Batch& batch, std::size_t parts, std::vector<Batch>& to) {
  const std::size_t count = batch.variants.size();
  parts = std::min(parts, count);
  for (std::size_t part = 0; part < parts; ++part) {
    const auto at = [&](std::size_t index) {
      return batch.variants.begin() + static_cast<std::ptrdiff_t>(count * index / parts);
    };
    to.push_back({{at(part), at(part + 1)}, batch.run});
  }
}

}  // namespace

std::vector<Batch> batches_of(const std::vector<std::vector<std::size_t>>& groups, const Results& results,
                              int workers) {
  std::vector<Batch> batches;
  for (std::size_t run = 0; run < results.runs(); ++run)
    for (const auto& group : groups) {
      Batch open{{}, run};
      for (const std::size_t variant : group)
        if (results.at(variant, run).state == Figures::State::open) open.variants.push_back(variant);
      add_parts(open, (open.variants.size() + most_together - 1) / most_together, batches);
    }
  const auto all = static_cast<std::size_t>(workers);
  const std::size_t last = batches.size() % all;
  if (last == 0) return batches;
  const std::vector<Batch> round(batches.end() - static_cast<std::ptrdiff_t>(last), batches.end());
  batches.resize(batches.size() - last);
  for (const auto& batch : round) add_parts(batch, (all + last - 1) / last, batches);
  return batches;
}

}  // namespace binnacle::study
