// SPDX-License-Identifier: Apache-2.0
#include "fixture.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>

#include <Eigen/Dense>

#include "allocations.hpp"
#include "binnacle/legacy.hpp"
#include "binnacle/view.hpp"

namespace binnacle::conform {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();
constexpr double canary = 8.251e77;

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

CallMeter* current_meter = nullptr;

/// A call into the plugin, metered when somebody asked for it.
template <class Call>
auto metered(const Call& call) {
  if (!current_meter) return call();
  const auto before = allocations();
  const auto start = std::chrono::steady_clock::now();
  struct AtEnd {
    std::uint64_t before;
    std::chrono::steady_clock::time_point start;
    ~AtEnd() {
      const auto end = std::chrono::steady_clock::now();
      current_meter->allocations += allocations() - before;
      current_meter->seconds.push_back(std::chrono::duration<double>(end - start).count());
    }
  } at_end{before, start};
  return call();
}

constexpr std::array finite_hostilities = {"zero", "tiny 1e-300", "huge 1e300", "huge -1e300", "alternating 1e15"};
constexpr std::array nonfinite_hostilities = {"NaN", "infinity", "-infinity", "one NaN"};

std::vector<std::string> list_of(const auto& names) { return {names.begin(), names.end()}; }

/// What stands in place of the i-th of a component's input numbers.
double hostile_number(const std::string& name, std::size_t i, double ordinary) {
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

void append(std::vector<double>& all, const std::vector<double>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

void examine(const Guarded& block, const std::string& what, double fill, std::string& damage) {
  if (!damage.empty()) return;
  if (!block.is_intact())
    damage = what + ": written beyond its end";
  else if (std::isnan(fill) && block.has_unwritten())
    damage = what + ": not written completely";
}

std::vector<double> driving_rates_of(const ComponentSpec& spec, std::mt19937_64& random) {
  std::vector<double> rates;
  for (const auto& field : spec.driving_rates) rates.push_back(scale_of(field.unit) * normal(random));
  return rates;
}

}  // namespace

double unwritten() { return std::bit_cast<double>(std::uint64_t{0x7ff8'b1a0'0000'c1e5}); }

void meter_calls(CallMeter* meter) { current_meter = meter; }

Guarded::Guarded(std::size_t size, double fill) : values_(size + 2 * margin, fill), fill_(fill) {
  for (std::size_t i = 0; i < margin; ++i) values_[i] = values_[values_.size() - 1 - i] = canary;
}
bool Guarded::is_intact() const {
  for (std::size_t i = 0; i < margin; ++i)
    if (!same_bits(values_[i], canary) || !same_bits(values_[values_.size() - 1 - i], canary)) return false;
  return true;
}
bool Guarded::has_unwritten() const {
  return std::any_of(data(), data() + size(), [&](double v) { return same_bits(v, fill_); });
}

bool Answer::is_finite() const {
  return std::all_of(numbers.begin(), numbers.end(), [](double v) { return std::isfinite(v); });
}
bool Answer::operator==(const Answer& other) const {
  return result.refusal == other.result.refusal && memory == other.memory && numbers.size() == other.numbers.size() &&
         std::equal(numbers.begin(), numbers.end(), other.numbers.begin(), same_bits);
}

std::vector<std::byte> Fixture::fresh_memory() const {
  std::vector<std::byte> memory(memory_bytes());
  start(memory.data());
  return memory;
}

double normal(std::mt19937_64& random) {
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  const double radius = std::sqrt(-2 * std::log(uniform()));
  return radius * std::cos(2 * EIGEN_PI * uniform());
}
Eigen::VectorXd normals(std::mt19937_64& random, Eigen::Index count) {
  Eigen::VectorXd values(count);
  for (auto& value : values) value = normal(random);
  return values;
}

double scale_of(const std::string& unit) {
  struct Scale {
    const char* unit;
    double size;
  };
  for (const Scale& scale : {Scale{"rad", 0.2}, Scale{"m", 10}, Scale{"m/s", 3}, Scale{"rad/s", 0.05},
                             Scale{"m/s^2", 0.5}, Scale{"1", 0.01}, Scale{"s", 1e-6}})
    if (unit == scale.unit) return scale.size;
  return 1;
}

std::shared_ptr<const StateBlock> block_of_kind(Trial& trial, const Composition& composition, const std::string& kind) {
  // A process of its own composes whatever it likes.
  const Catalog& catalog = composition.catalog();
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
    state.name = value.name;
    if (value.block) {
      state.block = value.block;
      const auto& declared = value.block->declaration();
      state.x = value.initial;
      state.x.resize(static_cast<std::size_t>(declared.stored_size), 0.0);
      state.scale.resize(declared.dof());
      for (int i = 0; i < declared.dof(); ++i)
        state.scale[i] = scale_of(declared.error[static_cast<std::size_t>(i)].unit);
      const Eigen::VectorXd delta = spread * state.scale.cwiseProduct(normals(random, declared.dof()));
      state.block->plus(state.x.data(), delta.data(), state.x.data());
    }
    states.push_back(std::move(state));
  }
  return states;
}

std::vector<const double*> pointers(const PortStates& ports) {
  std::vector<const double*> x;
  for (const auto& port : ports) x.push_back(port.is_open() ? nullptr : port.x.data());
  return x;
}

// ---- process models

ProcessFixture::ProcessFixture(Trial& trial, const Composition& composition)
    : part(parts::process(composition, filter_name, component_name)), trial_(trial) {}

PortStates ProcessFixture::ports(std::mt19937_64& random, double spread) const {
  return port_states(part.ports, random, spread);
}

ProcessInput ProcessFixture::input(std::mt19937_64& random, double dt) const {
  ProcessInput input{dt, {}};
  for (const auto& field : part.type->spec.fields) {
    const std::string& unit = field.unit;
    const double per_second = unit == "rad" ? 0.2 : unit == "m/s" ? 5 : scale_of(unit);
    input.fields.push_back(normal(random) * (field.kind == FieldKind::increment ? per_second * dt : per_second));
  }
  return input;
}

Propagated ProcessFixture::call(const PortStates& ports, const ProcessInput& input, std::byte* memory,
                                double fill) const {
  const ProcessDeclaration& declared = part.model->declaration();
  Propagated out;
  std::vector<Guarded> x_plus, transition, noise;
  for (std::size_t i = 0; i < ports.size(); ++i) x_plus.emplace_back(advances(i) ? ports[i].x.size() : 0, fill);
  const auto blocks = [&](const std::vector<Coupling>& couplings, std::vector<Guarded>& to) {
    for (const auto& c : couplings) {
      const auto rows = static_cast<std::size_t>(ports.at(static_cast<std::size_t>(c.to)).dof());
      const auto columns = static_cast<std::size_t>(ports.at(static_cast<std::size_t>(c.from)).dof());
      to.emplace_back(c.structure == Structure::diagonal ? rows : rows * columns, fill);
    }
  };
  blocks(declared.transition, transition);
  blocks(declared.noise, noise);
  std::vector<double*> x_at, transition_at, noise_at;
  for (std::size_t i = 0; i < ports.size(); ++i)
    x_at.push_back(advances(i) && !ports[i].is_open() ? x_plus[i].data() : nullptr);
  for (auto& block : transition) transition_at.push_back(block.data());
  for (auto& block : noise) noise_at.push_back(block.data());

  const Time t0 = 1'000'000'000;
  const Time t1 = t0 + static_cast<Time>(std::llround(std::clamp(input.dt, -1e9, 1e9) * 1e9));
  const InputSample sample{t0, t1, input.dt, t0, t1, input.fields.data()};
  const bool takes_input = !part.type->spec.fields.empty();
  const Step step{t0, t1, input.dt, takes_input ? std::span(&sample, 1) : std::span<const InputSample>()};
  const auto x = pointers(ports);

  if (declared.has_closed_form) {
    trial_.stage("propagate");
    out.answer.result = metered([&] {
      return legacy::propagate(*part.model, step, x.data(), memory,
                               legacy::ProcessOutput{x_at.data(), transition_at.data(), noise_at.data()});
    });
  } else {
    trial_.stage("linearized");
    metered([&] {
      legacy::linearized(*part.model, x.data(), legacy::ContinuousOutput{transition_at.data(), noise_at.data()});
      return 0;
    });
    x_plus.assign(ports.size(), Guarded(0, fill));
  }
  trial_.stage("");

  std::string& damage = out.answer.damage;
  const auto collect = [&](const char* what, const std::vector<Coupling>& couplings, const std::vector<Guarded>& from,
                           std::vector<Eigen::MatrixXd>& to) {
    for (std::size_t i = 0; i < couplings.size(); ++i) {
      if (out.answer.result) examine(from[i], std::string(what) + " " + std::to_string(i), fill, damage);
      const int rows = ports[static_cast<std::size_t>(couplings[i].to)].dof();
      const int columns = ports[static_cast<std::size_t>(couplings[i].from)].dof();
      if (couplings[i].structure == Structure::diagonal)
        to.push_back(vector_at(from[i].data(), rows).asDiagonal());
      else
        to.push_back(matrix_at(from[i].data(), rows, columns));
      append(out.answer.numbers, from[i].values());
    }
  };
  for (std::size_t i = 0; i < x_plus.size(); ++i) {
    if (out.answer.result) examine(x_plus[i], "x_plus of port " + std::to_string(i), fill, damage);
    append(out.answer.numbers, x_plus[i].values());
    out.x_plus.push_back(x_plus[i].values());
  }
  collect("transition", declared.transition, transition, out.transition);
  collect("noise", declared.noise, noise, out.noise);
  out.answer.memory.assign(memory, memory + declared.memory_bytes);
  if (!out.answer.result) out.answer.numbers.clear();
  return out;
}

// ---- measurement models

MeasurementFixture::MeasurementFixture(Trial& trial, const Composition& composition)
    : part(parts::measurement(composition, filter_name, component_name)), trial_(trial) {
  auto random = trial.random(77);
  driving_rates_ = driving_rates_of(part.type->spec, random);
  const std::string channel =
      composition.config().at("filters").at(filter_name).at("measurements").at(component_name).at("channel");
  const Json settings = composition.config().at("filters").at(filter_name).at("measurements").at(component_name);
  for (const auto& field : part.type->spec.fields) {
    std::string name = field.name;
    if (settings.contains("fields") && settings.at("fields").contains(name)) name = settings.at("fields").at(name);
    bool carried = false;
    for (const auto& info : composition.channels())
      if (info.name == channel)
        for (const auto& had : info.declaration->fields) carried |= had.name == name;
    has_field.push_back(carried);
  }
}

PortStates MeasurementFixture::ports(std::mt19937_64& random, double spread) const {
  return port_states(part.ports, random, spread);
}

Measured MeasurementFixture::call(const PortStates& ports, const std::vector<double>& fields, std::byte* memory,
                                  double fill, int rows_of_sample) const {
  const MeasurementDeclaration& declared = part.model->declaration();
  const auto rows = static_cast<std::size_t>(declared.max_rows);
  std::vector<double> epoch, row;
  const auto& specs = part.type->spec.fields;
  int sample_rows = 0;
  for (std::size_t i = 0; i < specs.size(); ++i)
    if (!specs[i].is_per_row) epoch.push_back(fields[i]);
  for (int r = 0; r < 4; ++r)
    for (std::size_t i = 0; i < specs.size(); ++i)
      if (specs[i].is_per_row) row.push_back(fields[i] * (1 + 0.01 * r)), sample_rows = 4;
  SampleView sample;
  sample.t = 2'000'000'000;
  sample.t0 = 1'990'000'000;
  sample.rows = rows_of_sample >= 0 ? std::min(rows_of_sample, sample_rows) : sample_rows;
  sample.fields = epoch.data();
  sample.row_fields = row.data();
  sample.available = true;

  Guarded residual(rows, fill), R(rows * rows, 0.0);
  std::vector<Guarded> H;
  std::vector<MatrixView> views;
  for (const int port : declared.read_ports) {
    const int dof = ports.at(static_cast<std::size_t>(port)).dof();
    H.emplace_back(rows * static_cast<std::size_t>(dof), 0.0);
  }
  for (std::size_t i = 0; i < H.size(); ++i)
    views.push_back({H[i].data(), declared.max_rows, ports[static_cast<std::size_t>(declared.read_ports[i])].dof(),
                     declared.max_rows});
  std::vector<std::int64_t> keys(rows);
  for (std::size_t i = 0; i < rows; ++i) keys[i] = static_cast<std::int64_t>(i);
  std::vector<SampleView> auxiliary(part.type->spec.inputs.size());
  const legacy::Context context{sample.t, driving_rates_.empty() ? nullptr : driving_rates_.data()};
  legacy::Linearization at{0,
                           residual.data(),
                           views.data(),
                           {R.data(), declared.max_rows, declared.max_rows, declared.max_rows},
                           keys.data()};
  const auto x = pointers(ports);

  Measured out;
  trial_.stage("linearize");
  out.answer.result =
      metered([&] { return legacy::linearize(*part.model, sample, auxiliary.data(), x.data(), context, memory, at); });
  trial_.stage("");
  std::string& damage = out.answer.damage;
  out.answer.memory.assign(memory, memory + declared.memory_bytes);
  if (!residual.is_intact()) damage = "residual: written beyond its end";
  if (!R.is_intact()) damage = "R: written beyond its end";
  for (const auto& block : H)
    if (!block.is_intact()) damage = "H: written beyond its end";
  if (!out.answer.result) return out;
  if (at.rows < 1 || at.rows > declared.max_rows) {
    damage = "it wrote " + std::to_string(at.rows) + " rows, and declared at most " + std::to_string(declared.max_rows);
    return out;
  }
  for (int i = 0; i < at.rows; ++i)
    if (damage.empty() && std::isnan(fill) && same_bits(residual.data()[i], fill))
      damage = "residual: not written completely";
  out.residual = vector_at(residual.data(), at.rows);
  for (const auto& view : views) out.H.push_back(view.as().topRows(at.rows));
  out.R = at.R.as().topLeftCorner(at.rows, at.rows);
  append(out.answer.numbers, {residual.data(), residual.data() + at.rows});
  for (const auto& h : out.H) append(out.answer.numbers, {h.data(), h.data() + h.size()});
  append(out.answer.numbers, {out.R.data(), out.R.data() + out.R.size()});
  return out;
}

Eigen::VectorXd MeasurementFixture::residual(const PortStates& ports, const std::vector<double>& fields) const {
  std::vector<std::byte> memory(part.model->declaration().memory_bytes);
  part.model->start(memory.data());
  const Measured measured = call(ports, fields, memory.data(), 0.0);
  return measured.answer.result ? measured.residual : Eigen::VectorXd();
}

std::vector<double> MeasurementFixture::fields(const PortStates& ports, std::mt19937_64& random,
                                               const Eigen::VectorXd& wanted) const {
  const auto& specs = part.type->spec.fields;
  Json told = Json::object();
  if (!part.type->spec.surroundings.empty()) {
    const Json around = Json::parse(part.type->spec.surroundings, nullptr, true, true);
    told = around.value("sample", Json::object());
  }
  std::vector<double> z;
  for (std::size_t i = 0; i < specs.size(); ++i) {
    double value = has_field[i] ? 0.1 * scale_of(specs[i].unit) * normal(random) : quiet_nan;
    for (const auto& port : ports) {
      if (port.is_open() || !has_field[i]) continue;
      const auto& outputs = port.block->declaration().outputs;
      std::vector<double> read(outputs.size());
      port.block->read(port.x.data(), read.data());
      for (std::size_t o = 0; o < outputs.size(); ++o)
        if (outputs[o].name == specs[i].name) value = read[o];
    }
    if (told.contains(specs[i].name)) value = told.at(specs[i].name).get<double>();
    z.push_back(value);
  }
  if (z.empty()) return z;  // a model that is told nothing but the time
  // Gauss and Newton over the fields: r(z) = wanted.
  for (int iteration = 0; iteration < 12; ++iteration) {
    const Eigen::VectorXd r = residual(ports, z);
    if (r.size() == 0 || !r.allFinite()) return z;
    Eigen::VectorXd error = r;
    if (wanted.size() == r.size()) error -= wanted;
    if (error.norm() < 1e-12) return z;
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(r.size(), static_cast<Eigen::Index>(z.size()));
    for (std::size_t i = 0; i < z.size(); ++i) {
      if (std::isnan(z[i])) continue;
      const double h = 1e-6 * std::max(1.0, std::abs(z[i]));
      std::vector<double> up = z, down = z;
      up[i] += h, down[i] -= h;
      const Eigen::VectorXd r_up = residual(ports, up), r_down = residual(ports, down);
      if (r_up.size() == r.size() && r_down.size() == r.size())
        J.col(static_cast<Eigen::Index>(i)) = (r_up - r_down) / (2 * h);
    }
    if (!J.allFinite()) return z;
    const Eigen::VectorXd step = J.completeOrthogonalDecomposition().solve(error);
    for (std::size_t i = 0; i < z.size(); ++i)
      if (!std::isnan(z[i])) z[i] -= step[static_cast<Eigen::Index>(i)];
  }
  return z;
}

// ---- derived blocks

DerivedFixture::DerivedFixture(Trial& trial, const Composition& composition)
    : part(parts::derived(composition, filter_name, component_name)), trial_(trial) {
  auto random = trial.random(78);
  driving_rates_ = driving_rates_of(part.type->spec, random);
  yields = block_of_kind(trial, composition, part.model->declaration().kind);
}

PortStates DerivedFixture::ports(std::mt19937_64& random, double spread) const {
  return port_states(part.ports, random, spread);
}

DerivedFixture::Evaluated DerivedFixture::call(const PortStates& ports, double fill, bool with_jacobian) const {
  const DerivedDeclaration& declared = part.model->declaration();
  const auto dof = static_cast<std::size_t>(declared.dof());
  Guarded value(static_cast<std::size_t>(declared.stored_size), fill);
  std::vector<Guarded> J;
  std::vector<MatrixView> views;
  for (const int port : declared.read_ports)
    J.emplace_back(dof * static_cast<std::size_t>(ports.at(static_cast<std::size_t>(port)).dof()), 0.0);
  for (std::size_t i = 0; i < J.size(); ++i)
    views.push_back(
        {J[i].data(), declared.dof(), ports[static_cast<std::size_t>(declared.read_ports[i])].dof(), declared.dof()});
  const legacy::Context context{2'000'000'000, driving_rates_.empty() ? nullptr : driving_rates_.data()};
  const auto x = pointers(ports);
  Evaluated out;
  trial_.stage("evaluate");
  out.answer.result = metered([&] {
    return legacy::evaluate(*part.model, x.data(), context, value.data(), with_jacobian ? views.data() : nullptr);
  });
  trial_.stage("");
  if (!out.answer.result) return out;
  examine(value, "value", fill, out.answer.damage);
  for (const auto& block : J)
    if (!block.is_intact()) out.answer.damage = "J: written beyond its end";
  out.value = value.values();
  append(out.answer.numbers, out.value);
  for (const auto& view : views) {
    out.J.push_back(view.as());
    if (with_jacobian) append(out.answer.numbers, {out.J.back().data(), out.J.back().data() + out.J.back().size()});
  }
  return out;
}

// ---- the same calls for every role

namespace {

class CallsBlock final : public Fixture {
 public:
  CallsBlock(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial),
        composition_(std::move(composition)),
        value_(parts::block(*composition_, filter_name, component_name)) {}
  std::size_t memory_bytes() const override { return 0; }
  void start(std::byte*) const override {}
  Answer turn(std::uint64_t k, std::byte*, double fill) const override {
    auto random = trial_.random(1000 + k);
    PortStates at = port_states({value_}, random, 0.5);
    return call(at.front().x, 0.3 * at.front().scale.cwiseProduct(normals(random, at.front().scale.size())), fill);
  }
  std::vector<std::string> hostile_finite() const override { return {"zero", "tiny 1e-300", "alternating 1e15"}; }
  std::vector<std::string> hostile_nonfinite() const override { return list_of(nonfinite_hostilities); }
  Answer hostile(const std::string& input, std::byte*) const override {
    auto random = trial_.random(1);
    PortStates at = port_states({value_}, random, 0.5);
    Eigen::VectorXd delta = normals(random, at.front().scale.size());
    for (Eigen::Index i = 0; i < delta.size(); ++i)
      delta[i] = hostile_number(input, static_cast<std::size_t>(i), delta[i]);
    return call(at.front().x, delta, 0.0);
  }

 private:
  Answer call(const std::vector<double>& x, const Eigen::VectorXd& delta, double fill) const {
    const StateBlock& block = *value_.block;
    const auto& declared = block.declaration();
    Guarded y(x.size(), fill), back(static_cast<std::size_t>(declared.dof()), fill),
        read(declared.outputs.size(), fill), written(x.size(), fill),
        G(static_cast<std::size_t>(declared.dof() * declared.dof()), fill);
    Answer answer;
    trial_.stage("plus");
    metered([&] { return block.plus(x.data(), delta.data(), y.data()), 0; });
    trial_.stage("minus");
    metered([&] { return block.minus(y.data(), x.data(), back.data()), 0; });
    trial_.stage("read");
    metered([&] { return block.read(y.data(), read.data()), 0; });
    trial_.stage("write");
    const Result result = metered([&] { return block.write(read.data(), written.data()); });
    trial_.stage("reset_jacobian");
    const bool has_reset = metered([&] { return block.reset_jacobian(delta.data(), G.data()); });
    trial_.stage("");
    examine(y, "plus", fill, answer.damage);
    examine(back, "minus", fill, answer.damage);
    examine(read, "read", fill, answer.damage);
    if (result) examine(written, "write", fill, answer.damage);
    if (has_reset) examine(G, "reset_jacobian", fill, answer.damage);
    for (const auto* part : {&y, &back, &read}) append(answer.numbers, part->values());
    if (result) append(answer.numbers, written.values());
    if (has_reset) append(answer.numbers, G.values());
    return answer;
  }
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  parts::Value value_;
};

class CallsProcess final : public Fixture {
 public:
  CallsProcess(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial), composition_(std::move(composition)), process_(trial, *composition_) {}
  std::size_t memory_bytes() const override { return process_.part.model->declaration().memory_bytes; }
  void start(std::byte* memory) const override { process_.part.model->start(memory); }
  Answer turn(std::uint64_t k, std::byte* memory, double fill) const override {
    auto random = trial_.random(2000 + k);
    const PortStates ports = process_.ports(random, 0.3);
    return process_.call(ports, process_.input(random, k % 3 == 2 ? 0.02 : 0.01), memory, fill).answer;
  }
  std::vector<std::string> hostile_finite() const override {
    std::vector<std::string> all = {"dt 0", "dt 1e-9", "dt 1e6", "dt -0.01"};
    if (!process_.part.type->spec.fields.empty())
      all.insert(all.end(), finite_hostilities.begin(), finite_hostilities.end());
    return all;
  }
  std::vector<std::string> hostile_nonfinite() const override {
    return process_.part.type->spec.fields.empty() ? std::vector<std::string>() : list_of(nonfinite_hostilities);
  }
  Answer hostile(const std::string& input, std::byte* memory) const override {
    auto random = trial_.random(2);
    const PortStates ports = process_.ports(random, 0.3);
    const double dt = input.rfind("dt ", 0) == 0 ? std::stod(input.substr(3)) : 0.01;
    ProcessInput made = process_.input(random, dt);
    if (dt == 0.01)
      for (std::size_t i = 0; i < made.fields.size(); ++i) made.fields[i] = hostile_number(input, i, made.fields[i]);
    return process_.call(ports, made, memory, 0.0).answer;
  }

 private:
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
    nominal_fields_ = measurement_.fields(nominal_ports_, random);
  }
  std::size_t memory_bytes() const override { return measurement_.part.model->declaration().memory_bytes; }
  void start(std::byte* memory) const override { measurement_.part.model->start(memory); }
  Answer turn(std::uint64_t k, std::byte* memory, double fill) const override {
    auto random = trial_.random(3000 + k);
    std::vector<double> fields = nominal_fields_;
    for (auto& field : fields) field += 1e-6 * normal(random);
    return measurement_.call(measurement_.ports(random, 0.1), fields, memory, fill).answer;
  }
  std::vector<std::string> hostile_finite() const override {
    auto all = list_of(finite_hostilities);
    if (has_rows()) all.insert(all.end(), {"no row", "single row"});
    return all;
  }
  std::vector<std::string> hostile_nonfinite() const override { return list_of(nonfinite_hostilities); }
  Answer hostile(const std::string& input, std::byte* memory) const override {
    std::vector<double> fields = nominal_fields_;
    for (std::size_t i = 0; i < fields.size(); ++i) fields[i] = hostile_number(input, i, fields[i]);
    const int rows = input == "no row" ? 0 : input == "single row" ? 1 : -1;
    return measurement_.call(nominal_ports_, fields, memory, 0.0, rows).answer;
  }

 private:
  bool has_rows() const {
    const auto& fields = measurement_.part.type->spec.fields;
    return std::any_of(fields.begin(), fields.end(), [](const auto& field) { return field.is_per_row; });
  }
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  MeasurementFixture measurement_;
  PortStates nominal_ports_;
  std::vector<double> nominal_fields_;
};

class CallsDerived final : public Fixture {
 public:
  CallsDerived(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial), composition_(std::move(composition)), derived_(trial, *composition_) {}
  std::size_t memory_bytes() const override { return 0; }
  void start(std::byte*) const override {}
  Answer turn(std::uint64_t k, std::byte*, double fill) const override {
    auto random = trial_.random(4000 + k);
    return derived_.call(derived_.ports(random, 0.3), fill).answer;
  }

 private:
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  DerivedFixture derived_;
};

class CallsNoise final : public Fixture {
 public:
  CallsNoise(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial),
        composition_(std::move(composition)),
        noise_(parts::noise(*composition_, filter_name, "adapted")) {}
  std::size_t memory_bytes() const override { return noise_.estimator->memory_bytes(); }
  void start(std::byte* memory) const override { noise_.estimator->start(memory); }
  Answer turn(std::uint64_t k, std::byte* memory, double fill) const override {
    auto random = trial_.random(5000 + k);
    return call(3.0 * normals(random, noise_.max_rows), 0.1, memory, fill);
  }
  std::vector<std::string> hostile_finite() const override {
    return {"zero", "tiny 1e-300", "alternating 1e15", "dt 1e6", "dt -1"};
  }
  std::vector<std::string> hostile_nonfinite() const override { return list_of(nonfinite_hostilities); }
  Answer hostile(const std::string& input, std::byte* memory) const override {
    auto random = trial_.random(4);
    Eigen::VectorXd r = normals(random, noise_.max_rows);
    for (Eigen::Index i = 0; i < r.size(); ++i) r[i] = hostile_number(input, static_cast<std::size_t>(i), r[i]);
    return call(r, input.rfind("dt ", 0) == 0 ? std::stod(input.substr(3)) : 0.1, memory, 0.0);
  }

 private:
  Answer call(const Eigen::VectorXd& r, double dt, std::byte* memory, double) const {
    const auto m = static_cast<std::size_t>(noise_.max_rows);
    Guarded R(m * m, 0.0), nominal(m * m, 0.0), HPHt(m * m, 0.0);
    std::vector<std::int64_t> keys(m);
    for (std::size_t i = 0; i < m; ++i) {
      keys[i] = static_cast<std::int64_t>(i);
      R.data()[i * m + i] = nominal.data()[i * m + i] = i ? 9 : 4;
      HPHt.data()[i * m + i] = 0.5;
    }
    const int rows = noise_.max_rows;
    Innovation innovation;
    innovation.t = 3'000'000'000;
    innovation.dt = dt;
    innovation.rows = rows;
    innovation.row_keys = keys;
    innovation.residual = r.data();
    innovation.HPHt = {HPHt.data(), rows, rows, rows};
    innovation.R_nominal = {nominal.data(), rows, rows, rows};
    Answer answer;
    trial_.stage("estimate");
    metered([&] { return noise_.estimator->estimate(innovation, memory, {R.data(), rows, rows, rows}), 0; });
    if (noise_.estimator->wants_after()) {
      trial_.stage("after");
      const Eigen::VectorXd post = 0.8 * r;
      metered([&] {
        return noise_.estimator->after(Outcome::accepted, post.data(), {HPHt.data(), rows, rows, rows}, memory), 0;
      });
    }
    trial_.stage("");
    if (!R.is_intact()) answer.damage = "R: written beyond its end";
    answer.numbers = R.values();
    answer.memory.assign(memory, memory + memory_bytes());
    return answer;
  }
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  parts::NoisePart noise_;
};

/// The slots of a component's channels, as the kernel has them.
class Slots {
 public:
  Slots(const std::vector<ChannelDeclaration>& channels, double fill) {
    for (const auto& channel : channels) {
      std::size_t epoch = 0, row = 0;
      for (const auto& field : channel.fields) (field.is_per_row ? row : epoch) += 1;
      fields_.emplace_back(epoch, fill);
      rows_.emplace_back(row * static_cast<std::size_t>(channel.max_rows), fill);
      covariance_.emplace_back(channel.covariance.size() * channel.covariance.size(), fill);
    }
    slots.resize(channels.size());
    for (std::size_t i = 0; i < slots.size(); ++i) {
      slots[i].fields = fields_[i].data();
      slots[i].row_fields = rows_[i].data();
      slots[i].covariance = covariance_[i].data();
    }
  }
  bool is_intact() const {
    const auto intact = [](const Guarded& part) { return part.is_intact(); };
    return std::all_of(fields_.begin(), fields_.end(), intact) && std::all_of(rows_.begin(), rows_.end(), intact) &&
           std::all_of(covariance_.begin(), covariance_.end(), intact);
  }
  void tell(std::size_t channel, std::vector<double>& numbers) const {
    const SampleSlot& slot = slots[channel];
    numbers.push_back(static_cast<double>(channel));
    numbers.push_back(static_cast<double>(slot.t));
    append(numbers, fields_[channel].values());
  }
  std::vector<SampleSlot> slots;

 private:
  std::vector<Guarded> fields_, rows_, covariance_;
};

class CallsSource final : public Fixture {
 public:
  CallsSource(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial), composition_(std::move(composition)), source_(parts::source(*composition_, component_name)) {
    struct Silent final : Reporter {
      void warn(const std::string&, const std::string&, int, const std::string&) override {}
    } silent;
    trial_.stage("open");
    std::const_pointer_cast<Source>(source_.model)->open(silent);
    trial_.stage("");
  }
  std::size_t memory_bytes() const override { return source_.model->memory_bytes(); }
  void start(std::byte* memory) const override { source_.model->start(trial_.seed, memory); }
  Answer turn(std::uint64_t, std::byte* memory, double fill) const override {
    Slots slots(source_.model->channels(), fill);
    int channel = 0;
    trial_.stage("next");
    const SourceStatus status = metered([&] { return source_.model->next(memory, slots.slots.data(), channel); });
    trial_.stage("");
    Answer answer;
    if (!slots.is_intact()) answer.damage = "a slot: written beyond its end";
    answer.numbers.push_back(static_cast<double>(status));
    if (status == SourceStatus::sample) {
      if (channel < 0 || channel >= static_cast<int>(slots.slots.size()))
        answer.damage = "there is no channel " + std::to_string(channel);
      else
        slots.tell(static_cast<std::size_t>(channel), answer.numbers);
    }
    answer.memory.assign(memory, memory + memory_bytes());
    return answer;
  }

 private:
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  parts::Part<Source> source_;
};

class CallsTransform final : public Fixture {
 public:
  CallsTransform(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial),
        composition_(std::move(composition)),
        transform_(parts::transform(*composition_, component_name)) {}
  std::size_t memory_bytes() const override { return transform_.model->memory_bytes(); }
  void start(std::byte* memory) const override { transform_.model->start(trial_.seed, memory); }
  Answer turn(std::uint64_t k, std::byte* memory, double fill) const override {
    auto random = trial_.random(6000 + k);
    const auto& inputs = transform_.type->spec.inputs;
    const std::size_t input = k % inputs.size();
    std::vector<double> fields;
    for (const auto& field : inputs[input].fields) fields.push_back(scale_of(field.unit) * normal(random));
    return call(input, fields, 1'000'000'000 + static_cast<Time>(k) * 10'000'000, memory, fill);
  }
  std::vector<std::string> hostile_finite() const override {
    auto all = list_of(finite_hostilities);
    all.push_back("time going back");
    return all;
  }
  std::vector<std::string> hostile_nonfinite() const override { return list_of(nonfinite_hostilities); }
  Answer hostile(const std::string& name, std::byte* memory) const override {
    auto random = trial_.random(5);
    const auto& inputs = transform_.type->spec.inputs;
    std::vector<double> fields;
    for (const auto& field : inputs[0].fields) fields.push_back(scale_of(field.unit) * normal(random));
    for (std::size_t i = 0; i < fields.size(); ++i) fields[i] = hostile_number(name, i, fields[i]);
    call(0, fields, 5'000'000'000, memory, 0.0);
    return call(0, fields, name == "time going back" ? 1'000'000'000 : 5'010'000'000, memory, 0.0);
  }

 private:
  struct Collector final : Emitter {
    Collector(const std::vector<ChannelDeclaration>& channels, double fill) : slots(channels, fill) {}
    SampleSlot& slot(int channel) override { return slots.slots.at(static_cast<std::size_t>(channel)); }
    void emit(int channel) override {
      const auto i = static_cast<std::size_t>(channel);
      if (i >= slots.slots.size()) {
        damage = "it emits on a channel that it has not";
        return;
      }
      if (emitted_count < most) emitted[emitted_count++] = i;
    }
    /// Afterwards, so that nothing of it is counted as the plugin's.
    std::vector<double> numbers() const {
      std::vector<double> all;
      for (std::size_t e = 0; e < emitted_count; ++e) slots.tell(emitted[e], all);
      return all;
    }
    static constexpr std::size_t most = 64;
    Slots slots;
    std::array<std::size_t, most> emitted{};
    std::size_t emitted_count = 0;
    const char* damage = "";
  };

  Answer call(std::size_t input, const std::vector<double>& fields, Time t, std::byte* memory, double fill) const {
    Collector collector(transform_.model->channels(), fill);
    SampleView sample;
    sample.t = t;
    sample.t0 = t - 10'000'000;
    sample.fields = fields.data();
    sample.available = true;
    trial_.stage("on");
    metered([&] { return transform_.model->on(static_cast<int>(input), sample, memory, collector), 0; });
    trial_.stage("");
    Answer answer;
    answer.damage = collector.damage;
    if (!collector.slots.is_intact()) answer.damage = "a slot: written beyond its end";
    answer.numbers = collector.numbers();
    answer.memory.assign(memory, memory + memory_bytes());
    return answer;
  }
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  parts::Part<Transform> transform_;
};

}  // namespace

std::unique_ptr<Fixture> fixture(Trial& trial, std::shared_ptr<const Composition> composition) {
  switch (trial.role) {
    case Role::state_block: return std::make_unique<CallsBlock>(trial, std::move(composition));
    case Role::process_model: return std::make_unique<CallsProcess>(trial, std::move(composition));
    case Role::measurement_model: return std::make_unique<CallsMeasurement>(trial, std::move(composition));
    case Role::derived_block: return std::make_unique<CallsDerived>(trial, std::move(composition));
    case Role::noise_estimator: return std::make_unique<CallsNoise>(trial, std::move(composition));
    case Role::source: return std::make_unique<CallsSource>(trial, std::move(composition));
    case Role::transform: return std::make_unique<CallsTransform>(trial, std::move(composition));
    case Role::sink: break;
  }
  Trial::skip("a sink has nothing to call without a file of its own");
}

std::unique_ptr<Fixture> fixture_of_example(Trial& trial) { return fixture(trial, compose_example(trial)); }

}  // namespace binnacle::conform
