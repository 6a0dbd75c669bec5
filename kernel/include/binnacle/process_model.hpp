// SPDX-License-Identifier: Apache-2.0
// ProcessModel: how blocks move between two instants.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/result.hpp"
#include "binnacle/time.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// How much of a block of Φ, F or Q is ever non-zero; the kernel does no arithmetic on the rest.
/// `dense`: the array holds dof(to)×dof(from) doubles, column-major. `diagonal`: the array holds the dof diagonal
/// elements (both ports of equal dof).
enum class Structure { dense, diagonal };

/// The block of Φ with the rows of port `to` and the columns of port `from`. Ports by index in the spec's order.
struct Coupling {
  int to = 0;
  int from = 0;
  Structure structure = Structure::dense;
};

/// What a bound process model will do at most.
///
/// A (to, to) block that is not listed is the identity, an off-diagonal block that is not listed is zero, and neither
/// costs anything: a random constant lists nothing. `noise` lists blocks of Q between advanced ports, one of (a, b) and
/// (b, a) at most; the kernel mirrors it.
struct ProcessDeclaration {
  std::vector<Coupling> transition;
  std::vector<Coupling> noise;
  std::size_t memory_bytes = 0;      // in the arena; zeroed, then initialised by start()
  bool has_closed_form = true;       // propagate() is implemented
  bool has_continuous_form = false;  // linearized() is implemented: a linear model
  bool is_time_invariant = false;    // linearized() depends on neither x nor u
};

/// One input sample, or the fragment of one that lies inside a step. `fields` are those of the spec, in its order and
/// kind: a rate is the mean over (t0, t1], an increment the integral over it. dt is the length the numbers belong to
/// [s]; it differs from t1 − t0 where the channel has a fixed `interval` and jittery labels.
/// A fragment is cut proportionally; whole_t0, whole_t1 bound the sample that it was cut from.
struct InputSample {
  Time t0 = no_time;
  Time t1 = no_time;
  double dt = 0;
  Time whole_t0 = no_time;
  Time whole_t1 = no_time;
  const double* fields = nullptr;

  bool is_fragment() const noexcept { return t0 != whole_t0 || t1 != whole_t1; }
};

/// One propagation from t0 to t1. `samples` is empty for a model without input fields, else 1…samples_per_step
/// consecutive samples of possibly unequal length that fill it. dt is the sum of theirs [s].
struct Step {
  Time t0 = no_time;
  Time t1 = no_time;
  double dt = 0;
  std::span<const InputSample> samples;
};

/// Where a step is written. Arrays are indexed by port (x_plus) and by position in the declaration (transition, noise).
/// All memory is the kernel's; transition and noise blocks hold garbage on entry and must be written completely.
struct ProcessOutput {
  double* const* x_plus = nullptr;      // per port: stored value at t1; null for ports that are only read
  double* const* transition = nullptr;  // per Coupling: Φ block, ∂δ(t1)/∂δ(t0)
  double* const* noise = nullptr;       // per Coupling: Qd block, in the error dof at t1
};

/// Where a linear model writes its continuous form ẋ = F x + w, E[w wᵀ] = GQGᵀ δ(t).
struct ContinuousOutput {
  double* const* dynamics = nullptr;  // per Coupling of `transition`: F block, here with (to, to) meaning F not Φ
  double* const* noise = nullptr;     // per Coupling of `noise`: GQGᵀ block
};

/// Moves the blocks on its advanced ports; reads others. Every block of a filter is advanced by exactly one model.
///
/// All models of a filter see the a-priori x(t0), never each other's result. The model is immutable after its
/// constructor: what it must remember lies in `memory`. Never throws, never allocates. dt ≥ 0; dt = 0 gives x⁺ = x,
/// Φ = I, Qd = 0.
class ProcessModel {
 public:
  virtual ~ProcessModel() = default;

  virtual const ProcessDeclaration& declaration() const noexcept = 0;
  /// Initialises memory at the start of a run.
  virtual void start(std::byte* /*memory*/) const {}

  /// x[port]: stored values at t0 (null for open ports). Writes x⁺, Φ and Qd. `failed` stops the filter.
  virtual Result propagate(const Step& /*step*/, const double* const* /*x*/, std::byte* /*memory*/,
                           const ProcessOutput& /*out*/) const {
    return Result::failed("this model has no closed form");
  }
  /// The continuous form at x. The kernel discretizes it (Van Loan), jointly with other linear models that it is
  /// coupled to through a port, so that the cross terms of Qd are right. Stored value and error must be the same
  /// vector (x⁺ = Φ x).
  virtual void linearized(const double* const* /*x*/, const ContinuousOutput& /*out*/) const {}
};

}  // namespace binnacle
