// SPDX-License-Identifier: Apache-2.0
// Models that are bound, and plausible input for them.
#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "algebra/decompositions.hpp"
#include "fixture.hpp"

namespace binnacle::conform {

namespace {

std::vector<double> driving_rates_of(const ComponentSpec& spec, std::mt19937_64& random) {
  std::vector<double> rates;
  for (const auto& field : spec.driving_rates) rates.push_back(scale_of(field.unit) * normal(random));
  return rates;
}

/// section: "process" or "measurements".
Json settings_in(const Composition& composition, const char* section) {
  return Json::parse(composition.config()).at("filters").at(filter_name).at(section).at(component_name);
}

/// A plausible covariance of the channel's samples, diagonal; empty where it attaches none.
std::vector<double> covariance_carried(const Composition& composition, const Json& settings) {
  std::vector<double> covariance;
  for (const auto& info : composition.channels()) {
    if (info.name != settings.at("channel").get<std::string>()) continue;
    const auto& components = info.declaration->covariance;
    covariance.assign(components.size() * components.size(), 0.0);
    for (std::size_t i = 0; i < components.size(); ++i) {
      const double sigma = 0.1 * scale_of(components[i].unit);
      covariance[i * (components.size() + 1)] = sigma * sigma;
    }
  }
  return covariance;
}

/// Per field of the spec, whether the channel in the miniature carries it, under its own name or another.
std::vector<bool> fields_carried(const Composition& composition, const ComponentSpec& spec, const Json& settings) {
  const std::string channel = settings.at("channel");
  std::vector<bool> carried;
  for (const auto& field : spec.fields) {
    std::string name = field.name;
    if (settings.contains("fields") && settings.at("fields").contains(name)) name = settings.at("fields").at(name);
    bool found = false;
    for (const auto& info : composition.channels())
      if (info.name == channel)
        for (const auto& had : info.declaration->fields) found |= had.name == name;
    carried.push_back(found);
  }
  return carried;
}

}  // namespace

AuxiliaryNumbers::AuxiliaryNumbers(Trial& trial, const ComponentSpec& spec, const Json& settings) {
  const Surroundings around(spec);
  auto random = trial.random(79);
  for (const auto& input : spec.inputs) {
    const Json given = around.input(input.name);
    // The miniature's channel leaves out optional fields; their numbers are NaN then, as the kernel hands them out.
    const bool all_optional =
        std::all_of(input.fields.begin(), input.fields.end(), [](const auto& field) { return field.is_optional; });
    std::vector<bool> has;
    for (const auto& field : input.fields)
      has.push_back(!field.is_optional || all_optional || given.contains(field.name));
    SampleNumbers numbers = made_up(input.fields, has, given, around.time() - 500'000'000, random);
    numbers.is_available = settings.contains("inputs") && settings.at("inputs").contains(input.name);
    numbers_.push_back(std::move(numbers));
  }
  for (const auto& numbers : numbers_) views_.push_back(numbers.view());
}

void AuxiliaryNumbers::number_rows(const ComponentSpec& spec) {
  const Surroundings around(spec);
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    conform::number_rows(numbers_[i], spec.inputs[i].fields, around.input(spec.inputs[i].name));
    views_[i] = numbers_[i].view();
  }
}

// ---- process models

DrivenStep::DrivenStep(double dt, std::vector<double> fields, bool takes_input, Time t0) : fields_(std::move(fields)) {
  const Time t1 = t0 + static_cast<Time>(std::llround(std::clamp(dt, -1e9, 1e9) * 1e9));
  sample_ = {t0, t1, dt, t0, t1, fields_.data()};
  step_ = {t0, t1, dt, takes_input ? std::span(&sample_, 1) : std::span<const InputSample>()};
}

ProcessFixture::ProcessFixture(Trial& trial, const Composition& composition)
    : part(parts::process(composition, filter_name, component_name)),
      auxiliary_(trial, part.type->spec, settings_in(composition, "process")),
      caller(*part.model, part.type->spec, auxiliary_.views()) {}

