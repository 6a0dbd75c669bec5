// SPDX-License-Identifier: Apache-2.0
#include "filter/model_calls.hpp"

#include <cstdio>

namespace binnacle::filter {

std::string time_text(Time t) {
  char text[48];
  std::snprintf(text, sizeof text, "%.9g s", seconds(t));
  return text;
}

std::string call_text(const std::string& type, const std::string& pointer, const char* call, Time t) {
  const auto slash = type.find('/');
  const std::string component = slash == std::string::npos ? type : type.substr(slash + 1);
  return "plugin '" + type.substr(0, slash) + "', component '" + component + "' (" + pointer + "): " + call +
         (t == no_time ? "" : " at " + time_text(t));
}

}  // namespace binnacle::filter
