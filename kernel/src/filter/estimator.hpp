// SPDX-License-Identifier: Apache-2.0
// What a filter estimates: the stored state, the covariance of its errors, and the memories of its models.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "base/aligned.hpp"
#include "filter/model_calls.hpp"
#include "filter/plan.hpp"
#include "filter/sigma_points.hpp"

namespace binnacle::internal::filter {

/// The rows of the sample at work: linearize() fills them, judge() may thin them out, correct() applies them. R is what
/// the noise estimator makes of R_nominal, S is HPHᵀ + R. NIS, gate and monitors are of judged_R and innovation_S:
/// these two, or nominal where the estimator only weighs what has passed.
struct SampleRows : UpdateWork {
  explicit SampleRows(const FilterPlan& plan);
  SampleRows(const SampleRows&) = delete;
  SampleRows& operator=(const SampleRows&) = delete;

  /// No rows of this measurement yet.
  void begin(const MeasurementPlan& measurement);
  /// Lists the marked ones among those left out; and takes them out of everything but R, S and what follows from it.
  void list_left_out(const unsigned char* marked);
  void remove(const unsigned char* marked, int columns, int n);
  MatrixView square(double* matrix) const { return {matrix, m, m, m_max}; }
  OfferedRows offered() const { return {{keys.data(), std::size_t(m)}, groups.data(), square(HPHt)}; }
  UsedRows used(const double* its_post_fit) const {
    return {offered().keys, groups.data(), innovation, square(judged_R), square(innovation_S), its_post_fit};
  }
  UsedRows refused() const { return {offered().keys, groups.data(), r, square(R)}; }
  /// The first of those left out; of R the diagonal alone.
  UsedRows left_out_rows(int count) const {
    const ConstMatrixView diagonal{left_out_R.data(), count, count, 0};
    return {{left_out_keys.data(), std::size_t(count)}, left_out_groups.data(), left_out_r.data(), diagonal};
  }
  /// S as it is now stays what the sample was judged by.
  void keep_judged();

  double nis = 0;
  int left_out = 0;  // rows that a gate by row or key took out, and their keys and groups
  int removed = 0;   // of these, what are no rows here any more: all but the last, where it made the sample gated
  base::AlignedVector<double> R_nominal, S_nominal, delta;
  // The innovation at the a-priori state, and what it was judged by: r, R and S, but where R was replaced after the judgement or the
  // update was iterated. Then r, R, S and what belongs to them are of the correction.
  double *innovation = nullptr, *judged_R = nullptr, *innovation_S = nullptr;
  bool has_delta = false;  // `delta` is to be injected as it is; else it is K r
  // Where an accepted sample's rows are biased: which, the mean of r / √S and of how many it is. Else unused.
  std::vector<unsigned char> biased;
  std::vector<double> mean_z, mean_count;
  std::vector<std::int64_t> keys, left_out_keys;
  std::vector<int> groups, left_out_groups;
  std::vector<double> left_out_r, left_out_R, post_fit;  // post_fit: r − H δ, where it is wanted

 private:
  base::AlignedVector<double> H_, R_, r_, G_, HPHt_, S_, L_, K_, U_, y_;
};

/// Baarda's data snooping on an innovation (Teunissen, Quality control in integrated navigation systems, 1990). With
/// z = S⁻¹ r, leaving out the rows I lowers the NIS by
///     T_I = z_Iᵀ [(S⁻¹)_II]⁻¹ z_I ,   χ² of |I| dof for a right sample.
/// It holds I against what all other rows and the prediction say together, so an error that all rows share and that the
/// filter leaves open (a receiver clock's) counts against none of them. Sized once: find() does not allocate.
class OutlierTest {
 public:
  explicit OutlierTest(int max_rows);

  /// Marks the rows of the unit whose T_I is largest beyond limit[|I|]: a mask over the rows; null when there is none.
  /// Needs the factor L of S and y = L⁻¹ r.
  unsigned char* find(GateUnit unit, const std::vector<double>& limit, const SampleRows& rows);

 private:
  void invert(const UpdateWork& work);
  double statistic(int count);

  Eigen::MatrixXd inverse_;   // S⁻¹
  Eigen::VectorXd z_;         // S⁻¹ r
  Eigen::MatrixXd part_;      // (S⁻¹)_II
  Eigen::VectorXd part_z_;    // z_I
  std::vector<int> members_;  // I
  std::vector<unsigned char> is_tested_, worst_;
};

/// What a lock-out opens P by. Sized once: find() does not allocate.
class Opening {
 public:
  Opening(int n, int max_rows);

