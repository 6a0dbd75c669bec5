// SPDX-License-Identifier: Apache-2.0
// The conformance suite's own checkers, in process: for a plugin's own tests, with Catch2 or whatever else.
//
//     const auto at = binnacle::testing::PortStates{{&position, {300, 200}, 10.0}};
//     const binnacle::testing::MeasurementCaller range(model, spec);
//     const auto complaints = check_measurement(range, {sample}, at, range.fresh_memory(), {.relative = 1e-6});
//     INFO(complaints.text());
//     REQUIRE(complaints.empty());
//
// Each call of a model is made as the suite makes it: outputs lie between canaries and hold garbage on entry where the
// kernel leaves garbage, inputs are copies that are looked at again after the call. Whatever is found wrong is a line of
// Complaints that names the block and the element. Links with Binnacle::testing; needs Eigen and nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "binnacle/derived_block.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/noise_estimator.hpp"
#include "binnacle/process_model.hpp"
#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle::testing {

/// What a check found wrong, a line each.
class Complaints {
 public:
  template <class... Parts>
  void add(const Parts&... parts) {
    std::ostringstream line;
    line.precision(9);
    (line << ... << parts);
    lines_.push_back(line.str());
  }
  void add_all(const Complaints& others) { lines_.insert(lines_.end(), others.lines_.begin(), others.lines_.end()); }
  bool empty() const { return lines_.empty(); }
  std::size_t size() const { return lines_.size(); }
  const std::vector<std::string>& lines() const { return lines_; }
  std::string text() const {
    std::string all;
    for (const auto& line : lines_) all += line + "\n";
    return all;
  }

 private:
  std::vector<std::string> lines_;
};

/// A block as it stands on a port while derivatives are taken.
struct PortState {
  PortState() = default;  // an open port
  PortState(const StateBlock* of_block, std::vector<double> value, Eigen::VectorXd of_errors, double of_minus = 0)
      : block(of_block), x(std::move(value)), scale(std::move(of_errors)), resolution(of_minus) {}
  /// The same size of error in every component.
  PortState(const StateBlock* of_block, std::vector<double> value, double of_errors = 1e-3, double of_minus = 1e-15)
      : PortState(of_block, std::move(value), Eigen::VectorXd::Constant(of_block->declaration().dof(), of_errors),
                  of_minus) {}

  const StateBlock* block = nullptr;  // null: the port is open
  std::vector<double> x;              // stored value
  Eigen::VectorXd scale;  // a plausible error per component, in its unit; differences are taken in steps of it
  double resolution = 0;  // of ⊟ there, in the unit of the components: what a difference cannot see through

  bool is_open() const { return block == nullptr; }
  int dof() const { return block ? block->declaration().dof() : 0; }
};
using PortStates = std::vector<PortState>;  ///< in the order of the spec

/// Rows (columns) that lie before those of `port` in a matrix over all ports.
int offset(const PortStates& ports, std::size_t port);

/// How near a declared derivative B must come to differences (D = B − I for the block of a port on itself):
///
///     |numeric − B|_ij ≤ relative · max|D| + (neglected · scale_i + 8 · resolution / step) / scale_j
///
/// where scale_i is the plausible size of what row i is of (measurements: the row's own, see check_measurement), and
/// scale_j that of the port's component. Differences are central with Richardson's extrapolation, in steps of `steps`
/// scales; B must agree with those of one step, for no single step suits every function.
struct Tolerance {
  double relative = 1e-6;
  double neglected = 0;
  std::vector<double> steps = {1.0};
  bool neglects_declared = true;  // false, for a process: `neglected` counts only where the model declares nothing
};

/// The steps of the suite, for functions that it knows nothing of.
inline const std::vector<double> step_sweep = {1e-2, 1e-3, 1e-4, 1e-5};

/// Thrown instead of what a model threw, with its text: the thrown object's own class may be the plugin's, and gone.
class CallThrew : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// ---- process models

/// One call of a process model.
struct Propagated {
  Result result;
  std::vector<std::vector<double>> x_plus;  // per port; empty for those only read
  std::vector<Eigen::MatrixXd> transition;  // per declared coupling, dense. Of a continuous form: F
  std::vector<Eigen::MatrixXd> noise;       // per declared coupling, dense. Of a continuous form: GQGᵀ
  std::vector<std::byte> memory;            // as the call left it
  std::vector<double> numbers;              // all that was written
  std::string damage;  // what was written that should not be, or not written that should; "" : nothing
};

