// SPDX-License-Identifier: Apache-2.0
#include "run/arrivals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/hash.hpp"
#include "filter/intact.hpp"

namespace binnacle::internal::runtime {

using base::as_size;

Arrivals::Arrivals(const CompositionPlan& plan)
    : plan_(plan), store_(plan.channels), sources_(plan.sources.size()), is_present_(plan.channels.size()) {}

bool Arrivals::are_wanted(const CompositionPlan& plan) {
  return std::ranges::any_of(plan.sources, [](const SourcePlan& source) { return source.latency.has_value(); });
}

void Arrivals::reset(std::uint64_t seed, int run) {
  store_.clear();
  for (std::size_t s = 0; s < sources_.size(); ++s)
    sources_[s] = {random::stream(base::stream_seed(seed, run, plan_.sources[s].pointer), "latency"), 0, 0};
}

void Arrivals::exchange(StateBytes& bytes) {
  store_.exchange(bytes);
  for (Source& source : sources_) {
    bytes.value(source);
    bytes.expect(filter::is_count(source.sequence) && filter::is_count(source.without_latency));
  }
}

Time Arrivals::latency(std::size_t source, int channel, const SampleView& sample) {
  const auto& latency = plan_.sources[source].latency;
  if (!latency) return 0;
  random::Philox& random = sources_[source].random;
  double delay = latency->first;
  switch (latency->kind) {
    case LatencyPlan::Kind::fixed: break;
    case LatencyPlan::Kind::field: {
      const auto& own = plan_.sources[source].channels;
      delay = sample.fields[latency->fields[as_size(base::index_of(own, channel))]];
      if (!(delay >= 0) || std::isinf(delay)) {
        ++sources_[source].without_latency;
        return 0;
      }
      break;
    }
    case LatencyPlan::Kind::uniform: delay += (latency->second - latency->first) * random::uniform(random); break;
    case LatencyPlan::Kind::normal: {  // Box and Muller, 1958
      const double radius = std::sqrt(-2 * std::log1p(-random::uniform(random)));
      delay += latency->second * radius * std::cos(2 * std::numbers::pi * random::uniform(random));
      break;
    }
    case LatencyPlan::Kind::batch: {
      const Time period = nanoseconds(latency->first), over = ((sample.t % period) + period) % period;
      return over == 0 ? 0 : period - over;
    }
    case LatencyPlan::Kind::exponential: delay *= -std::log1p(-random::uniform(random)); break;
  }
  constexpr double longest = 1e9;  // seconds: what is longer never comes
  return delay > 0 ? nanoseconds(std::min(delay, longest)) : 0;
}

void Arrivals::read(std::size_t source, int channel, const SampleView& sample) {
  const Time at = sample.t + latency(source, channel, sample);
  store_.insert({at, sample.t, static_cast<std::int32_t>(source), sources_[source].sequence++}, channel, sample);
}

Time Arrivals::next() const { return store_.empty() ? std::numeric_limits<Time>::max() : store_[0].key.first; }

Time Arrivals::take_instant(
    const std::function<void(int channel, const SampleView& sample, std::int64_t sequence)>& take) {
  const SampleKey first = store_[0].key;
  each_of_instant(store_, 0, &SampleStore::Item::is_done, is_present_,
                  [&](const SampleStore::Item& item) { take(item.channel, store_.view(item), item.key.sequence); });
  std::size_t end = 0;
  while (end < store_.size() && store_[end].key.is_with(first)) ++end;
  while (end-- > 0)
    if (store_[end].is_done) store_.erase(end);
  return first.second;
}

}  // namespace binnacle::internal::runtime
