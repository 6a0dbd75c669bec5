// SPDX-License-Identifier: Apache-2.0
#include "filter/model_calls.hpp"

#include <cmath>
#include <cstdio>
#include <cstring>

namespace binnacle::internal::filter {

namespace {

constexpr double rounding = 1e-9;  // of an element, in the geometric mean of its variances

std::string element(int i, int j, double value) {
  char text[64];
  std::snprintf(text, sizeof text, "R(%d, %d) = %.6g", i, j, value);
  return text;
}

}  // namespace

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

std::string flaw_of_noise(ConstMatrixView R) {
  for (int j = 0; j < R.cols; ++j)
    for (int i = 0; i < R.rows; ++i)
      if (!std::isfinite(R(i, j))) return element(i, j, R(i, j)) + ", which is not finite";
  for (int i = 0; i < R.rows; ++i)
    if (R(i, i) < 0) return element(i, i, R(i, i)) + ", which is no variance";
  for (int j = 0; j < R.cols; ++j)
    for (int i = 0; i < j; ++i)
      if (const double difference = R(i, j) - R(j, i);
          difference * difference > rounding * rounding * R(i, i) * R(j, j))
        return element(i, j, R(i, j)) + " but " + element(j, i, R(j, i)) + ", which is not symmetric";
  return "";
}

void NoteBook::keep(const std::string& type, const std::string& pointer, const char* call, Time t, const char* text) {
  constexpr std::size_t longest = sizeof(KeptNote::text) - 1;
  for (KeptNote& note : notes_)
    if (note.pointer == &pointer && std::strncmp(note.text, text, longest) == 0) {
      ++note.count;
      return;
    }
  if (notes_.size() == most) {
    ++left_out_;
    return;
  }
  notes_.push_back({&type, &pointer, call, t, 1, {}});
  std::strncpy(notes_.back().text, text, longest);
}

}  // namespace binnacle::internal::filter