  /// Makes `scales` D such that with D P D the marked rows are no outliers any more, and what moves other rows is not
  /// opened; false where there is none. `marked` null: those that stand out, or all. Needs G and S. recovery.cpp
  bool find(const SampleRows& rows, const MeasurementPlan& measurement, const CovarianceForm& P,
            const std::vector<unsigned char>& corrected, int n, const unsigned char* marked);

  std::vector<double> scales;  // padded(n)

 private:
  bool is_explained(const SampleRows& rows, double epsilon) const;
  int collect(const SampleRows& rows, const MeasurementPlan& measurement, const unsigned char* marked);
  int member(int k) const { return members_[as_size(k)]; }

  std::vector<double> direction_;  // g, padded(n)
  Eigen::MatrixXd matrix_, inverse_;
  Eigen::VectorXd weights_, s_, z_, part_z_;
  std::vector<int> members_;  // U
};

/// Scratch of updates that evaluate a measurement at other states than the estimate. other_states.cpp
struct OtherStates {
  explicit OtherStates(const FilterPlan& plan);

  std::vector<double> x;                 // stored, of the other state
  std::vector<double> by_column;         // its distance δ from the estimate, by column of the compact H
  SampleRows rows;                       // there
  std::vector<std::byte> memory;         // of the models, as the call that counts left it
  std::vector<double> block_delta, row;  // of one block
};

/// Scratch of Gauss and Newton's method. iterate.cpp has the symbols.
struct Iteration {
  explicit Iteration(const FilterPlan& plan);

  std::vector<double> r, S;  // of the first linearization
  // δ by row of P and v by column of the compact H, δ = P v: of the newest state, as solved for next, and tried.
  std::vector<double> delta, v, next_delta, next_v, tried_delta, tried_v;
  std::vector<double> seen;  // H̃ Δ, and scratch of m
  std::vector<double> L_R;   // factor of R
  bool has_L_R = false;      // R is not singular
};

/// What became of the iterations of one sample.
struct Convergence {
  int iterations = 0;
  bool has_converged = true;
};

/// Sigma points of what a measurement sees, and what its residual is there.
struct SeenSigmaPoints {
  explicit SeenSigmaPoints(const FilterPlan& plan);

  SigmaPoints points;
  Eigen::MatrixXd P;          // of the columns
  Eigen::MatrixXd residuals;  // rows × points
  Eigen::MatrixXd fallback, M, Omega;
};

/// `accepted`, `withheld`, `gated`, or `rejected` where S is not positive definite.
struct Judgement {
  Outcome outcome = Outcome::accepted;
  const char* reason = "";
  bool is_locked_out = false;             // nothing is decided: P is to be opened, and the sample judged again
  const unsigned char* marked = nullptr;  // for these rows; null: for the sample
};

/// Whether the marked rows of the sample at work (null: all of them), refused once more, are locked out for good. May mark
/// more.
struct LockOutTest {
  void* self = nullptr;
  bool (*is_due)(void* self, const SampleRows& rows, unsigned char* marked) = nullptr;
  bool operator()(const SampleRows& rows, unsigned char* marked) const { return self && is_due(self, rows, marked); }
};

/// Φ = exp(F dt) and Qd = ∫ exp(F s) Q exp(F s)ᵀ ds. F, Q, Phi, Qd: n×n column-major, dense; work: four such matrices.
/// By scaling, a Taylor series to full precision, and doubling: Φ(2h) = Φ(h)², Qd(2h) = Qd(h) + Φ(h) Qd(h) Φ(h)ᵀ — the
/// same quantities as Van Loan (1978) eq. 2.13 without the exponential of −F, which overflows for fast stable modes.
void discretize(const double* F, const double* Q, int n, double dt, double* Phi, double* Qd, double* work);

/// All of it may throw Stop, or what a plugin throws. `now`: when models are called, with the mean rates of the last
/// driving interval in the input channel's order.
class Estimator {
 public:
  /// Allocates here and nothing afterwards.
  Estimator(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena, ModelCalls& calls);
  Estimator(const Estimator&) = delete;
  Estimator& operator=(const Estimator&) = delete;

