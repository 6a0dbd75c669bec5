// SPDX-License-Identifier: Apache-2.0
// A bound component that can be called: the same calls for every role, on made-up but plausible input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/parts.hpp"
#include "binnacle/testing.hpp"
#include "check.hpp"
#include "miniature.hpp"
#include "sample_numbers.hpp"

namespace binnacle::conform {

using testing::PortState;
using testing::PortStates;
using testing::unwritten;

/// What a call gave: a verdict, and every number it wrote. Of its memory counts what later calls make of it: its bytes may
/// have padding, whose value nobody promises.
struct Answer {
  Result result;
  std::vector<double> numbers;
  std::string damage;  // what was written that should not be, or not written that should; "" when nothing

  bool is_finite() const;
  /// To the bit.
  bool operator==(const Answer& other) const;
};

class Fixture {
 public:
  virtual ~Fixture() = default;
  virtual std::size_t memory_bytes() const = 0;
  virtual void start(std::byte* memory) const = 0;
  /// What it reads comes once: a source of live samples.
  virtual bool is_live() const { return false; }
  /// The k-th call. Output memory holds `fill` before it, canaries around it.
  virtual Answer turn(std::uint64_t k, std::byte* memory, double fill) const = 0;
  /// Inputs that nobody hopes for: finite ones, then those with NaN and infinity.
  virtual std::vector<std::string> hostile_finite() const { return {}; }
  virtual std::vector<std::string> hostile_nonfinite() const { return {}; }
  virtual Answer hostile(const std::string& /*input*/, std::byte* /*memory*/) const { return {}; }

  std::vector<std::byte> fresh_memory() const;
};

/// Of the trial's component in a composition made by miniature(); keeps the composition.
std::unique_ptr<Fixture> fixture(Trial& trial, std::shared_ptr<const Composition> composition);
std::unique_ptr<Fixture> fixture_of_example(Trial& trial);

/// By role; the composition is that of fixture().
std::unique_ptr<Fixture> block_fixture(Trial& trial, std::shared_ptr<const Composition> composition);
std::unique_ptr<Fixture> model_fixture(Trial& trial, std::shared_ptr<const Composition> composition);
std::unique_ptr<Fixture> stream_fixture(Trial& trial, std::shared_ptr<const Composition> composition);

// ---- hostile input

std::vector<std::string> finite_hostilities();
std::vector<std::string> nonfinite_hostilities();
/// What stands in place of the i-th of a component's input numbers.
double hostile_number(const std::string& name, std::size_t i, double ordinary);

// ---- what the checks of numbers build on

/// A block of the same kind as `kind` that is a state block, made of its own example. Throws Skip where there is none.
std::shared_ptr<const StateBlock> block_of_kind(Trial& trial, const std::string& kind);

/// Ports of a part, each value a random step (of `spread` scales) from where the config starts it. The blocks are the
/// part's, and must outlive the states.
PortStates port_states(const std::vector<parts::Value>& ports, std::mt19937_64& random, double spread);

double normal(std::mt19937_64& random);
Eigen::VectorXd normals(std::mt19937_64& random, Eigen::Index count);
/// Of a covariance, which may be singular.
Eigen::VectorXd draw(const Eigen::MatrixXd& covariance, std::mt19937_64& random);

/// The samples of the auxiliary channels: what the surroundings specify, and where they specify nothing what is plausible.
/// settings: those of the component, with the inputs that are connected.
class AuxiliaryNumbers {
 public:
  AuxiliaryNumbers(Trial& trial, const ComponentSpec& spec, const Json& settings);
  /// See number_rows() of samples.
  void number_rows(const ComponentSpec& spec);
  AuxiliaryNumbers(const AuxiliaryNumbers&) = delete;
  const std::vector<SampleView>& views() const { return views_; }

