// SPDX-License-Identifier: Apache-2.0
// Samples of sources with latency, in order of arrival.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "binnacle/random.hpp"
#include "run/sample_store.hpp"

namespace binnacle::internal::runtime {

/// A sample that was read is on its way until it arrives, its latency after its time. What arrives at one time is in order
/// of the samples' times, then of the sources in the config, then as they emit it.
class Arrivals {
 public:
  explicit Arrivals(const CompositionPlan& plan);
  static bool are_wanted(const CompositionPlan& plan);

  void reset(std::uint64_t seed, int run);
  void exchange(StateBytes& bytes);
  /// The sample of a source, read in order of its times.
  void read(std::size_t source, int channel, const SampleView& sample);
  bool empty() const { return store_.empty(); }
  /// Of the next that arrives; the largest there is where none is on its way.
  Time next() const;
  /// Each of those that arrive next, at one time and of one time, at most one a channel: they make one instant. Returns
  /// their time.
  Time take_instant(const std::function<void(int channel, const SampleView& sample, std::int64_t sequence)>& take);

  /// Samples whose own latency was no time.
  std::int64_t without_latency(std::size_t source) const { return sources_[source].without_latency; }

 private:
  Time latency(std::size_t source, int channel, const SampleView& sample);

  struct Source {
    random::Philox random{};
    std::int64_t sequence = 0;
    std::int64_t without_latency = 0;
  };
  const CompositionPlan& plan_;
  SampleStore store_;
  std::vector<Source> sources_;
  std::vector<bool> is_present_;  // by channel, of the instant
};

/// One instant of the items from `first` on that are of the same time: visits and marks one of each channel that is not
/// marked, in order; where a place has a second one on a channel, that and all after it of the place wait for the next
/// instant. False where none was left.
template <class Visit>
bool each_of_instant(SampleStore& store, std::size_t first, bool SampleStore::Item::*mark,
                     std::vector<bool>& is_present, Visit&& visit) {
  if (store.is_alone(first)) {
    SampleStore::Item& item = store[first];
    if (std::exchange(item.*mark, true)) return false;
    visit(item);
    return true;
  }
  is_present.assign(is_present.size(), false);
  std::int32_t blocked = -1;
  bool is_any = false;
  for (std::size_t i = first; i < store.size() && store[i].key.is_with(store[first].key); ++i) {
    SampleStore::Item& item = store[i];
    if (item.*mark || item.key.place == blocked) continue;
    if (is_present[base::as_size(item.channel)]) {
      blocked = item.key.place;
      continue;
    }
    is_present[base::as_size(item.channel)] = item.*mark = is_any = true;
    visit(item);
  }
  return is_any;
}

}  // namespace binnacle::internal::runtime
