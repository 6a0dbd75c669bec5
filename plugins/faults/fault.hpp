// SPDX-License-Identifier: Apache-2.0
// One fault: what it does to a sample, when, and to which of its fields.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/sample.hpp"
#include "random/philox.hpp"

namespace binnacle::faults {

enum class Kind {
  step,
  ramp,
  noise,
  outliers,
  freeze,
  drop,
  delay,
  jitter,
  scale,
  swap,
  negate,
  nan,
  quantize,
  duplicate
};

/// What a fault remembers from sample to sample.
struct FaultMemory {
  random::Philox random{};
  std::int64_t is_held = 0;  // the held values below are there
};

/// A sample under way: the numbers lie where the writer says.
struct Spoilt {
  SampleWriter& out;
  Time first;               // of the channel's first sample
  bool is_dropped = false;  // nobody gets it
  bool is_doubled = false;  // whoever gets it, gets it twice
};

class Fault {
 public:
  static ParameterSpec spec();
  /// Of the list's element `place` ("/faults/0"); throws ComponentError with a pointer inside of it.
  Fault(const ParameterValue& element, const ChannelDeclaration& channel, const std::string& place);

  /// Values that it holds between samples.
  std::size_t held() const { return holds_ ? targets_.size() * static_cast<std::size_t>(held_rows_) : 0; }
  void apply(Spoilt& sample, FaultMemory& memory, double* held) const;

 private:
  /// A field of the channel: per epoch, or one of each row.
  struct Target {
    int index = 0;
    bool is_per_row = false;
    int metres_along = -1;  // 0: a latitude, 1: a longitude to which `by` is metres north, east; −1: `by` is as it is
  };
  struct Amounts;

  void find_fields(const Parameters& parameters, const ChannelDeclaration& channel);
  void find_row_filter(const Parameters& parameters, const ChannelDeclaration& channel);
  void find_amount(const ParameterValue& element, const ChannelDeclaration& channel);
  void check_keys(const ParameterValue& element) const;
  void fit(const FieldSpec& field, const std::string& unit, std::string_view key, Target& target) const;
  [[noreturn]] void refuse(const std::string& why, std::string_view key = {}) const;

  bool contains(Time t, Time first) const;
  bool is_meant(const SampleWriter& out, int row) const;
  template <class Act>
  void each_value(const SampleWriter& out, Act&& act) const;
  void hold(const SampleWriter& out, FaultMemory& memory, double* held, bool is_active) const;
  void spoil(Spoilt& sample, FaultMemory& memory, double* held) const;
  void spoil_values(const SampleWriter& out, FaultMemory& memory, Time elapsed) const;
  double outlier(random::Philox& random) const;

  Kind kind_ = Kind::step;
  std::string place_;
  std::vector<Target> targets_;
  bool is_of_covariance_ = false;
  int row_field_ = -1;  // among the per-row fields: only rows with row_value_ there are meant
  double row_value_ = 0;
  int lat_ = -1, height_ = -1;  // among the per-epoch fields, for metres; −1: the channel lacks it
  double by_ = 0;               // in the field's unit, or metres; of `delay` and `jitter` seconds
  bool is_factor_ = false;      // noise: `by_` times the value
  int tail_ = 0;                // of outliers: degrees of freedom of Student's t; 0: normal; −1: of one size
  Time from_ = 0, until_ = 0;
  bool has_from_ = false, has_until_ = false, is_from_start_ = false;
  double share_ = 1;
  bool holds_ = false;
  int held_rows_ = 1;
};

}  // namespace binnacle::faults