DrivenStep ProcessFixture::step(std::mt19937_64& random, double dt) const {
  std::vector<double> fields;
  for (const auto& field : part.type->spec.fields) {
    const std::string& unit = field.unit;
    const double per_second = unit == "rad" ? 0.2 : unit == "m/s" ? 5 : scale_of(unit);
    fields.push_back(normal(random) * (field.kind == FieldKind::increment ? per_second * dt : per_second));
  }
  return {dt, fields, !part.type->spec.fields.empty()};
}

DrivenStep ProcessFixture::half(const DrivenStep& whole, Time t0) const {
  std::vector<double> fields = whole.fields();
  const auto& specs = part.type->spec.fields;
  for (std::size_t i = 0; i < specs.size(); ++i)
    if (specs[i].kind == FieldKind::increment) fields[i] /= 2;
  return {whole.step().dt / 2, fields, !specs.empty(), t0};
}

DrivenStep ProcessFixture::first_half(const DrivenStep& whole) const { return half(whole, whole.step().t0); }

DrivenStep ProcessFixture::second_half(const DrivenStep& whole) const {
  return half(whole, first_half(whole).step().t1);
}

testing::Propagated ProcessFixture::call(const PortStates& ports, const DrivenStep& step,
                                         const std::vector<std::byte>& memory, double fill) const {
  if (is_closed()) return caller.propagate(ports, step.step(), memory, fill);
  testing::Propagated p = caller.linearized(ports, fill);
  p.memory = memory;
  return p;
}

// ---- measurement models

MeasurementFixture::MeasurementFixture(Trial& trial, const Composition& composition)
    : part(parts::measurement(composition, filter_name, component_name)),
      caller(*part.model, part.type->spec),
      around_(part.type->spec),
      auxiliary_(trial, part.type->spec, settings_in(composition, "measurements")) {
  auto random = trial.random(77);
  driving_rates_ = driving_rates_of(part.type->spec, random);
  has_field = fields_carried(composition, part.type->spec, settings_in(composition, "measurements"));
  covariance_ = covariance_carried(composition, settings_in(composition, "measurements"));
  const PortStates states = ports(random, 0.1);
  if (!part.type->spec.inputs.empty() && residual(states, first_sample(states, random)).size() == 0) {
    numbers_rows_ = true;
    auxiliary_.number_rows(part.type->spec);
  }
}

testing::Given MeasurementFixture::given(const SampleNumbers& sample) const {
  return {sample.view(), auxiliary_.views(), {sample.t, driving_rates_.empty() ? nullptr : driving_rates_.data()}};
}

testing::Measured MeasurementFixture::call(const PortStates& ports, const SampleNumbers& sample,
                                           const std::vector<std::byte>& memory, double fill) const {
  return caller.linearize(given(sample), ports, memory, fill);
}

Eigen::VectorXd MeasurementFixture::residual(const PortStates& ports, const SampleNumbers& sample) const {
  const testing::Measured measured = call(ports, sample, caller.fresh_memory(), 0.0);
  return measured.result ? measured.residual : Eigen::VectorXd();
}

/// What the surroundings specify; a field that is named as an output of a block is that output.
SampleNumbers MeasurementFixture::first_guess(const PortStates& ports, std::mt19937_64& random) const {
  const auto& specs = part.type->spec.fields;
  Json given = around_.sample();
  for (std::size_t i = 0; i < specs.size(); ++i)
    for (const auto& port : ports) {
      if (port.is_open() || !has_field[i] || given.contains(specs[i].name)) continue;
      const auto& outputs = port.block->declaration().outputs;
      std::vector<double> read(outputs.size());
      port.block->read(port.x, read);
      for (std::size_t o = 0; o < outputs.size(); ++o)
        if (outputs[o].name == specs[i].name) given[specs[i].name] = read[o];
    }
  SampleNumbers guess = made_up(specs, has_field, given, around_.time(), random);
  if (numbers_rows_) number_rows(guess, specs, given);
  guess.covariance = covariance_;
  return guess;
}

