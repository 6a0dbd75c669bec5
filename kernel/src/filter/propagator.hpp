// SPDX-License-Identifier: Apache-2.0
// One propagation but for P: process models, joint discretization, gathering of what is frozen or derived.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "filter/covariance_form.hpp"
#include "filter/fields.hpp"
#include "filter/model_calls.hpp"
#include "filter/workspace.hpp"

namespace binnacle::filter {

class Propagator {
 public:
  Propagator(const FilterPlan& plan, const CovarianceForm& P, AuxiliaryReader& auxiliary, Workspace& workspace,
             ModelCalls& calls);

  /// From the a-posteriori x at `now` to t1: x_plus(), and the blocks of Φ and Qd in the workspace. Throws Stop where a model
  /// refuses or writes what cannot be noise.
  void run(const Moment& now, Time t1, std::span<const InputSample> samples, const double* x);
  const double* x_plus() const { return x_plus_.data(); }
  /// After a step whose result is not finite: "…: propagate at 3 s gave Phi(a, b), which is not finite", or
  /// "" where no process is to blame.
  std::string culprit(Time t1) const;

 private:
  /// The diagonal of a block of Qd or GQGᵀ that a process writes.
  struct Diagonal {
    int process = 0;
    int block = 0;  // state block
    int dof = 0;
    int step = 0;  // doubles from one element to the next
    const double* q = nullptr;
  };
  /// Per port: the value, null where it is open; where x⁺ is written, null for ports that are only read.
  struct Ports {
    std::vector<const double*> inputs;
    std::vector<double*> outputs;
  };

  void run_models(const Moment& now, Time t1, std::span<const InputSample> samples);
  Step read_input(const ProcessPlan& process, Step step, std::span<const InputSample> samples);
  void linearize(std::size_t index);
  void check_noise(Time t) const;
  void judge_noise(const Diagonal& diagonal, Time t) const;
  void discretize_group(const VanLoanGroup& group, double dt);
  void advance_group(const VanLoanGroup& group, const double* Phi);
  void gather(const std::vector<GatherPlan>& plans, const std::vector<double*>& table);
  double gathered(const GatherPlan::Term& term, const double* block, int row, int column, int dof);
  void hold_frozen(const double* x);

  const FilterPlan& plan_;
  const CovarianceForm& P_;  // to judge what rounding is
  AuxiliaryReader& auxiliary_;
  Workspace& workspace_;
  ModelCalls& calls_;
  std::vector<double> x_plus_;
  std::vector<double> delta_;         // of one block
  std::vector<InputSample> samples_;  // as a model sees them
  std::vector<double> fields_;        // theirs, converted
  std::vector<Ports> ports_;          // per process
  std::vector<Diagonal> diagonals_;
  std::vector<const BlockPlan*> held_;  // with frozen components that do not move
};

}  // namespace binnacle::filter
