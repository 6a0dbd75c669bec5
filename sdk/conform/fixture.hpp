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
#include "check.hpp"
#include "miniature.hpp"

namespace binnacle::conform {

/// What a call gave: a verdict, and every number and byte of memory it wrote.
struct Answer {
  Result result;
  std::vector<double> numbers;
  std::vector<std::byte> memory;
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

// ---- what the checks of numbers build on

/// A port with the block behind it, or for derived values a block of the same kind.
struct PortState {
  std::string name;
  std::shared_ptr<const StateBlock> block;  // null: open
  std::vector<double> x;                    // stored value
  Eigen::VectorXd scale;                    // a plausible error per component
  bool is_open() const { return block == nullptr; }
  int dof() const { return block ? block->declaration().dof() : 0; }
};

using PortStates = std::vector<PortState>;

/// A block of the same kind as `kind` that is a state block, made of its own example. Throws Skip where there is none.
std::shared_ptr<const StateBlock> block_of_kind(Trial& trial, const Composition& composition, const std::string& kind);

/// Ports of a part, each value a random step (of `spread` scales) from where the config starts it.
PortStates port_states(const std::vector<parts::Value>& ports, std::mt19937_64& random, double spread);
std::vector<const double*> pointers(const PortStates& ports);

/// A plausible size of an error with this unit.
double scale_of(const std::string& unit);
double normal(std::mt19937_64& random);
Eigen::VectorXd normals(std::mt19937_64& random, Eigen::Index count);

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

/// A NaN that no arithmetic makes.
double unwritten();

/// One call of a process model.
struct Propagated {
  Answer answer;
  std::vector<std::vector<double>> x_plus;  // per port; empty for those only read
  std::vector<Eigen::MatrixXd> transition;  // per declared coupling, dense
  std::vector<Eigen::MatrixXd> noise;
};

struct ProcessInput {
  double dt = 0.01;
  std::vector<double> fields;
};

class ProcessFixture {
 public:
  ProcessFixture(Trial& trial, const Composition& composition);
  Propagated call(const PortStates& ports, const ProcessInput& input, std::byte* memory, double fill) const;
  PortStates ports(std::mt19937_64& random, double spread) const;
  /// Mean rates (or increments over dt) that a vehicle might feel.
  ProcessInput input(std::mt19937_64& random, double dt) const;
  bool advances(std::size_t port) const { return part.type->spec.ports[port].access == PortAccess::advances; }

  parts::Part<ProcessModel> part;

 private:
  Trial& trial_;
};

struct Measured {
  Answer answer;
  Eigen::VectorXd residual;
  std::vector<Eigen::MatrixXd> H;  // per entry of reads
  Eigen::MatrixXd R;
};

class MeasurementFixture {
 public:
  MeasurementFixture(Trial& trial, const Composition& composition);
  Measured call(const PortStates& ports, const std::vector<double>& fields, std::byte* memory, double fill,
                int rows = -1) const;
  PortStates ports(std::mt19937_64& random, double spread) const;
  /// Fields near what the state at `ports` would show: residual ≈ `wanted` (zero where that is empty).
  std::vector<double> fields(const PortStates& ports, std::mt19937_64& random,
                             const Eigen::VectorXd& wanted = {}) const;

  parts::Part<MeasurementModel> part;
  std::vector<bool> has_field;  // per field of the spec, whether the miniature's channel carries it

 private:
  Eigen::VectorXd residual(const PortStates& ports, const std::vector<double>& fields) const;

  Trial& trial_;
  std::vector<double> driving_rates_;
};

class DerivedFixture {
 public:
  DerivedFixture(Trial& trial, const Composition& composition);
  struct Evaluated {
    Answer answer;
    std::vector<double> value;
    std::vector<Eigen::MatrixXd> J;
  };
  Evaluated call(const PortStates& ports, double fill, bool with_jacobian = true) const;
  PortStates ports(std::mt19937_64& random, double spread) const;

  parts::Part<DerivedBlock> part;
  std::shared_ptr<const StateBlock> yields;

 private:
  Trial& trial_;
  std::vector<double> driving_rates_;
};

/// Counts what is allocated inside the calls of a fixture, and how long they take.
struct CallMeter {
  std::uint64_t allocations = 0;
  std::vector<double> seconds;
};
/// Null: calls are not metered.
void meter_calls(CallMeter* meter);

}  // namespace binnacle::conform
