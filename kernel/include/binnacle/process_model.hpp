// SPDX-License-Identifier: Apache-2.0
// ProcessModel: how blocks move between two instants.
#pragma once

#include <cassert>
#include <span>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/declaration.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/model_input.hpp"
#include "binnacle/result.hpp"
#include "binnacle/time.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// A block of Φ, F, Q or GQGᵀ that a process model writes completely; null where nobody wants it.
class BlockView {
 public:
  constexpr BlockView() = default;
  constexpr BlockView(double* data, int rows, int cols, Structure structure) noexcept
      : data_(data), rows_(rows), cols_(cols), structure_(structure) {}

  constexpr explicit operator bool() const noexcept { return data_ != nullptr; }
  constexpr double* data() const noexcept { return data_; }
  constexpr int rows() const noexcept { return rows_; }
  constexpr int cols() const noexcept { return cols_; }

  /// All of a dense block: `phi.as<3, 3>()`, or `phi.as()` where the size is known at run time only.
  template <int Rows = dynamic, int Cols = dynamic>
  MapOf<Rows, Cols> as() const {
    assert(!data_ || structure_ == Structure::dense);
    assert((Rows == dynamic || (data_ && rows_ == Rows)) && (Cols == dynamic || (data_ && cols_ == Cols)));
    return {data_, rows_, cols_};
  }
  /// The diagonal of a diagonal block.
  template <int Rows = dynamic>
  MapOf<Rows> diagonal() const {
    assert(!data_ || structure_ == Structure::diagonal);
    assert(Rows == dynamic || (data_ && rows_ == Rows));
    return MapOf<Rows>(data_, rows_);
  }
  void set_zero() const noexcept {
    for (int i = 0; i < size(); ++i) data_[i] = 0.0;
  }
  void set_identity() const noexcept {
    set_zero();
    const int step = structure_ == Structure::diagonal ? 1 : rows_ + 1;
    for (int i = 0; i < rows_ && i < cols_; ++i) data_[i * step] = 1.0;
  }

 private:
  int size() const noexcept { return structure_ == Structure::diagonal ? rows_ : rows_ * cols_; }

  double* data_ = nullptr;
  int rows_ = 0;
  int cols_ = 0;
  Structure structure_ = Structure::dense;
};

/// A block that a ProcessDeclaration lists.
template <class Of>
class BlockHandle {
 public:
  constexpr BlockHandle() = default;
  constexpr BlockHandle(int index, int rows, int cols, Structure structure) noexcept
      : index_(index), rows_(rows), cols_(cols), structure_(structure) {}

  /// False: of an open port, or never declared. Its views are null.
  constexpr bool is_declared() const noexcept { return index_ >= 0; }
  constexpr int index() const noexcept { return index_; }
  constexpr BlockView in(double* const* table) const noexcept {
    return table && index_ >= 0 ? BlockView(table[index_], rows_, cols_, structure_) : BlockView();
  }

 private:
  int index_ = -1;
  int rows_ = 0;
  int cols_ = 0;
  Structure structure_ = Structure::dense;
};

/// Handle of a block of Φ (of F in linearized()), from ProcessDeclaration::couples().
using PhiBlock = BlockHandle<struct OfPhi>;
/// Handle of a block of Qd (of GQGᵀ in linearized()), from ProcessDeclaration::adds_noise().
using QBlock = BlockHandle<struct OfQ>;

/// Blocks by handle: `phi[phi_pv]`.
template <class Handle>
class BlockTable {
 public:
  constexpr BlockTable() = default;
  constexpr BlockTable(double* const* by_index) noexcept : by_index_(by_index) {}

  BlockView operator[](Handle handle) const noexcept { return handle.in(by_index_); }
  /// Whether they are wanted.
  constexpr explicit operator bool() const noexcept { return by_index_ != nullptr; }

 private:
  double* const* by_index_ = nullptr;
};

/// What a bound process model will do at most:
///
///     phi_xx_ = declaration_.couples(x_, x_, Structure::diagonal);
///     q_xx_ = declaration_.adds_noise(x_, x_, Structure::diagonal);
///
/// A (to, to) block that is not listed is the identity, an off-diagonal block that is not listed is zero, and neither
/// costs anything: a random constant lists nothing.
struct ProcessDeclaration : MemoryDeclaration, Differentiable<ProcessDeclaration> {
  std::vector<Coupling> transition;
  std::vector<Coupling> noise;       // between advanced ports, one of (a, b) and (b, a) at most; the kernel mirrors it
  bool has_closed_form = true;       // propagate() is implemented
  bool has_continuous_form = false;  // linearized() is implemented: a linear model
  bool is_time_invariant = false;    // the kernel may keep what it once wrote
  bool is_at_rest = false;           // x⁺ = x

