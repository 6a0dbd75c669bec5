// SPDX-License-Identifier: Apache-2.0
// How a model is called when it is examined: outputs between canaries, inputs that are looked at again, exceptions
// turned into the host's own.
#pragma once

#include <bit>
#include <cstdint>
#include <deque>
#include <exception>
#include <string>
#include <vector>

#include "binnacle/testing.hpp"

namespace binnacle::testing {

inline bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }
inline std::size_t as_size(int i) { return static_cast<std::size_t>(i); }
inline void append(std::vector<double>& all, const std::vector<double>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

/// Doubles between canaries.
class Guarded {
 public:
  Guarded(std::size_t size, double fill);
  double* data() { return values_.data() + margin; }
  const double* data() const { return values_.data() + margin; }
  std::size_t size() const { return values_.size() - 2 * margin; }
  bool is_intact() const;
  /// Whether an element still holds the fill, to the bit; asked of NaN fills only.
  bool has_unwritten() const;
  std::vector<double> values() const { return {data(), data() + size()}; }

 private:
  static constexpr std::size_t margin = 8;
  std::vector<double> values_;
  double fill_;
};

/// Adds to `damage`, unless it holds something: written beyond the end, or (a NaN fill) not written completely.
void examine(const Guarded& block, const std::string& what, double fill, std::string& damage);

/// What a model may read and must not write, copied between canaries.
class Inputs {
 public:
  /// The copy to be handed out; null stays null. `name` stands in the complaint.
  const double* keep(std::string name, const double* values, std::size_t count);
  ConstVectorView keep(std::string name, ConstVectorView values) {
    return {keep(std::move(name), values.data(), static_cast<std::size_t>(values.size())), values.size()};
  }
  const double* keep(std::string name, const std::vector<double>& values) {
    return keep(std::move(name), values.data(), values.size());
  }
  /// What `call` wrote to all the same; "" when nothing.
  std::string damage(const char* call) const;

 private:
  struct Kept {
    std::string name;
    std::vector<double> original;
    Guarded copy;
  };
  std::deque<Kept> all_;
};

/// Stored values of the ports, null where open. spec: for their names, may be null.
std::vector<const double*> pointers(const PortStates& ports, const ComponentSpec* spec, Inputs& inputs);

/// The same sample on guarded copies of its numbers.
SampleView guarded_sample(const SampleView& sample, const std::vector<FieldSpec>& fields, const std::string& name,
                          Inputs& inputs);
/// One per input of the spec; those that are not given have emitted nothing yet.
std::vector<SampleView> guarded_inputs(std::span<const SampleView> given, const ComponentSpec& spec, Inputs& inputs);

/// Who learns of each call: where a crash was, how long it took.
class CallObserver {
 public:
  virtual ~CallObserver() = default;
  virtual void before(const char* call) = 0;  // text with static lifetime
  virtual void after() = 0;
};
/// For the whole process; null: nobody.
void observe_calls(CallObserver* observer);
CallObserver* call_observer();

/// Makes a call of a model. What it throws becomes CallThrew, while the thrown object's own code is still there.
template <class Call>
auto called(const char* name, const Call& call) {
  struct Observed {
    CallObserver* observer = call_observer();
    explicit Observed(const char* of) {
      if (observer) observer->before(of);
    }
    ~Observed() {
      if (observer) observer->after();
    }
  };
  try {
    const Observed observed(name);
    return call();
  } catch (const std::exception& error) {
    throw CallThrew(std::string("an exception crosses in ") + name + "(): " + error.what());
  } catch (...) {
    throw CallThrew(std::string("something that is not a std::exception crosses in ") + name + "()");
  }
}

}  // namespace binnacle::testing