/// A guess that the model takes, if one is found: a range that is negative is none.
SampleNumbers MeasurementFixture::first_sample(const PortStates& ports, std::mt19937_64& random) const {
  SampleNumbers z = first_guess(ports, random);
  for (int attempt = 0; attempt < 8 && residual(ports, z).size() == 0; ++attempt) z = first_guess(ports, random);
  return z;
}

SampleNumbers MeasurementFixture::sample(const PortStates& ports, std::mt19937_64& random,
                                         const Eigen::VectorXd& wanted) const {
  SampleNumbers z = first_sample(ports, random);
  if (z.count() == 0) return z;  // a model that is given nothing but the time
  // Gauss and Newton over the fields: r(z) = wanted.
  for (int iteration = 0; iteration < 12; ++iteration) {
    const Eigen::VectorXd r = residual(ports, z);
    if (r.size() == 0 || !r.allFinite()) return z;
    Eigen::VectorXd error = r;
    if (wanted.size() == r.size()) error -= wanted;
    if (error.norm() < 1e-12) return z;
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(r.size(), static_cast<Eigen::Index>(z.count()));
    for (std::size_t i = 0; i < z.count(); ++i) {
      if (std::isnan(z.at(i))) continue;
      const double h = 1e-6 * std::max(1.0, std::abs(z.at(i)));
      SampleNumbers up = z, down = z;
      up.at(i) += h, down.at(i) -= h;
      const Eigen::VectorXd r_up = residual(ports, up), r_down = residual(ports, down);
      if (r_up.size() == r.size() && r_down.size() == r.size())
        J.col(static_cast<Eigen::Index>(i)) = (r_up - r_down) / (2 * h);
    }
    if (!J.allFinite()) return z;
    const Eigen::VectorXd step = algebra::LeastSquares(J).solve_vector(error);
    for (std::size_t i = 0; i < z.count(); ++i)
      if (!std::isnan(z.at(i))) z.at(i) -= step[static_cast<Eigen::Index>(i)];
  }
  return z;
}

// ---- derived blocks

DerivedFixture::DerivedFixture(Trial& trial, const Composition& composition)
    : part(parts::derived(composition, filter_name, component_name)), caller(*part.model, part.type->spec) {
  auto random = trial.random(78);
  driving_rates_ = driving_rates_of(part.type->spec, random);
  yields = block_of_kind(trial, part.model->declaration().kind);
}

// ---- the same calls for every role

