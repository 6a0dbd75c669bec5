// SPDX-License-Identifier: Apache-2.0
// Components that do what none may: exit, loop, throw, in the call that they are asked to.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>

#include "binnacle/plugin.hpp"

namespace {

using namespace binnacle;

/// "fault": what happens, "call": where, "after": not before this time of the samples.
class Sickness {
 public:
  static std::vector<ParameterSpec> parameters() {
    return {parameter::choice("fault", {"none", "exit", "quick_exit", "loop", "throw", "refuse", "terminate"})
                .defaults("\"none\""),
            parameter::text("call").defaults("\"\""), parameter::time("after").defaults("0")};
  }
  explicit Sickness(const Parameters& parameters)
      : fault_(parameters.text("fault")), call_(parameters.text("call")), after_(parameters.time("after")) {}

  void in(const char* call, Time t) const {
    if (call_ != call || t < after_) return;
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
    channels_ = {{"", {{"z0", "m", FieldKind::level, false, false, "the time"}}, 0, {}, 0}};
    sickness_.in("constructor", after_all);
  }
  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override { return sizeof(std::int64_t); }
  void open(Reporter&) override { sickness_.in("open", after_all); }
  void start(std::uint64_t, std::byte*) const override { sickness_.in("start", after_all); }
  SourceStatus next(std::byte* memory, SampleSlot* slots, int& channel) const override {
    std::int64_t count;
    std::memcpy(&count, memory, sizeof count);
    if (count == 10) return SourceStatus::end;
    channel = 0;
    slots[0].t = count * 1'000'000'000;
    slots[0].fields[0] = static_cast<double>(count);
    sickness_.in("next", slots[0].t);
    ++count;
    std::memcpy(memory, &count, sizeof count);
    return SourceStatus::sample;
  }

 private:
  static constexpr Time after_all = 1'000'000'000'000;
  Sickness sickness_;
  std::vector<ChannelDeclaration> channels_;
};

ComponentSpec with_input(const char* type) {
  ComponentSpec spec;
  spec.type = type;
  spec.summary = "Takes a sample.";
  spec.parameters = Sickness::parameters();
  spec.inputs = {{"input", {{"z0", "m", FieldKind::level, false, false, "any"}}, false, "any"}};
  spec.example = R"({"input": "tick"})";
  return spec;
}

class Passing final : public Transform {
 public:
  static ComponentSpec spec() { return with_input("passing"); }
  explicit Passing(const Binding& binding) : sickness_(binding.parameters()) {
    channels_ = {{"", {{"z0", "m", FieldKind::level, false, false, "the same"}}, 0, {}, 0}};
  }
  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override { return 0; }
  void start(std::uint64_t, std::byte*) const override { sickness_.in("start", 1'000'000'000'000); }
  void on(int, const SampleView& sample, std::byte*, Emitter& emitter) const override {
    sickness_.in("on", sample.t);
    SampleSlot& slot = emitter.slot(0);
    slot.t = sample.t;
    slot.fields[0] = sample.fields[0];
    emitter.emit(0);
  }

 private:
  Sickness sickness_;
  std::vector<ChannelDeclaration> channels_;
};

class Sinking final : public Sink {
 public:
  static ComponentSpec spec() { return with_input("sinking"); }
  explicit Sinking(const Binding& binding) : sickness_(binding.parameters()) {}
  void open() override { sickness_.in("open", 1'000'000'000'000); }
  void on(int, const SampleView& sample) override { sickness_.in("on", sample.t); }
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

}  // namespace

BINNACLE_PLUGIN("sick", "1.0.0", registry) {
  registry.add<Ticking>();
  registry.add<Passing>();
  registry.add<Sinking>();
  registry.add<Moving>();
}
