// SPDX-License-Identifier: Apache-2.0
// Live sources: samples are worked on as they come, and nobody waits for a source that has none.
#include <algorithm>
#include <limits>

#include <poll.h>

#include "run/arrival_watch.hpp"
#include "run/history.hpp"
#include "run/runtime.hpp"

namespace binnacle::internal::runtime {

/// Recorded samples are as far as the newest live one, and go first; they run on when nothing live is left.
bool Runtime::next_of_live() {
  std::size_t best = plan_.sources.size(), best_live = best;
  Time earliest = std::numeric_limits<Time>::max(), earliest_live = earliest;
  has_live_ = false;
  for (std::size_t s = 0; s < plan_.sources.size(); ++s) {
    const SourceHead& head = *plan_.sources[s].head.in(arena());
    if (head.status == 0) fetch(s);
    const bool is_live = plan_.sources[s].object->declaration().live;
    has_live_ = has_live_ || (is_live && head.status != 2);
    if (head.status != 1) continue;
    if (is_live && head.sample.t < earliest_live) {
      earliest_live = head.sample.t;
      best_live = s;
    }
    if (!is_live && head.sample.t < earliest) {
      earliest = head.sample.t;
      best = s;
    }
  }
  if (best_live < plan_.sources.size()) newest_live_ = std::max(newest_live_, earliest_live);
  const bool is_recorded_due = best < plan_.sources.size() && (!has_live_ || earliest <= newest_live_);
  const std::size_t next = is_recorded_due ? best : best_live;
  if (next == plan_.sources.size()) return false;
  SourceHead& head = *plan_.sources[next].head.in(arena());
  const int channel = plan_.sources[next].channels[as_size(head.channel)];
  const double* data = plan_.sources[next].slots[as_size(head.channel)].in(arena());
  const Time t = head.sample.t;
  if (watch_ && is_recorded_due) watch_->begin_recorded(t);
  if (watch_ && !is_recorded_due) watch_->begin_live(next);
  deliver(channel, unpack(plan_.channels[as_size(channel)], head.sample, data));
  show_arrival(channel);
  head.status = 0;  // asked again once this instant is done
  end_arrival(t);
  return true;
}

void Runtime::wait_for_sources() {
  constexpr int longest = 50, without_handle = 2;  // ms
  pollfd handles[64];
  nfds_t count = 0;
  int timeout = longest;
  for (const auto& source : plan_.sources) {
    if (!source.object->declaration().live || source.head.in(arena())->status == 2) continue;
    const int handle =
        guard_call<DataError>(plan_, source, "wait_handle", time_, [&] { return source.object->wait_handle(); });
    if (handle < 0 || count == std::size(handles))
      timeout = without_handle;
    else
      handles[count++] = {handle, POLLIN, 0};
  }
  ::poll(handles, count, timeout);  // a signal ends it too
}

void Runtime::end_sources() {
  for (const auto& source : plan_.sources) source.head.in(arena())->status = 2;
}

}  // namespace binnacle::internal::runtime