namespace {

std::vector<std::byte> copied(const std::byte* memory, std::size_t bytes) { return {memory, memory + bytes}; }

/// What a call of a model gave, its memory written back.
template <class Called>
Answer answer_of(const Called& called, std::byte* memory) {
  std::copy(called.memory.begin(), called.memory.end(), memory);
  return {called.result, called.numbers, called.damage};
}

class CallsProcess final : public Fixture {
 public:
  CallsProcess(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial), composition_(std::move(composition)), process_(trial, *composition_) {}
  std::size_t memory_bytes() const override { return process_.part.model->declaration().memory_bytes; }
  void start(std::byte* memory) const override { process_.part.model->start(memory); }
  Answer turn(std::uint64_t k, std::byte* memory, double fill) const override {
    auto random = trial_.random(2000 + k);
    const PortStates ports = process_.ports(random, 0.3);
    return call(ports, process_.step(random, k % 3 == 2 ? 0.02 : 0.01), memory, fill);
  }
  std::vector<std::string> hostile_finite() const override {
    std::vector<std::string> all = {"dt 0", "dt 1e-9", "dt 1e6", "dt -0.01"};
    const auto more = finite_hostilities();
    if (!process_.part.type->spec.fields.empty()) all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::vector<std::string> hostile_nonfinite() const override {
    return process_.part.type->spec.fields.empty() ? std::vector<std::string>() : nonfinite_hostilities();
  }
  Answer hostile(const std::string& input, std::byte* memory) const override {
    auto random = trial_.random(2);
    const PortStates ports = process_.ports(random, 0.3);
    const double dt = input.rfind("dt ", 0) == 0 ? std::stod(input.substr(3)) : 0.01;
    std::vector<double> fields = process_.step(random, dt).fields();
    if (dt == 0.01)
      for (std::size_t i = 0; i < fields.size(); ++i) fields[i] = hostile_number(input, i, fields[i]);
    return call(ports, {dt, fields, !process_.part.type->spec.fields.empty()}, memory, 0.0);
  }

 private:
  Answer call(const PortStates& ports, const DrivenStep& step, std::byte* memory, double fill) const {
    return answer_of(process_.call(ports, step, copied(memory, memory_bytes()), fill), memory);
  }
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  ProcessFixture process_;
};

class CallsMeasurement final : public Fixture {
 public:
  CallsMeasurement(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial), composition_(std::move(composition)), measurement_(trial, *composition_) {
    auto random = trial.random(3);
    nominal_ports_ = measurement_.ports(random, 0.1);
    nominal_ = measurement_.sample(nominal_ports_, random);
  }
  std::size_t memory_bytes() const override { return measurement_.part.model->declaration().memory_bytes; }
  void start(std::byte* memory) const override { measurement_.part.model->start(memory); }
  Answer turn(std::uint64_t k, std::byte* memory, double fill) const override {
    auto random = trial_.random(3000 + k);
    SampleNumbers sample = nominal_;
    for (std::size_t i = 0; i < sample.count(); ++i)
      if (sample.at(i) != std::round(sample.at(i))) sample.at(i) += 1e-6 * normal(random);  // who a row is stays
    return call(measurement_.ports(random, 0.1), sample, memory, fill);
  }
  std::vector<std::string> hostile_finite() const override {
    auto all = finite_hostilities();
    if (nominal_.rows > 0) all.insert(all.end(), {"no row", "single row"});
    return all;
  }
  std::vector<std::string> hostile_nonfinite() const override { return nonfinite_hostilities(); }
  Answer hostile(const std::string& input, std::byte* memory) const override {
    SampleNumbers sample = nominal_;
    for (std::size_t i = 0; i < sample.count(); ++i) sample.at(i) = hostile_number(input, i, sample.at(i));
    if (input == "no row") sample.rows = 0;
    if (input == "single row") sample.rows = 1;
    return call(nominal_ports_, sample, memory, 0.0);
  }

 private:
  Answer call(const PortStates& ports, const SampleNumbers& sample, std::byte* memory, double fill) const {
    return answer_of(measurement_.call(ports, sample, copied(memory, memory_bytes()), fill), memory);
  }
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  MeasurementFixture measurement_;
  PortStates nominal_ports_;
  SampleNumbers nominal_;
};

class CallsDerived final : public Fixture {
 public:
  CallsDerived(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial), composition_(std::move(composition)), derived_(trial, *composition_) {}
  std::size_t memory_bytes() const override { return 0; }
  void start(std::byte*) const override {}
  Answer turn(std::uint64_t k, std::byte*, double fill) const override {
    auto random = trial_.random(4000 + k);
    const auto evaluated = derived_.caller.evaluate(derived_.ports(random, 0.3), derived_.u(), true, fill);
    return {evaluated.result, evaluated.numbers, evaluated.damage};
  }

 private:
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  DerivedFixture derived_;
};

}  // namespace

std::unique_ptr<Fixture> model_fixture(Trial& trial, std::shared_ptr<const Composition> composition) {
  switch (trial.role) {
    case Role::process_model: return std::make_unique<CallsProcess>(trial, std::move(composition));
    case Role::measurement_model: return std::make_unique<CallsMeasurement>(trial, std::move(composition));
    default: return std::make_unique<CallsDerived>(trial, std::move(composition));
  }
}

}  // namespace binnacle::conform