/// A NaN that no arithmetic makes: the fill of outputs that must be written completely.
double unwritten();

/// Calls a process model as the conformance suite does.
class ProcessCaller {
 public:
  /// All must outlive it. auxiliary: a sample per input of the spec, in its order; none may be given where it has none.
  ProcessCaller(const ProcessModel& model, const ComponentSpec& spec, std::span<const SampleView> auxiliary = {})
      : model_(&model), spec_(&spec), auxiliary_(auxiliary) {}

  std::vector<std::byte> fresh_memory() const;
  /// The closed form. `memory` is copied; the copy the call wrote to is in the answer. with_errors false: neither Φ nor Qd
  /// is wanted, and the answer has none.
  Propagated propagate(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory,
                       double fill = unwritten(), bool with_errors = true) const;
  /// The continuous form.
  Propagated linearized(const PortStates& ports, double fill = unwritten()) const;

  /// Φ over all ports: identity where nothing is declared.
  Eigen::MatrixXd Phi(const PortStates& ports, const Propagated& p) const;
  /// Qd (or GQGᵀ) over all ports, mirrored.
  Eigen::MatrixXd Q(const PortStates& ports, const Propagated& p) const;
  /// F over all ports.
  Eigen::MatrixXd F(const PortStates& ports, const Propagated& continuous) const;
  /// The ports as the step left them.
  PortStates after(PortStates ports, const Propagated& p) const;

  bool advances(std::size_t port) const { return (*spec_).ports[port].access == PortAccess::advances; }
  /// Whether it is bound as well.
  bool moves(const PortStates& ports, std::size_t port) const { return advances(port) && !ports[port].is_open(); }
  const ProcessModel& model() const { return *model_; }
  const ComponentSpec& spec() const { return *spec_; }
  const ProcessDeclaration& declared() const { return model_->declaration(); }

 private:
  Eigen::MatrixXd whole(const PortStates& ports, const std::vector<Coupling>& couplings,
                        const std::vector<Eigen::MatrixXd>& blocks, bool identity, bool mirrored) const;
  const ProcessModel* model_;
  const ComponentSpec* spec_;
  std::span<const SampleView> auxiliary_;
};

/// Every block of Φ, declared or not, against differences of x⁺ on the manifolds.
Complaints check_transition(const ProcessCaller& process, const PortStates& ports, const Step& step,
                            const std::vector<std::byte>& memory, const Tolerance& tolerance);
/// The greatest difference between Φ and the differences of x⁺, in units of the scales; shows its order in dt.
double transition_error(const ProcessCaller& process, const PortStates& ports, const Step& step,
                        const std::vector<std::byte>& memory);
/// x⁺ is the same to the bit when neither Φ nor Qd is wanted, and so is what the next call makes of the memory.
Complaints check_values(const ProcessCaller& process, const PortStates& ports, const Step& step,
                        const std::vector<std::byte>& memory);
/// dt = 0: x⁺ = x, Φ = I, Qd = 0, each to `rounding` of the scales (Qd: of `ordinary`, a Qd over an ordinary dt).
Complaints check_rest(const ProcessCaller& process, const PortStates& ports, const Step& step,
                      const std::vector<std::byte>& memory, const Eigen::MatrixXd& ordinary, double rounding = 1e-12);
/// Q (a Qd over all ports) is symmetric and positive semidefinite. `of` names it in the complaint.
Complaints check_noise_form(const Eigen::MatrixXd& Q, const std::string& of);

/// A step in parts.
struct Accumulated {
  Result result;
  PortStates ports;  // at its end
  Eigen::MatrixXd Phi, Q;
  std::vector<std::byte> memory;
};
Accumulated accumulate(const ProcessCaller& process, const PortStates& ports, const std::vector<Step>& parts,
                       const std::vector<std::byte>& memory);
/// Qd of one step against Σ Φ Q Φᵀ over the parts that fill it, block by block: |difference| ≤ relative · the block's
/// largest element + neglected · √(Q_ii Q_jj), the largest variances of its two ports.
Complaints check_noise(const ProcessCaller& process, const PortStates& ports, const Step& whole,
                       const std::vector<Step>& parts, const std::vector<std::byte>& memory, double relative,
                       double neglected = 1e-12);