  /// Before the start: x and P zero, memories as their models begin with them.
  void reset();
  /// x and P from the config or from the latest samples of the initial channels; anew: of those that may give them again.
  void start(bool anew);
  /// Whether the samples that it would start anew from contradict x: a component of a block that no measurement's
  /// channel gives is off by more than 5 sigma of both.
  bool is_contradicted();

  // ---- a step in three: what the models make of it; P; x. propagate.cpp

  /// From the a-posteriori x at `now` to t1: x_plus(), phi() and noise(). `is_nominal`: along a path that is known, where P
  /// stands still, Φ is the Jacobian.
  void propagate(const Driving& now, Time t1, std::span<const InputSample> samples, bool is_nominal = false);
  void predict(Time t1);
  void put(const double* stored) { std::copy_n(stored, plan_.stored_size, x()); }
  void advance() { std::copy_n(x_plus(), plan_.stored_size, x()); }
  const double* x_plus() const { return x_plus_.data(); }
  /// Tables of blocks.
  const double* const* phi() const { return phi_.data(); }
  const double* const* noise() const { return noise_.data(); }

  // ---- a sample in three. linearize() keeps the models' memories; roll_back() restores them

  /// Fills the rows of `measurement`, or refuses. `is_plain`: by Jacobians, whatever its update. linearize.cpp
  Result linearize(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now,
                   bool is_plain = false);
  /// Whether the last linearize() took Jacobians where sigma points are asked for.
  bool was_linearized_instead() const { return was_linearized_instead_; }
  /// Takes linearized rows to R, S, its factor and the NIS. dt: since the last accepted sample [s]. A withheld sample
  /// meets no noise estimator. update.cpp
  Judgement judge(const MeasurementPlan& measurement, Time t, double dt, bool is_withheld,
                  LockOutTest is_locked_out = {});
  /// Takes judged rows to the linearization about the a-posteriori state, the innovation kept apart. iterate.cpp
  Convergence iterate(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now);
  /// δ = K r, x ← x ⊞ δ, P by the form and then by the blocks' reset Jacobians, whole or not at all: every plugin call
  /// comes before x and P change.
  void correct(const MeasurementPlan& measurement);
  void roll_back(const MeasurementPlan& measurement);
  /// After a correction: the noise estimator sees what is left.
  void learn(const MeasurementPlan& measurement);
  const SampleRows& rows() const { return rows_; }
  SampleRows& rows() { return rows_; }
  /// Whether the last correct() transformed P by reset Jacobians, and by what: n×n.
  bool has_reset() const { return !resets_.empty(); }
  void expand_reset(MatrixView T) const;

  /// How many sigma the judged sample is off, beyond 5, where nothing confirms it; else 0. recovery.cpp
  double unconfirmed(bool is_confirmed) const;
  /// P ← D P D along what the marked rows of the judged sample see; false where that cannot be. recovery.cpp
  bool open(const MeasurementPlan& measurement, const unsigned char* marked);
  /// The same for rows that passed, by the means that `rows` holds of them; needs their projection by P as it is now.
  void project(const MeasurementPlan& measurement);
  bool open_by_mean(const MeasurementPlan& measurement);
  /// Adds the variances of the start, which it writes to `added`; of a component that is stationary no more than it has.
  void unlearn(double* added);
  /// P ← D P D with a share of the last correction, which was a large one.
  void keep_open();
  const double* opened() const { return opening_.scales.data(); }
  /// Adds a measurement's named variances to P.
  void inflate(const MeasurementPlan& measurement);

  /// Whether its state is finite, and its variances are neither negative nor beyond all bounds.
  bool is_sound() const;
  /// Stops a filter that is not.
  void check_step(Time t) const {
    if (!is_sound()) stop_unsound(t, culprit(t));
  }
  void check_update(Time t) const {
    if (!is_sound()) stop_unsound(t, "");
  }

  const double* state() const { return plan_.state.in(arena_); }
  ConstMatrixView covariance() const { return P_->expand(); }
  const CovarianceForm& form() const { return *P_; }
  /// The estimates as a sample: outputs of all blocks, P in their error dof.
  void write(SampleWriter& slot, const double* x, ConstMatrixView P);