  /// Φ has a block with the rows of `to`, which is advanced, and the columns of `from`. Of an open port: nothing.
  PhiBlock couples(Port to, Port from, Structure structure = Structure::dense) {
    return add<PhiBlock>(transition, to, from, structure);
  }
  /// Qd has a block between two advanced ports.
  QBlock adds_noise(Port to, Port from, Structure structure = Structure::dense) {
    return add<QBlock>(noise, to, from, structure);
  }
  /// linearized() is implemented, besides propagate(): the kernel discretizes jointly with linear models that this one
  /// is coupled to through a port, and calls propagate() where there are none.
  ProcessDeclaration& has_both_forms() {
    has_closed_form = has_continuous_form = true;
    return *this;
  }
  /// linearized() is implemented, propagate() is not.
  ProcessDeclaration& only_continuous() {
    has_closed_form = false;
    has_continuous_form = true;
    return *this;
  }
  /// F and GQGᵀ are the same numbers at every call, Φ and Qd at every call of the same dt, whatever x and time are; it has
  /// no input, auxiliary channels or memory. The kernel then keeps them, discretized too, while steps are equally long: it
  /// calls propagate() with neither phi nor Qd, for x⁺ alone, and linearized() not at all; nor propagate() where the model
  /// has both forms and all its blocks of Φ are diagonal, (to, to): x⁺ is then Φ x, to the bit. Conformance checks that.
  ProcessDeclaration& time_invariant() {
    is_time_invariant = true;
    return *this;
  }
  /// It is time_invariant(), lists no blocks, and nothing that it advances moves: x⁺ is x, to the bit. The kernel then
  /// copies x and calls propagate() only now and then.
  ProcessDeclaration& at_rest() {
    is_at_rest = true;
    return time_invariant();
  }

 private:
  template <class Handle>
  static Handle add(std::vector<Coupling>& blocks, Port to, Port from, Structure structure) {
    if (!to.is_bound() || !from.is_bound()) return {};
    blocks.push_back({to.index(), from.index(), structure});
    return Handle(static_cast<int>(blocks.size()) - 1, to.dof(), from.dof(), structure);
  }
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
  bool bridges = false;  // no sample of the sensor: it bridges a hole with rates held over it

  bool is_fragment() const noexcept { return t0 != whole_t0 || t1 != whole_t1; }
  double operator[](Field field) const noexcept { return fields[field.index()]; }
  template <int N>
  VectorOf<N> operator[](const Several<Field, N>& several) const noexcept {
    return several.of(*this);
  }
};

/// One propagation from t0 to t1. `samples` is empty for a model without input fields, else 1…samples_per_step
/// consecutive samples of possibly unequal length that fill it. dt is the sum of theirs [s]. A hole in the input is
/// bridged by a step of its own, which says so to every model: one may add what noise that deserves.
struct Step {
  Time t0 = no_time;
  Time t1 = no_time;
  double dt = 0;
  std::span<const InputSample> samples;
  bool bridges = false;
};

/// What propagate() is given.
struct ProcessInput {
  Step step;
  PortValues x;                // stored values at t0
  AuxiliarySamples auxiliary;  // of the channels of ComponentSpec::inputs
  MemoryView memory;
  Notes notes;
};

/// Where a step is written. Blocks hold garbage on entry and must be written completely. phi and Qd are each null as a
/// whole when nobody wants them; x is the same to the bit without them.
struct ProcessOutput {
  PortOutputs x;             // stored value at t1; null for ports that are only read
  BlockTable<PhiBlock> phi;  // ∂δ(t1)/∂δ(t0)
  BlockTable<QBlock> Qd;     // in the error dof at t1
};

/// What linearized() is given: the stored values to linearize at.
struct ContinuousInput {
  PortValues x;
  AuxiliarySamples auxiliary = {};
  Notes notes = {};
};

/// Where a linear model writes its continuous form ẋ = F x + w, E[w wᵀ] = GQGᵀ δ(t).
struct ContinuousOutput {
  BlockTable<PhiBlock> F;  // here the (to, to) block means F, not Φ
  BlockTable<QBlock> GQGt;
};

/// Moves the blocks on its advanced ports; reads others. Every block of a filter is advanced by exactly one model.
///
/// All models of a filter see the a-priori x(t0), never each other's result. dt ≥ 0; dt = 0 gives x⁺ = x, Φ = I, Qd = 0.
class ProcessModel : public DeclaredModel<ProcessDeclaration> {
 public:
  /// Writes x⁺, Φ and Qd. `failed` stops the filter.
  virtual Result propagate(const ProcessInput& /*in*/, ProcessOutput& /*out*/) const {
    return Result::failed("this model has no closed form");
  }
  /// The continuous form at x. The kernel discretizes it (Van Loan), jointly with other linear models that it is
  /// coupled to through a port, so that the cross terms of Qd are right. Stored value and error must be the same
  /// vector (x⁺ = Φ x).
  virtual void linearized(const ContinuousInput& /*in*/, ContinuousOutput& /*out*/) const {}
};

}  // namespace binnacle