/// Φ and Qd of ẋ = F x + w over dt (Van Loan 1978), as the kernel makes them of continuous forms.
std::pair<Eigen::MatrixXd, Eigen::MatrixXd> van_loan(const Eigen::MatrixXd& F, const Eigen::MatrixXd& GQGt, double dt);

// ---- measurement models

/// One call of a measurement model.
struct Measured {
  Result result;
  Eigen::VectorXd residual;        // of the rows that the model used
  std::vector<Eigen::MatrixXd> H;  // per entry of `reads`
  Eigen::MatrixXd R;
  std::vector<std::int64_t> keys;  // of the rows
  std::vector<std::byte> memory;   // as the call left it
  std::vector<double> numbers;     // all that was written
  std::string damage;
};

/// What a model may be given besides the state.
struct Given {
  SampleView sample;
  std::span<const SampleView> auxiliary = {};  // one per input of the spec, in its order; none where the spec has none
  Driving u = {};
};

/// A sample with rows of `width` numbers each, those of a row in the order in which the spec declares the fields per row;
/// the numbers must outlive it.
inline SampleView rows_of(std::span<const double> numbers, int width, Time t) {
  SampleView sample;
  sample.t = t;
  sample.rows = static_cast<int>(numbers.size()) / width;
  sample.row_fields = numbers.data();
  sample.available = true;
  return sample;
}

/// Calls a measurement model as the conformance suite does.
class MeasurementCaller {
 public:
  MeasurementCaller(const MeasurementModel& model, const ComponentSpec& spec) : model_(&model), spec_(&spec) {}
  /// For single calls: without the spec nobody knows how many numbers a sample has, and it is handed out as it is.
  explicit MeasurementCaller(const MeasurementModel& model) : model_(&model) {}

  std::vector<std::byte> fresh_memory() const;
  /// Where the model wants the covariance of what it reads, it is given that of independent errors of the ports' scales.
  /// with_H false: only values are wanted, and H in the answer is zero.
  Measured linearize(const Given& given, const PortStates& ports, const std::vector<std::byte>& memory,
                     double fill = unwritten(), bool with_H = true) const;
  const MeasurementModel& model() const { return *model_; }
  const ComponentSpec& spec() const { return *spec_; }

 private:
  const MeasurementModel* model_;
  const ComponentSpec* spec_ = nullptr;
};

/// H, that of ports which are not read included, against −∂r/∂δ. The size of a row is what plausible errors make of it:
/// |numeric − H|_ij ≤ (relative · Σ_k |H_ik| scale_k + neglected · √R_ii + 8 · resolution / step) / scale_j.
Complaints check_measurement(const MeasurementCaller& measurement, const Given& given, const PortStates& ports,
                             const std::vector<std::byte>& memory, const Tolerance& tolerance, double resolution = 0);
/// Residual, R and keys are the same to the bit when no H is wanted, and so is what the next call makes of the memory. With
/// a residual of zero a wrong factor does not show.
Complaints check_values(const MeasurementCaller& measurement, const Given& given, const PortStates& ports,
                        const std::vector<std::byte>& memory);
/// R is symmetric and positive semidefinite.
Complaints check_covariance(const Eigen::MatrixXd& R);

// ---- noise estimators

/// What an estimator is shown of a sample.
struct InnovationNumbers {
  Eigen::VectorXd residual;
  Eigen::MatrixXd HPHt, R_nominal;
  Time t = 0;
  double dt = 0.1;                      // s
  std::vector<std::int64_t> keys = {};  // empty: 0, 1, 2 …
  std::vector<int> groups = {};         // empty: all rows are of group 0
};

/// One call of a noise estimator.
struct Estimated {
  Eigen::MatrixXd R;
  std::string damage;
  std::vector<std::string> notes = {};  // that it left
};

/// Calls a noise estimator as the conformance suite does.
class NoiseCaller {
 public:
  explicit NoiseCaller(const NoiseEstimator& estimator) : estimator_(&estimator) {}
  std::vector<std::byte> fresh_memory() const;
  /// estimate(), and where it is wanted after(), as an update with the R that it gave leaves the sample. `memory` is
  /// written to.
  Estimated estimate(const InnovationNumbers& innovation, MemoryView memory) const;

 private:
  const NoiseEstimator* estimator_;
};

/// R is finite, symmetric and positive semidefinite, and nothing else is written.
Complaints check_noise(const NoiseCaller& noise, const InnovationNumbers& innovation, MemoryView memory);

// ---- sources and transforms

