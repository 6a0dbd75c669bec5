// SPDX-License-Identifier: Apache-2.0
#include "fixture.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "algebra/decompositions.hpp"
#include "allocations.hpp"
#include "guarded.hpp"

namespace binnacle::conform {

namespace {

CallMeter* current_meter = nullptr;

constexpr std::array finite_names = {"zero", "tiny 1e-300", "huge 1e300", "huge -1e300", "alternating 1e15"};
constexpr std::array nonfinite_names = {"NaN", "infinity", "-infinity", "one NaN"};

}  // namespace

// ---- calls

void meter_calls(CallMeter* meter) { current_meter = meter; }

class CallWatch::Observer final : public testing::CallObserver {
 public:
  explicit Observer(Trial& trial) : trial_(trial) {}
  void before(const char* call) override {
    trial_.stage(call);
    if (!current_meter) return;
    allocations_ = allocations();
    start_ = std::chrono::steady_clock::now();
  }
  void after() override {
    if (current_meter) {
      const auto end = std::chrono::steady_clock::now();
      current_meter->allocations += allocations() - allocations_;
      current_meter->seconds.push_back(std::chrono::duration<double>(end - start_).count());
    }
    trial_.stage("");
  }

 private:
  Trial& trial_;
  std::uint64_t allocations_ = 0;
  std::chrono::steady_clock::time_point start_;
};

CallWatch::CallWatch(Trial& trial) : observer_(std::make_unique<Observer>(trial)) {
  testing::observe_calls(observer_.get());
}
CallWatch::~CallWatch() { testing::observe_calls(nullptr); }

// ---- answers

bool Answer::is_finite() const {
  return std::all_of(numbers.begin(), numbers.end(), [](double v) { return std::isfinite(v); });
}
bool Answer::operator==(const Answer& other) const {
  return result.refusal == other.result.refusal && numbers.size() == other.numbers.size() &&
         std::equal(numbers.begin(), numbers.end(), other.numbers.begin(), testing::same_bits);
}

std::vector<std::byte> Fixture::fresh_memory() const {
  std::vector<std::byte> memory(memory_bytes());
  start(memory.data());
  return memory;
}

// ---- numbers

std::vector<std::string> finite_hostilities() { return {finite_names.begin(), finite_names.end()}; }
std::vector<std::string> nonfinite_hostilities() { return {nonfinite_names.begin(), nonfinite_names.end()}; }

double hostile_number(const std::string& name, std::size_t i, double ordinary) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();
  if (name == "zero") return 0;
  if (name == "tiny 1e-300") return 1e-300;
  if (name == "huge 1e300") return 1e300;
  if (name == "huge -1e300") return -1e300;
  if (name == "alternating 1e15") return i % 2 ? -1e15 : 1e15;
  if (name == "NaN") return quiet_nan;
  if (name == "infinity") return infinity;
  if (name == "-infinity") return -infinity;
  if (name == "one NaN") return i == 0 ? quiet_nan : ordinary;
  return ordinary;
}

double normal(std::mt19937_64& random) {
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  const double radius = std::sqrt(-2 * std::log(uniform()));
  return radius * std::cos(2 * std::numbers::pi * uniform());
}
Eigen::VectorXd normals(std::mt19937_64& random, Eigen::Index count) {
  Eigen::VectorXd values(count);
  for (auto& value : values) value = normal(random);
  return values;
}
Eigen::VectorXd draw(const Eigen::MatrixXd& covariance, std::mt19937_64& random) {
  const algebra::Spectrum spectrum = algebra::spectrum(covariance);
  return spectrum.vectors * spectrum.values.cwiseMax(0).cwiseSqrt().cwiseProduct(normals(random, covariance.rows()));
}

// ---- ports

std::shared_ptr<const StateBlock> block_of_kind(Trial& trial, const std::string& kind) {
  // A process of its own composes whatever it likes. All types there are: a composition has those that it needs.
  const Catalog catalog = load_catalog(trial);
  Json block;
  if (kind.rfind("vector:", 0) == 0) {
    const auto colon = kind.find(':', 7);
    block = {{"type", "core/vector"},
             {"size", std::stoi(kind.substr(7))},
             {"unit", kind.substr(colon + 1)},
             {"sigma", 1}};
  } else {
    for (const auto* type : catalog.types())
      if (type->role == Role::state_block && type->spec.kind == kind) {
        block = {{"type", type->full_name()}};
        block.update(example_of(type->spec));
        break;
      }
  }
  if (block.is_null()) Trial::skip("no block of the kind '" + kind + "' is to be found");
  const Json config = {
      {"binnacle", 1},
      {"plugins", Json::array({trial.library.string()})},
      {"filters",
       {{filter_name,
         {{"blocks", {{"value", block}}},
          {"process", {{"hold", {{"type", "core/random_constant"}, {"blocks", {{"x", "value"}}}}}}}}}}}};
  return parts::block(*compose(trial, config), filter_name, "value").block;
}

PortStates port_states(const std::vector<parts::Value>& ports, std::mt19937_64& random, double spread) {
  PortStates states;
  for (const auto& value : ports) {
    PortState state;
    if (value.block) {
      state.block = value.block.get();
      const auto& declared = value.block->declaration();
      state.x = value.initial;
      state.x.resize(static_cast<std::size_t>(declared.stored_size), 0.0);
      state.scale.resize(declared.dof());
      for (int i = 0; i < declared.dof(); ++i)
        state.scale[i] = scale_of(declared.error[static_cast<std::size_t>(i)].unit);
      const Eigen::VectorXd delta = spread * state.scale.cwiseProduct(normals(random, declared.dof()));
      state.block->plus(state.x, delta, state.x);
    }
    states.push_back(std::move(state));
  }
  return states;
}

// ---- by role

std::unique_ptr<Fixture> fixture(Trial& trial, std::shared_ptr<const Composition> composition) {
  switch (trial.role) {
    case Role::state_block: return block_fixture(trial, std::move(composition));
    case Role::process_model:
    case Role::measurement_model:
    case Role::derived_block: return model_fixture(trial, std::move(composition));
    case Role::noise_estimator:
    case Role::source:
    case Role::transform: return stream_fixture(trial, std::move(composition));
    case Role::sink: break;
  }
  Trial::not_applicable("a sink has nothing to call without a file of its own");
}

std::unique_ptr<Fixture> fixture_of_example(Trial& trial) { return fixture(trial, compose_example(trial)); }

}  // namespace binnacle::conform