 private:
  /// What a process reads and writes. Per port: the value, null where it is open; where x⁺ is written, null for ports that
  /// are only read.
  struct Ports {
    std::vector<const double*> inputs;
    std::vector<double*> outputs;
    bool reads_as_it_stands = false;  // the driving input, without conversions
  };
  /// The diagonal of a block of Qd or GQGᵀ that a process writes.
  struct Diagonal {
    const ProcessPlan* process = nullptr;
    const BlockPlan* block = nullptr;
    const double* q = nullptr;
    int step = 0;  // doubles from one element to the next
  };
  /// x⁺ of a block that the kernel scales; without factors it stands still.
  struct Scaling {
    double* next = nullptr;
    const double* factors = nullptr;
    const double* now = nullptr;
    int count = 0;
  };
  /// What the kernel gathers of Φ: elements as they stand, and blocks that are sums.
  struct Gathered {
    struct Copy {
      const double* from = nullptr;
      double* to = nullptr;
    };
    std::vector<Copy> copies;
    std::vector<const GatherPlan*> summed;
  };
  enum class Jacobians : unsigned char { none, wanted };
  /// While it lives, models read another state, by `read`, and leave no notes. The arena never holds any but the estimate.
  template <class Read>
  class Elsewhere {
   public:
    Elsewhere(Estimator& its, const double* x, Read read) : its_(its), read_(read) {
      read_(x);
      its_.calls_.is_muted = true;
    }
    Elsewhere(const Elsewhere&) = delete;
    Elsewhere& operator=(const Elsewhere&) = delete;
    ~Elsewhere() {
      read_(its_.state());
      its_.calls_.is_muted = false;
    }

   private:
    Estimator& its_;
    Read read_;
  };
  struct Reset {
    int first = 0;
    int dof = 0;
    double* jacobian = nullptr;  // dof×dof, of the active components
  };

  void allocate();
  void list_ports(const ProcessPlan& process, int index);
  void list_scalings(const ProcessPlan& process);
  void list_gathers();

  // The state, and what models see
  double* x() { return plan_.state.in(arena_); }
  MemoryView memory_of(const Place<std::byte>& place) const { return place.count > 0 ? place.in(arena_) : nullptr; }
  double* at(std::size_t offset) { return workspace_.data() + offset; }
  const double* const* values_of(const std::vector<int>& ports);
  Driving driving(const Driving& now, const std::vector<int>& driving_rates);
  const SampleView* auxiliary(const AuxiliaryPlan& model);
  template <class Component>
  const MatrixView* zeroed_jacobians(const Component& component, int rows);
  Result evaluate_derived(const std::vector<int>& values, const Driving& now, Jacobians wanted);
  void chain(const DerivedPlan& derived);

  void note_stationary_variances();
  /// Of a component by itself; infinite where it has none.
  double stationary_variance(int row) const;
  void start_value(const BlockPlan& block, const InitialPlan& initial, double* stored);
  void start_covariance(const BlockPlan& block, bool anew, MatrixView P);
  std::string component_name(int row) const;
  [[noreturn]] void stop_unsound(Time t, const std::string& culprit) const;

  void run_process(std::size_t index, const Step& step, std::span<const InputSample> samples, bool is_kept);
  void scale_blocks();
  void read_input(std::size_t index, std::span<const InputSample> samples, Step& step);
  Result run_model(std::size_t index, const Step& step, std::span<const InputSample> samples, Jacobians wanted);
  void run_continuous(std::size_t index);
  void check_noise(Time t) const;
  void discretize_group(const VanLoanGroup& group, double dt);
  void advance_group(const VanLoanGroup& group);
  void gather();
  double gathered(const GatherPlan::Term& term, const double* block, int row, int column, int dof);
  void hold_frozen(const double* x);
  std::string culprit(Time t1) const;

  // Sigma points through the models. sigma_propagation.cpp

  /// All of one step. Sized once.
  struct SigmaStep {
    SigmaStep(const FilterPlan& plan, const std::vector<Place<std::byte>>& memories);
    MatrixView errors() { return {e.data(), n, points.count(), n}; }
    ConstMatrixView jacobian() const { return {Phi.data(), n, n, n}; }
    void copy_memories(std::byte* arena, std::vector<std::byte>& to) const;
    void put_memories(const std::vector<std::byte>& from, std::byte* arena) const;