/// A sample as it was emitted.
struct Emitted {
  int channel = 0;  // index in the declaration
  Time t = no_time, t0 = no_time;
  int rows = 0;
  std::vector<double> fields;
  std::vector<double> row_fields;  // of these rows, row by row
  std::vector<double> covariance;  // column by column; empty: none is attached

  double operator[](OutputField field) const { return fields.at(static_cast<std::size_t>(field.index())); }
  /// What a subscriber sees that takes all fields as they are. Valid as long as this.
  SampleView view() const;
};

/// Calls a source as the conformance suite does, one sample at a time.
class SourceCaller {
 public:
  /// The source must be open, and outlive it.
  explicit SourceCaller(const Source& source) : source_(&source) {}
  /// One call of Source::next(); `damage` as in Propagated.
  struct Next {
    SourceStatus status = SourceStatus::end;
    Emitted sample;
    std::string damage;
  };
  std::vector<std::byte> fresh_memory(std::uint64_t seed) const;
  /// `memory` is written to. fill: what the numbers of a sample hold until they are written.
  Next next(MemoryView memory, double fill = unwritten()) const;

 private:
  const Source* source_;
};

/// Calls a transform as the conformance suite does.
class TransformCaller {
 public:
  TransformCaller(const Transform& transform, const ComponentSpec& spec) : transform_(&transform), spec_(&spec) {}
  /// What a transform made of one sample; `damage` as in Propagated.
  struct Made {
    std::vector<Emitted> samples;  // in the order of emit()
    std::string damage;
  };
  std::vector<std::byte> fresh_memory(std::uint64_t seed) const;
  /// input: index in the spec. `memory` is written to.
  Made on(std::size_t input, const SampleView& sample, MemoryView memory, double fill = unwritten()) const;

 private:
  const Transform* transform_;
  const ComponentSpec* spec_;
};

// ---- derived blocks

/// One call of a derived block.
struct Evaluated {
  Result result;
  std::vector<double> value;
  std::vector<Eigen::MatrixXd> J;  // per entry of `reads`; zero when no Jacobian was wanted
  std::vector<double> numbers;
  std::string damage;
};

/// Calls a derived block as the conformance suite does.
class DerivedCaller {
 public:
  DerivedCaller(const DerivedBlock& model, const ComponentSpec& spec) : model_(&model), spec_(&spec) {}
  Evaluated evaluate(const PortStates& ports, const Driving& u, bool with_jacobian = true,
                     double fill = unwritten()) const;
  const DerivedBlock& model() const { return *model_; }
  const ComponentSpec& spec() const { return *spec_; }

 private:
  const DerivedBlock* model_;
  const ComponentSpec* spec_;
};

/// J against differences of the value on the manifolds. yields: a state block of the kind yielded; scale: a plausible
/// error of it per component; resolution: of its ⊟.
Complaints check_derived(const DerivedCaller& derived, const StateBlock& yields, const Eigen::VectorXd& scale,
                         const PortStates& ports, const Driving& u, const Tolerance& tolerance, double resolution = 0);
/// The value is the same to the bit with and without Jacobians.
Complaints check_derived_value(const DerivedCaller& derived, const PortStates& ports, const Driving& u);

// ---- state blocks

/// How exactly the laws of a block must hold: |found − wanted| ≤ absolute · scale + relative · |wanted|, by component.
struct Exactness {
  double absolute = 1e-9;
  double relative = 1e-8;
};

/// x ⊞ 0 = x, (x ⊞ δ) ⊟ x = δ, x ⊞ (y ⊟ x) = y at `at` for δ; ⊞ in place gives the same to the bit.
Complaints check_laws(const PortState& at, const Eigen::VectorXd& delta, const Exactness& exactness = {});
/// write(read(x)) = x.
Complaints check_readable(const PortState& at, const Exactness& exactness = {});
/// reset_jacobian: δ_new = G (δ_old − δ) to first order, by differences of what remains after δ has been injected.
/// `share`: of the greatest element of G − I that it may be wrong by; `absolute` besides.
Complaints check_reset(const PortState& at, const Eigen::VectorXd& delta, double share, double absolute);
/// output_jacobian: ∂outputs/∂δ by central differences of step `step` · at.scale. `share`: of the greatest element of an
/// output's row that it may be wrong by. No complaint where the block gives none.
Complaints check_output_jacobian(const PortState& at, double step, double share);

}  // namespace binnacle::testing
