// SPDX-License-Identifier: Apache-2.0
// The smallest components there can be, for plugins that try the loader.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/plugin.hpp"

namespace loader_test {

using namespace binnacle;

/// A block of one number.
class Still final : public StateBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "still";
    spec.former_names = {"old_home/still"};
    spec.summary = "One number that is what it is";
    spec.source = "none";
    spec.kind = "vector:1:m";
    spec.parameters = {parameter::number("length", "m").at_least(0).defaults("\"2 km\"").about("how long")};
    spec.example = R"({"length": "3 m", "sigma": "1 m"})";
    return spec;
  }
  explicit Still(const Binding& binding) {
    declaration_.kind = "vector:1:m";
    declaration_.stored_size = 1;
    declaration_.error = {{"x", "m"}};
    declaration_.outputs = {{"x", "m", "", false, true, ""}};
    length_ = binding.parameters().has("length") ? binding.parameters().number("length") : 0;
  }
  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override { result[0] = x[0] + delta[0]; }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override { delta[0] = y[0] - x[0]; }
  void read(ConstVectorView x, VectorView outputs) const override { outputs[0] = x[0] + length_; }
  Result write(ConstVectorView outputs, VectorView x) const override {
    x[0] = outputs[0] - length_;
    return Result::ok();
  }

 private:
  StateBlockDeclaration declaration_;
  double length_ = 0;
};

/// An exception class that only this library knows.
struct OwnError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A source whose constructor and open() fail on demand.
class Thrower final : public Source {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "thrower";
    spec.summary = "Throws";
    spec.parameters = {parameter::choice("what", {"nothing", "component_error", "data_error", "own_error", "int"})
                           .required()
                           .about("what is thrown")};
    return spec;
  }
  explicit Thrower(const Binding& binding) : what_(binding.parameters().text("what")) {
    if (what_ == "component_error") throw ComponentError("too still", "/what");
    if (what_ == "data_error") throw ComponentError::in_data("a hole", "drive.csv", 12, "B062");
    if (what_ == "own_error") throw OwnError("lost my marbles");
    if (what_ == "int") throw 42;
  }
  void open(Reporter&) override { throw OwnError("cannot open"); }
  SourceStatus next(const MemoryView&, SourceOutput&) const override { return SourceStatus::end; }

 private:
  std::string what_;
};

/// A process model without any state of its own.
class Rest final : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "rest";
    spec.summary = "Nothing moves";
    spec.ports = {advances("x", "vector:*:*", "what rests"), reads("other", "vector:1:m", "looked at").optional()};
    spec.fields = {{"wx", "rad/s", FieldKind::rate, false, false, "angular rate"}};
    spec.parameters = {parameter::vector("q", "@x/sqrt(s)").sized_by("x").at_least(0).required().about("noise")};
    return spec;
  }
  explicit Rest(const Binding&) {}
};

}  // namespace loader_test
