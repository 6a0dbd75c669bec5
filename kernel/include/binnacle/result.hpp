// SPDX-License-Identifier: Apache-2.0
// Typed refusals: what a model answers when it cannot do what it was asked.
#pragma once

namespace binnacle {

/// `unsupported`: the model does not apply here (too slow for a course, a port's block outside its domain).
/// `invalid`: the sample itself is not usable (negative variance, a value out of range).
/// `failed`: the model cannot go on; a filter whose process model fails stops with this as its diagnosis.
enum class Refusal { none, unsupported, invalid, failed };

/// A refusal with its reason, or ok: text with static lifetime in the plugin (a literal), shown in the ledger.
struct Result {
  Refusal refusal = Refusal::none;
  const char* reason = "";

  static constexpr Result ok() noexcept { return {}; }
  static constexpr Result unsupported(const char* reason) noexcept { return {Refusal::unsupported, reason}; }
  static constexpr Result invalid(const char* reason) noexcept { return {Refusal::invalid, reason}; }
  static constexpr Result failed(const char* reason) noexcept { return {Refusal::failed, reason}; }
  constexpr explicit operator bool() const noexcept { return refusal == Refusal::none; }
};

/// The outcome of a sample of a measurement.
enum class Outcome { accepted, gated, late, unsupported, invalid, withheld, rejected };
inline constexpr int outcome_count = 7;

}  // namespace binnacle
