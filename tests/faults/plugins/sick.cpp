// SPDX-License-Identifier: Apache-2.0
// Components that do what none may: exit, loop, throw, in the call that they are asked to.
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "binnacle/plugin.hpp"

namespace {

using namespace binnacle;

/// "fault": what happens, "call": where, "after": not before this time of the samples.
class Sickness {
 public:
  static std::vector<ParameterSpec> parameters() {
    return {parameter::choice("fault", {"none", "exit", "quick_exit", "loop", "throw", "refuse", "terminate"})
                .defaults("\"none\""),
            parameter::text("call").defaults("\"\""), parameter::time("after").defaults("0"),
            parameter::text("rank").defaults("\"\"").about("of an MPI study: that one alone")};
  }
  explicit Sickness(const Parameters& parameters)
      : fault_(parameters.text("fault")),
        call_(parameters.text("call")),
        after_(parameters.time("after")),
        rank_(parameters.text("rank")) {}

  void in(const char* call, Time t) const {
    if (call_ != call || t < after_) return;
    const char* const rank = std::getenv("OMPI_COMM_WORLD_RANK");
    if (!rank_.empty() && (!rank || rank_ != rank)) return;
    if (fault_ == "exit") std::exit(0);
    if (fault_ == "quick_exit") std::quick_exit(0);
    if (fault_ == "terminate") std::terminate();
    if (fault_ == "throw") throw std::runtime_error("lost my marbles");
    if (fault_ == "refuse") throw ComponentError("not today");
    while (fault_ == "loop") std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  std::string fault_, call_;
  Time after_;
  std::string rank_;
};

/// x = t, once a second, for ten seconds.
class Ticking final : public Source {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "ticking";
    spec.summary = "A sample a second.";
    spec.parameters = Sickness::parameters();
    spec.example = "{}";
    return spec;
  }
  explicit Ticking(const Binding& binding) : sickness_(binding.parameters()) {
    ChannelDeclaration channel;
    z0_ = channel.carries(field::level("z0", "m").about("the time"));
    channel_ = declaration_.emits(std::move(channel));
    count_ = declaration_.keeps<std::int64_t>();
    sickness_.in("constructor", after_all);
  }
  void open(Reporter&) override { sickness_.in("open", after_all); }
  SourceStatus next(const MemoryView& memory, SourceOutput& output) const override {
    std::int64_t& count = memory[count_];
    if (count == 10) return SourceStatus::end;
    SampleWriter& out = output.on(channel_);
    out.t = count * 1'000'000'000;
    out[z0_] = static_cast<double>(count);
    sickness_.in("next", out.t);
    ++count;
    return SourceStatus::sample;
  }

 private:
  static constexpr Time after_all = 1'000'000'000'000;
  void initialise(std::uint64_t, const MemoryView&) const override { sickness_.in("start", after_all); }

  Sickness sickness_;
  OutputChannel channel_;
  OutputField z0_;
  Memory<std::int64_t> count_;
};

ComponentSpec with_input(const char* type) {
  ComponentSpec spec;
  spec.type = type;
  spec.summary = "Takes a sample.";
  spec.parameters = Sickness::parameters();
  spec.inputs = {input("input", {field::level("z0", "m").about("any")}).about("any")};
  spec.example = R"({"input": "tick"})";
  return spec;
}

class Passing final : public Transform {
 public:
  static ComponentSpec spec() { return with_input("passing"); }
  explicit Passing(const Binding& binding)
      : sickness_(binding.parameters()), seen_(binding.field(binding.input("input"), "z0")) {
    ChannelDeclaration channel;
    z0_ = channel.carries(field::level("z0", "m").about("the same"));
    channel_ = declaration_.emits(std::move(channel));
  }
  void on(const TransformInput& in, Emitter& emitter) const override {
    sickness_.in("on", in.sample.t);
    SampleWriter& out = emitter.on(channel_);
    out.t = in.sample.t;
    out[z0_] = in.sample[seen_];
    emitter.emit(channel_);
  }

 private:
  void initialise(std::uint64_t, const MemoryView&) const override { sickness_.in("start", 1'000'000'000'000); }

  Sickness sickness_;
  Field seen_;
  OutputChannel channel_;
  OutputField z0_;
};

class Sinking final : public Sink {
 public:
  static ComponentSpec spec() { return with_input("sinking"); }
  explicit Sinking(const Binding& binding) : sickness_(binding.parameters()) {}
  void open() override { sickness_.in("open", 1'000'000'000'000); }
  void on(Input, const SampleView& sample) override { sickness_.in("on", sample.t); }
  void close() override { sickness_.in("close", 1'000'000'000'000); }

 private:
  Sickness sickness_;
};

class Moving final : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "moving";
    spec.summary = "Leaves its block where it is.";
    spec.parameters = Sickness::parameters();
    spec.ports = {advances("x", "vector:1:*", "what stays")};
    spec.example = R"({"blocks": {"x": "x"}})";
    return spec;
  }
  explicit Moving(const Binding& binding) : x_(binding.port("x")), sickness_(binding.parameters()) {}
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    sickness_.in("propagate", in.step.t1);
    out.x[x_].as() = in.x[x_].as();
    return Result::ok();
  }

 private:
  Port x_;
  Sickness sickness_;
};

/// One number, which stays.
class Resting final : public StateBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "resting";
    spec.summary = "One number.";
    spec.parameters = Sickness::parameters();
    spec.kind = "vector:1:m";
    spec.example = R"({"init": 0, "sigma": 1})";
    return spec;
  }
  explicit Resting(const Binding& binding) : sickness_(binding.parameters()) {
    declared_.kind = "vector:1:m";
    declared_.stored_size = 1;
    declared_.error = {{"a", "m"}};
    declared_.outputs.push_back({"a", "m", "", false, false, "it"});
  }
  const StateBlockDeclaration& declaration() const noexcept override { return declared_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    sickness_.in("plus", 0);
    result[0] = x[0] + delta[0];
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    sickness_.in("minus", 0);
    delta[0] = y[0] - x[0];
  }
  void read(ConstVectorView x, VectorView outputs) const override { outputs[0] = x[0]; }
  Result write(ConstVectorView outputs, VectorView x) const override {
    sickness_.in("write", 0);
    x[0] = outputs[0];
    return Result::ok();
  }

 private:
  StateBlockDeclaration declared_;
  Sickness sickness_;
};

}  // namespace

BINNACLE_PLUGIN("sick", "1.0.0", registry) {
  registry.add<Ticking>();
  registry.add<Passing>();
  registry.add<Sinking>();
  registry.add<Moving>();
  registry.add<Resting>();
}