    int n;
    SigmaPoints points;
    std::vector<Place<std::byte>> memories;      // of the process models
    std::vector<std::byte> before, after;        // what they held before the step, and after the centre's call
    std::vector<double> x, xi, back;             // of a point; ξ; of one block
    std::vector<double> next, e, deltas, moved;  // x⁺ of each point, by columns; e; of one block by columns, their mean
    std::vector<double> Phi, Omega;              // Φ of the models; Ω
  };
  void regress_step(const Driving& now, const Step& step, std::span<const InputSample> samples, bool is_nominal);
  bool run_points(const Driving& now, const Step& step, std::span<const InputSample> samples);
  bool advance_point(int point, const Driving& now, const Step& step, std::span<const InputSample> samples);
  bool perturb(int point);
  bool run_values(const Driving& now, const Step& step, std::span<const InputSample> samples);
  void average(const BlockPlan& block);

  Result run_parts(SampleRows& rows, const MeasurementPlan& measurement, const SampleView& sample, const Driving& now,
                   Jacobians wanted);
  Result run_part(SampleRows& rows, const PartPlan& part, const SampleView& sample, const ChannelPlan& channel,
                  const Driving& now, Jacobians wanted, int& part_rows);
  void assemble(SampleRows& rows, const PartPlan& part, int part_rows);

  VectorView delta_elsewhere(const UpdatePlan::Seen& seen);
  Result see_elsewhere(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now,
                       Jacobians wanted);
  void reset_elsewhere(const MeasurementPlan& measurement);
  Result regress(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now);
  bool see_sigma_points(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now);
  Convergence find_minimum(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now);
  void begin_iteration();
  void solve_step(const MeasurementPlan& measurement);
  double square_of_step(const MeasurementPlan& measurement);
  bool try_step(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now, double share,
                double promised, bool is_last, double& cost);
  bool keep_rows(const MeasurementPlan& measurement);
  bool linearize_tried(const MeasurementPlan& measurement);
  PortCovariance covariance_of(const PartPlan& part);
  void add_covariance(const PartPlan::Read& a, const PartPlan::Target& by_a, const PartPlan::Read& b,
                      const PartPlan::Target& by_b, ConstMatrixView P, MatrixView into);

  void weigh(const MeasurementPlan& measurement, Time t, double dt);
  void inject();
  void note_rounded();
  void keep_reset(const BlockPlan& block, MatrixView G);
  double* kept_G(const BlockPlan& block) { return reset_jacobians_.data() + block.first * plan_.n; }

  const FilterPlan& plan_;
  const std::vector<ChannelPlan>& channels_;
  std::byte* arena_;
  ModelCalls& calls_;
  std::unique_ptr<CovarianceForm> P_;
  SampleRows rows_;
  OutlierTest outlier_test_;
  Opening opening_;
  // Null where no measurement of the filter needs them.
  std::unique_ptr<OtherStates> other_;
  std::unique_ptr<Iteration> iteration_;
  std::unique_ptr<SeenSigmaPoints> sigma_points_;
  bool was_linearized_instead_ = false;

  // Scratch
  std::vector<double> workspace_;  // as the plan lays it out: blocks of Φ and Qd, derived values, Jacobians
  std::vector<double*> phi_, noise_;
  std::vector<const double*> values_;  // where a state block's or a derived value lies
  std::vector<double> x_plus_;  // of the newest step: what a model leaves unwritten is its own of the step before
  std::vector<double> x_corrected_;
  std::vector<Ports> ports_;  // per process
  std::vector<Diagonal> diagonals_;
  std::vector<const double*> noise_variances_;  // their elements that have a place in P
  std::vector<Scaling> scalings_;
  Gathered gathered_;
  std::vector<const BlockPlan*> held_;                         // blocks that hold what is frozen
  std::vector<double> group_x_;                                // what a Van Loan group reads
  double kept_dt_ = std::numeric_limits<double>::quiet_NaN();  // length of the step that all in the tables is of [s]
  std::vector<const double*> port_values_;                     // of the component being called, as all that follows
  std::vector<MatrixView> jacobians_;
  std::vector<double> driving_rates_, fields_, auxiliary_fields_, port_covariance_;
  std::vector<int> first_row_;  // by port, of port_covariance_
  std::vector<SampleView> auxiliary_samples_;
  std::vector<InputSample> samples_;
  std::vector<double> block_delta_, block_jacobian_, outputs_;  // of one block
  std::vector<double> initial_P_, reset_jacobians_;
  std::vector<Reset> resets_;
  std::vector<std::byte> memory_backup_, noise_backup_;  // of a measurement's models and noise estimator
  std::unique_ptr<SigmaStep> sigma_;                     // null: propagation by Jacobians
};

}  // namespace binnacle::internal::filter
