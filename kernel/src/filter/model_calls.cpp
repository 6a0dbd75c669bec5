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
  CallSite site;
  site.enter(nullptr, type, call);
  site.set_time(t);
  return site.text(pointer);
}

std::string flaw_of_noise(ConstMatrixView R) {
  for (int j = 0; j < R.cols; ++j)
    for (int i = 0; i <= j; ++i) {
      const double above = R(i, j), below = R(j, i), difference = above - below;
      if (difference == 0 && (i < j || above >= 0)) continue;  // both finite
      if (!std::isfinite(above)) return element(i, j, above) + ", which is not finite";
      if (!std::isfinite(below)) return element(j, i, below) + ", which is not finite";
      if (i == j) return element(i, i, above) + ", which is not a variance";
      if (difference * difference > rounding * rounding * R(i, i) * R(j, j))
        return element(i, j, above) + " but " + element(j, i, below) + ", which is not symmetric";
    }
  return "";
}

void NoteBook::keep(const std::string& type, const std::string& pointer, const char* call, Time t, const char* text) {
  constexpr std::size_t longest = sizeof(KeptNote::text) - 1;
  for (KeptNote& note : notes_)
    if (*note.pointer == pointer && std::strncmp(note.text, text, longest) == 0) {
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

void NoteBook::exchange(StateBytes& bytes) {
  if (bytes.is_reading()) {
    notes_.clear();  // their texts may be those that go with read_
    read_ = std::make_shared<std::deque<std::string>>();
  }
  const auto text = [&](const std::string* known) -> const std::string* {
    std::string copy = known ? *known : "";
    bytes.text(copy);
    return bytes.is_reading() ? &read_->emplace_back(std::move(copy)) : known;
  };
  bytes.list(notes_, [&](KeptNote& note) {
    note.type = text(note.type);
    note.pointer = text(note.pointer);
    const std::string call = note.call ? note.call : "";
    const std::string* const kept = text(&call);
    if (bytes.is_reading()) note.call = kept->c_str();
    bytes.value(note.first);
    bytes.value(note.count);
    bytes.value(note.text);
    note.text[sizeof note.text - 1] = '\0';
  });
  bytes.expect(notes_.size() <= most);
  bytes.value(left_out_);
}

}  // namespace binnacle::internal::filter