 private:
  std::vector<SampleNumbers> numbers_;  // per input of the spec
  std::vector<SampleView> views_;
};

/// One step of a process model, with one sample where it takes input.
class DrivenStep {
 public:
  DrivenStep(double dt, std::vector<double> fields, bool takes_input, Time t0 = 1'000'000'000);
  DrivenStep(const DrivenStep& other)
      : DrivenStep(other.step_.dt, other.fields_, !other.step_.samples.empty(), other.step_.t0) {}
  DrivenStep& operator=(const DrivenStep&) = delete;
  const Step& step() const { return step_; }
  const std::vector<double>& fields() const { return fields_; }

 private:
  std::vector<double> fields_;
  InputSample sample_;
  Step step_;
};

class ProcessFixture {
 public:
  ProcessFixture(Trial& trial, const Composition& composition);
  PortStates ports(std::mt19937_64& random, double spread) const { return port_states(part.ports, random, spread); }
  /// Mean rates (or increments over dt) that a vehicle might feel.
  DrivenStep step(std::mt19937_64& random, double dt) const;
  /// The halves that make up the step; the second begins where the first ends.
  DrivenStep first_half(const DrivenStep& whole) const;
  DrivenStep second_half(const DrivenStep& whole) const;
  /// By its closed form, or where it has none its continuous form.
  testing::Propagated call(const PortStates& ports, const DrivenStep& step, const std::vector<std::byte>& memory,
                           double fill = unwritten()) const;
  bool is_closed() const { return part.model->declaration().has_closed_form; }

  parts::Part<ProcessModel> part;

 private:
  DrivenStep half(const DrivenStep& whole, Time t0) const;

  AuxiliaryNumbers auxiliary_;

 public:
  testing::ProcessCaller caller;
};

class MeasurementFixture {
 public:
  MeasurementFixture(Trial& trial, const Composition& composition);
  testing::Measured call(const PortStates& ports, const SampleNumbers& sample, const std::vector<std::byte>& memory,
                         double fill = unwritten()) const;
  /// The sample and what else the model is given, as the kernel hands it out. Valid as long as `sample`.
  testing::Given given(const SampleNumbers& sample) const;
  PortStates ports(std::mt19937_64& random, double spread) const { return port_states(part.ports, random, spread); }
  /// A sample near what the state at `ports` would show: residual ≈ `wanted` (zero where that is empty).
  SampleNumbers sample(const PortStates& ports, std::mt19937_64& random, const Eigen::VectorXd& wanted = {}) const;

  parts::Part<MeasurementModel> part;
  testing::MeasurementCaller caller;
  std::vector<bool> has_field;  // per field of the spec, whether the miniature's channel carries it

 private:
  Eigen::VectorXd residual(const PortStates& ports, const SampleNumbers& sample) const;
  SampleNumbers first_guess(const PortStates& ports, std::mt19937_64& random) const;
  SampleNumbers first_sample(const PortStates& ports, std::mt19937_64& random) const;

  Surroundings around_;
  AuxiliaryNumbers auxiliary_;
  bool numbers_rows_ = false;  // of samples and auxiliary samples: else it takes none
  std::vector<double> driving_rates_;
  std::vector<double> covariance_;  // of its samples, where the miniature's channel attaches one
};

class DerivedFixture {
 public:
  DerivedFixture(Trial& trial, const Composition& composition);
  PortStates ports(std::mt19937_64& random, double spread) const { return port_states(part.ports, random, spread); }
  Driving u() const { return {2'000'000'000, driving_rates_.empty() ? nullptr : driving_rates_.data()}; }

  parts::Part<DerivedBlock> part;
  testing::DerivedCaller caller;
  std::shared_ptr<const StateBlock> yields;

 private:
  std::vector<double> driving_rates_;
};

/// Counts what is allocated inside the calls of a fixture, and how long they take.
struct CallMeter {
  std::uint64_t allocations = 0;
  std::vector<double> seconds;
};
/// Null: calls are not metered.
void meter_calls(CallMeter* meter);

/// Reports to the trial what is being called, and the meter how long it took; for the life of this object.
class CallWatch {
 public:
  explicit CallWatch(Trial& trial);
  ~CallWatch();
  CallWatch(const CallWatch&) = delete;

 private:
  class Observer;
  std::unique_ptr<Observer> observer_;
};

}  // namespace binnacle::conform
