// SPDX-License-Identifier: Apache-2.0
// Calls of noise estimators, sources and transforms.
#include "fixture.hpp"
#include "guarded.hpp"

namespace binnacle::conform {

using testing::append;

namespace {

class CallsNoise final : public Fixture {
 public:
  CallsNoise(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial),
        composition_(std::move(composition)),
        noise_(parts::noise(*composition_, filter_name, "adapted")) {}
  std::size_t memory_bytes() const override { return noise_.estimator->declaration().memory_bytes; }
  void start(std::byte* memory) const override { noise_.estimator->start(memory); }
  Answer turn(std::uint64_t k, std::byte* memory, double) const override {
    auto random = trial_.random(5000 + k);
    return call(3.0 * normals(random, noise_.max_rows), 0.1, memory);
  }
  std::vector<std::string> hostile_finite() const override {
    return {"zero", "tiny 1e-300", "alternating 1e15", "dt 1e6", "dt -1"};
  }
  std::vector<std::string> hostile_nonfinite() const override { return nonfinite_hostilities(); }
  Answer hostile(const std::string& input, std::byte* memory) const override {
    auto random = trial_.random(4);
    Eigen::VectorXd r = normals(random, noise_.max_rows);
    for (Eigen::Index i = 0; i < r.size(); ++i) r[i] = hostile_number(input, static_cast<std::size_t>(i), r[i]);
    return call(r, input.rfind("dt ", 0) == 0 ? std::stod(input.substr(3)) : 0.1, memory);
  }

 private:
  Answer call(const Eigen::VectorXd& r, double dt, std::byte* memory) const {
    const int rows = noise_.max_rows;
    testing::InnovationNumbers innovation;
    innovation.t = 3'000'000'000;
    innovation.dt = dt;
    innovation.residual = r;
    innovation.HPHt = Eigen::VectorXd::Constant(rows, 0.5).asDiagonal();
    innovation.R_nominal =
        Eigen::VectorXd::LinSpaced(rows, 1, rows).unaryExpr([](double i) { return i == 1 ? 4.0 : 9.0; }).asDiagonal();
    const auto estimated = testing::NoiseCaller(*noise_.estimator).estimate(innovation, memory);
    Answer answer;
    answer.damage = estimated.damage;
    answer.numbers.assign(estimated.R.data(), estimated.R.data() + estimated.R.size());
    return answer;
  }
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  parts::NoisePart noise_;
};

void append_sample(const testing::Emitted& sample, std::vector<double>& numbers) {
  numbers.push_back(static_cast<double>(sample.channel));
  numbers.push_back(static_cast<double>(sample.t));
  append(numbers, sample.fields);
  append(numbers, sample.row_fields);
  append(numbers, sample.covariance);
}

class CallsSource final : public Fixture {
 public:
  CallsSource(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial), composition_(std::move(composition)), source_(parts::source(*composition_, component_name)) {
    trial_.stage("open");
    try {
      source_.type->guarded("open", [&] { std::const_pointer_cast<Source>(source_.model)->open(silent_); });
    } catch (const ComponentError& refusal) {
      trial_.stage("");
      throw OpenRefused(refusal.what());
    }
    trial_.stage("");
  }
  std::size_t memory_bytes() const override { return source_.model->declaration().memory_bytes; }
  void start(std::byte* memory) const override { source_.model->start(trial_.seed, memory); }
  bool is_live() const override { return source_.model->declaration().live; }
  Answer turn(std::uint64_t, std::byte* memory, double fill) const override {
    const auto next = testing::SourceCaller(*source_.model).next(memory, fill);
    Answer answer;
    answer.damage = next.damage;
    answer.numbers.push_back(static_cast<double>(next.status));
    if (next.status == SourceStatus::sample && next.damage.empty()) append_sample(next.sample, answer.numbers);
    return answer;
  }

 private:
  struct Silent final : Reporter {
    void warn(const std::string&, const std::string&, int, const std::string&) override {}
  };
  Trial& trial_;
  Silent silent_;  // for as long as the source
  std::shared_ptr<const Composition> composition_;
  parts::Part<Source> source_;
};

class CallsTransform final : public Fixture {
 public:
  CallsTransform(Trial& trial, std::shared_ptr<const Composition> composition)
      : trial_(trial),
        composition_(std::move(composition)),
        transform_(parts::transform(*composition_, component_name)) {}
  std::size_t memory_bytes() const override { return transform_.model->declaration().memory_bytes; }
  void start(std::byte* memory) const override { transform_.model->start(trial_.seed, memory); }
  Answer turn(std::uint64_t k, std::byte* memory, double fill) const override {
    auto random = trial_.random(6000 + k);
    const auto& inputs = transform_.type->spec.inputs;
    const std::size_t input = k % inputs.size();
    return call(input, numbers_of(inputs[input], random), 1'000'000'000 + static_cast<Time>(k) * 10'000'000, memory,
                fill);
  }
  std::vector<std::string> hostile_finite() const override {
    auto all = finite_hostilities();
    all.push_back("time going back");
    return all;
  }
  std::vector<std::string> hostile_nonfinite() const override { return nonfinite_hostilities(); }
  Answer hostile(const std::string& name, std::byte* memory) const override {
    auto random = trial_.random(5);
    const auto& inputs = transform_.type->spec.inputs;
    SampleNumbers numbers = numbers_of(inputs[0], random);
    for (std::size_t i = 0; i < numbers.count(); ++i) numbers.at(i) = hostile_number(name, i, numbers.at(i));
    call(0, numbers, 5'000'000'000, memory, 0.0);
    return call(0, numbers, name == "time going back" ? 1'000'000'000 : 5'010'000'000, memory, 0.0);
  }

 private:
  SampleNumbers numbers_of(const ChannelPort& input, std::mt19937_64& random) const {
    const std::vector<bool> all(input.fields.size(), true);
    return made_up(input.fields, all, Surroundings(transform_.type->spec).input(input.name), 0, random, 1.0);
  }

  Answer call(std::size_t input, const SampleNumbers& numbers, Time t, std::byte* memory, double fill) const {
    SampleView sample = numbers.view();
    sample.t = t;
    sample.t0 = t - 10'000'000;
    const auto made =
        testing::TransformCaller(*transform_.model, transform_.type->spec).on(input, sample, memory, fill);
    Answer answer;
    answer.damage = made.damage;
    for (const auto& emitted : made.samples) append_sample(emitted, answer.numbers);
    return answer;
  }
  Trial& trial_;
  std::shared_ptr<const Composition> composition_;
  parts::Part<Transform> transform_;
};

}  // namespace

std::unique_ptr<Fixture> stream_fixture(Trial& trial, std::shared_ptr<const Composition> composition) {
  switch (trial.role) {
    case Role::noise_estimator: return std::make_unique<CallsNoise>(trial, std::move(composition));
    case Role::source: return std::make_unique<CallsSource>(trial, std::move(composition));
    default: return std::make_unique<CallsTransform>(trial, std::move(composition));
  }
}

}  // namespace binnacle::conform
