// SPDX-License-Identifier: Apache-2.0
#include "line_input/label_guard.hpp"

#include <algorithm>
#include <cstdlib>

namespace binnacle::line_input {

bool LabelGuard::accepts(Time label, Time arrival) {
  constexpr int many = 4;
  constexpr Time lasting = 3 * nanoseconds_per_second;
  const Time ahead = newest_ == no_time ? 0 : label - newest_;
  const bool was_silent = ahead > 0 && arrival - arrival_ >= ahead / 2;
  is_anew_ = std::abs(ahead) > max_ahead_ && !was_silent;
  if (is_anew_) {
    const bool goes_on = suspect_ != no_time && label >= suspect_ && label - suspect_ <= max_ahead_;
    if (!goes_on) suspect_since_ = label;
    suspects_ = goes_on ? suspects_ + 1 : 1;
    suspect_ = label;
    is_anew_ = suspects_ >= many && label - suspect_since_ >= lasting;
    if (!is_anew_) return ahead < 0;
  }
  newest_ = is_anew_ ? label : std::max(newest_, label);
  arrival_ = arrival;
  suspect_ = no_time;
  return true;
}

}  // namespace binnacle::line_input
