// SPDX-License-Identifier: Apache-2.0
// Labels that are calendar times or GPS weeks, in one column or two.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "civil_time/iso8601.hpp"
#include "civil_time/utc_clock.hpp"

namespace binnacle::csv {

struct CalendarTime {
  enum class Form { instant, date_and_time, week_and_seconds };

  explicit CalendarTime(const civil_time::UtcClock& of_channels) : clock(of_channels) {}

  Form form = Form::instant;
  std::size_t other = 0;  // the column of dates or weeks
  std::string other_name;
  civil_time::DateOrder order = civil_time::DateOrder::ymd;
  Time zone = 0;
  civil_time::UtcClock clock;

  /// `cell`: of the time column `name`; `other_cell`: the date or week; `unit`: of seconds of the week [ns]. What is wrong, as
  /// "time column 'utc': 'noon' is no time of ISO 8601"; empty: nothing.
  std::string read(std::string_view cell, const std::string& name, std::string_view other_cell, std::int64_t unit,
                   Time& label) const;
};

}  // namespace binnacle::csv
