// SPDX-License-Identifier: Apache-2.0
// StateBlock: a part of what is estimated, with its own manifold.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/result.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// A number that can be read from a block's value and that initial values and references are given in: roll, lat, …
///
///     output("lat", "rad").shown_in("deg").angle().unscored().about("geodetic latitude, WGS-84")
struct Output {
  std::string name;
  std::string unit;               // SI
  std::string display_unit = {};  // for tables: "deg"; "" = unit
  bool is_angle = false;          // differences wrap to (−π, π]
  bool is_scored = true;          // false: its error is better given by an error component (lat by north)
  std::string text = {};          // one line, with the frame

  Output&& shown_in(std::string unit_of_tables) && { return with(*this, display_unit, std::move(unit_of_tables)); }
  Output&& angle() && { return with(*this, is_angle, true); }
  Output&& unscored() && { return with(*this, is_scored, false); }
  Output&& about(std::string line) && { return with(*this, text, std::move(line)); }
};

inline Output output(std::string name, std::string unit) { return {std::move(name), std::move(unit)}; }

/// The length of some error components taken together: horizontal = {north, east}.
struct Norm {
  std::string name;
  std::vector<int> components;
};

/// What a block is: kind, size, error components, outputs, norms.
struct StateBlockDeclaration {
  std::string kind;              // "attitude", "velocity.ned", "vector:3:rad/s"
  int stored_size = 0;           // doubles of the value
  std::vector<NamedUnit> error;  // error components; their count is the dof
  std::vector<Output> outputs;
  std::vector<Norm> norms;
  std::string error_display_unit;  // for tables: "deg"; "" = the SI unit of the components
  bool starts_at_zero = false;     // without "init" all outputs are zero; in it, one number stands for all of them

  int dof() const noexcept { return static_cast<int>(error.size()); }
};

/// A part of the state: a value x on a manifold and an error δ in R^dof with truth = x ⊞ δ.
///
/// Laws (the conformance suite checks them): x ⊞ 0 = x; (x ⊞ δ) ⊟ x = δ for |δ| inside the chart; x ⊞ (y ⊟ x) = y;
/// write(read(x)) = x up to representation. Everything is const and touches only its arguments; `x` and `result` may
/// be the same memory. Never throws, never allocates.
class StateBlock {
 public:
  virtual ~StateBlock() = default;

  virtual const StateBlockDeclaration& declaration() const noexcept = 0;

  /// result = x ⊞ δ. x, result: stored_size. delta: dof.
  virtual void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const = 0;
  /// delta = y ⊟ x, that is x ⊞ delta = y.
  virtual void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const = 0;
  /// The readable outputs of x, in the declared order [SI].
  virtual void read(ConstVectorView x, VectorView outputs) const = 0;
  /// x from a complete set of readable outputs, or a refusal (a latitude beyond the pole).
  virtual Result write(ConstVectorView outputs, VectorView x) const = 0;
  /// How injecting δ at x (the value before) turns the remaining error: δ_new = G (δ_old − δ) to first order. G: dof×dof.
  /// False (the default) means G = I.
  virtual bool reset_jacobian(ConstVectorView /*x*/, ConstVectorView /*delta*/, MatrixView /*G*/) const {
    return false;
  }
  /// How the outputs of x turn with an error: read(x ⊞ δ) = read(x) + J δ to first order. J: outputs × dof.
  /// False (the default, or at an x where the derivative does not hold) means: by differences, as output_sigmas() does.
  virtual bool output_jacobian(ConstVectorView /*x*/, MatrixView /*J*/) const { return false; }
};

}  // namespace binnacle
