// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a sink that writes how many samples it saw, and their mean.
#include <binnacle/plugin.hpp>

#include <fstream>

using namespace binnacle;

/// A sink is the one component with a life outside the kernel's memory: it may keep state and own a file.
class Tally final : public Sink {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@";
    spec.summary = "Counts the samples of a height and writes their number and mean.";
    spec.parameters = {parameter::path("path").required().about("the text file, written at the end of the run")};
    spec.inputs = {input("input", {field::level("height", "m").about("upward")}).about("what is counted")};
    spec.example = R"json({"input": "heights", "path": "tally.txt"})json";
    return spec;
  }

  explicit Tally(const Binding& b) : path_(b.parameters().text("path")), height_(b.field(b.input("input"), "height")) {}

  void open() override {
    count_ = 0;
    sum_ = 0;
  }

  void on(Input, const SampleView& sample) override {
    ++count_;
    sum_ += sample[height_];
  }

  void close() override {
    std::ofstream file(path_);
    file << count_ << " samples";
    if (count_ > 0) file << ", mean " << sum_ / static_cast<double>(count_) << " m";
    file << "\n";
    if (!file.flush()) throw ComponentError("'" + path_ + "' cannot be written", "/path");
  }

 private:
  std::string path_;
  Field height_;
  std::int64_t count_ = 0;
  double sum_ = 0;  // m
};

BINNACLE_TYPES("@NAME@");
BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<Tally>(); }
