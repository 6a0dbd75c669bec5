// SPDX-License-Identifier: Apache-2.0
// A sink that holds a run up: at full speed until a time that a file gives, slowly from there on. It says so in FILE.held.
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "binnacle/plugin.hpp"
#include "binnacle/source.hpp"

namespace {

using namespace binnacle;

class Valve final : public Sink {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "valve";
    spec.summary = "Holds a run up.";
    spec.parameters = {parameter::path("path").required().about("a file with a time in seconds")};
    spec.inputs = {input("input", {field::rate("wx", "rad/s").about("any")}).about("what paces the run")};
    spec.example = R"({"input": "imu", "path": "open"})";
    return spec;
  }
  explicit Valve(const Binding& binding) : path_(binding.parameters().text("path")) {}

  void on(Input, const SampleView& sample) override {
    using namespace std::chrono_literals;
    if (seconds(sample.t) <= open_until_) return;
    std::ifstream(path_) >> open_until_;
    if (seconds(sample.t) <= open_until_) return;
    if (held_at_ != open_until_) std::ofstream(path_ + ".held") << (held_at_ = open_until_) << '\n';
    std::this_thread::sleep_for(20ms);
  }

 private:
  std::string path_;
  double open_until_ = 0, held_at_ = -1;
};

}  // namespace

BINNACLE_PLUGIN("valve", "1.0.0", registry) { registry.add<Valve>(); }
