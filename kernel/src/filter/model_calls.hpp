// SPDX-License-Identifier: Apache-2.0
// Every call of a filter into a plugin goes through ModelCalls. While one is under way its component is known, so that what it
// throws, or a number that may not be, is blamed on it by name.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "binnacle/eigen.hpp"
#include "binnacle/model_input.hpp"
#include "binnacle/plugin_call.hpp"
#include "binnacle/state_bytes.hpp"
#include "binnacle/view.hpp"

namespace binnacle::internal::filter {

/// A filter cannot go on: what() is its diagnosis.
struct Stop : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// "12.3 s"
std::string time_text(Time t);
/// "plugin 'core', component 'vector' (/filters/f/blocks/x): plus at 12.3 s"
std::string call_text(const std::string& type, const std::string& pointer, const char* call, Time t);
/// The same of a plan's component.
template <class Plan>
std::string call_text(const Plan& plan, const char* call, Time t) {
  return call_text(plan.type, plan.pointer, call, t);
}

inline bool is_finite(ConstVectorView x) { return (x.as().array() * 0.0).sum() == 0.0; }
inline bool is_finite(ConstMatrixView A) { return (A.as().array() * 0.0).sum() == 0.0; }
/// "R(1, 1) = -4, which is no variance": what is infinite, not a number, negative on the diagonal, or not symmetric but for
/// rounding; empty when R may be noise.
std::string flaw_of_noise(ConstMatrixView R);

struct KeptNote {
  const std::string* type = nullptr;
  const std::string* pointer = nullptr;
  const char* call = nullptr;
  Time first = no_time;  // of the sample or step
  std::int64_t count = 0;
  char text[120] = {};
};

/// What the models of a filter noted in a run: equal notes of one component once, with place and time of the first.
/// Allocates in its constructor only.
class NoteBook {
 public:
  /// Of so many different notes; others are counted.
  static constexpr std::size_t most = 64;

  NoteBook() { notes_.reserve(most); }
  void keep(const std::string& type, const std::string& pointer, const char* call, Time t, const char* text);
  void clear() {
    notes_.clear();
    left_out_ = 0;
  }
  const std::vector<KeptNote>& notes() const { return notes_; }
  std::int64_t left_out() const { return left_out_; }
  void exchange(StateBytes& bytes);

 private:
  std::vector<KeptNote> notes_;
  std::shared_ptr<std::deque<std::string>> read_;  // texts of notes that were read back
  std::int64_t left_out_ = 0;
};

/// The call under way, which other threads and a handler at exit may look at, at the time of the sample or step at work.
class ModelCalls : public CallSite {
 public:
  NoteBook note_book;     // what models noted
  bool is_muted = false;  // they are called for states that nobody believes in: their notes are not kept

  /// call_text() of the call under way.
  std::string place_text() const { return call_text(*component(), *pointer_, call(), time()); }

  /// Lets a model leave notes of the call under way.
  Notes notes() {
    if (is_muted) return {};
    return {this, [](void* self, const char* text) {
              auto& calls = *static_cast<ModelCalls*>(self);
              calls.note_book.keep(*calls.component(), *calls.pointer_, calls.call(), calls.time(), text);
            }};
  }

  /// Leaves one on the component that was called last.
  void note(const char* call, const char* text) { note_book.keep(*component(), *pointer_, call, time(), text); }

  /// Calls the component of a plan. A call that returns is over; one that throws stays until leave(), to be named.
  template <class Plan, class Act>
  auto during(const Plan& plan, const char* name, Act&& act) {
    return during(plan.type, plan.pointer, name, act);
  }
  template <class Act>
  auto during(const std::string& type, const std::string& pointer, const char* name, Act&& act) {
    pointer_ = &pointer;
    enter(nullptr, type, name);
    if constexpr (std::is_void_v<std::invoke_result_t<Act&>>) {
      act();
      leave();
    } else {
      const auto result = act();
      leave();
      return result;
    }
  }

 private:
  const std::string* pointer_ = nullptr;
};

}  // namespace binnacle::internal::filter
