// SPDX-License-Identifier: Apache-2.0
// testing::bind(): parameters are read as the kernel reads them, ports are blocks of the test, types are classes or registered.
#include "binnacle/bind.hpp"

#include <map>
#include <stdexcept>
#include <string>

#include "../../plugins/core/linear_measurement.hpp"
#include "../../plugins/core/random_walk.hpp"
#include "binnacle/kind_blocks.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"
#include "robust/robust_noise.hpp"

namespace bind_test {

using namespace binnacle;
using namespace binnacle::testing;

namespace {

const AdditiveKind position(2, "m");

/// A measurement of both components, in 20 cm.
Setup of_both(const char* parameters = R"({"sigma": ["20 cm"]})") {
  return {parameters, {{"x", &position}}, {"z2", "z3", "z4", "z5", "z6", "z7"}};
}

Eigen::MatrixXd R_of(const MeasurementModel& model, const ComponentSpec& spec) {
  const double fields[] = {3, 4, 0, 0, 0, 0, 0, 0};
  SampleView sample;
  sample.t = 0;
  sample.fields = fields;
  sample.available = true;
  const MeasurementCaller caller(model, spec);
  const Measured m = caller.linearize({sample}, {{&position, {3, 4}, 1.0}, {}}, caller.fresh_memory());
  REQUIRE(m.result);
  return m.R;
}

/// Pointer and words of the error; "" where it is bound.
template <class Component>
std::string refusal_of(const Setup& setup) {
  try {
    bind<Component>(setup);
  } catch (const ComponentError& error) {
    return error.pointer() + ": " + error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("bind reads units and fills in defaults as the kernel does") {
  const ComponentSpec spec = core::RandomWalk::spec();
  const ParameterValue value = read_parameters(spec, {R"~({"q": "2 cm/sqrt(s)"})~", {{"x", &position}}});
  REQUIRE(value.members.size() == spec.parameters.size());
  const auto q = Parameters(value).vector("q");
  REQUIRE(q.size() == 2);  // by the block on the port
  CHECK(q[0] == 0.02);
  CHECK(q[1] == 0.02);
}

TEST_CASE("bind reports what the kernel refuses, at its pointer") {
  using core::RandomWalk;
  const std::map<std::string, const StateBlock*> ports{{"x", &position}};
  CHECK(refusal_of<RandomWalk>({R"({"q": 0.1})", ports}) == "");
  CHECK(refusal_of<RandomWalk>({R"({"q": "0.1 m"})", ports}).starts_with("/q: "));
  CHECK(refusal_of<RandomWalk>({R"({"q": -0.1})", ports}).starts_with("/q: "));
  CHECK(refusal_of<RandomWalk>({R"({"q": [1, 2, 3]})", ports}).starts_with("/q: "));
  CHECK(refusal_of<RandomWalk>({R"({"q": 0.1, "p": 1})", ports}).starts_with("/p: unknown key of 'random_walk'"));
  CHECK(refusal_of<RandomWalk>({"{}", ports}) != "");
  CHECK(refusal_of<RandomWalk>({"{", ports}) != "");
  const std::string both = refusal_of<RandomWalk>({R"({"q": -0.1, "p": 1})", ports});
  CHECK(both.find("'q' is -0.1") != std::string::npos);
  CHECK(both.find("unknown key") != std::string::npos);
}

TEST_CASE("bind refuses a port that is not declared, and an open one that is required") {
  CHECK_THROWS_AS(bind<core::RandomWalk>({R"({"q": 0.1})", {{"x", &position}, {"y", &position}}}), std::logic_error);
  CHECK_THROWS_AS(bind<core::RandomWalk>({R"({"q": 0.1})", {}}), std::logic_error);
}

TEST_CASE("a class and a registered type are bound alike") {
  const Catalog catalog = types_of([](Registry& registry) {
    registry.add<core::LinearMeasurement>();
    registry.add<robust::Huber>();
  });
  const auto of_class = bind<core::LinearMeasurement>(of_both());
  const auto registered = bind<MeasurementModel>(catalog, "linear_measurement", of_both());
  const ComponentSpec& spec = type_of(catalog, Role::measurement_model, "linear_measurement").spec;
  CHECK(R_of(*of_class, spec).isApprox(0.04 * Eigen::Matrix2d::Identity(), 1e-15));
  CHECK(R_of(*registered, spec) == R_of(*of_class, spec));

  CHECK_THROWS_AS(bind<MeasurementModel>(catalog, "linear", of_both()), std::out_of_range);
  CHECK_THROWS_AS(bind<ProcessModel>(catalog, "linear_measurement", of_both()), std::out_of_range);
  CHECK_THROWS_AS(bind<MeasurementModel>(catalog, "linear_measurement", of_both(R"({"sigma": ["20 s"]})")),
                  ComponentError);
  const auto huber = bind<NoiseEstimator>(catalog, "huber", {.noise = {3, {{"rows", "m"}}}});
  CHECK(huber->declaration().memory_bytes ==
        bind<robust::Huber>({.noise = {3, {{"rows", "m"}}}})->declaration().memory_bytes);
}

TEST_CASE("a type of a plugin's library is bound by its name") {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(std::string(BINNACLE_TEST_PLUGINS) + "/core.so", diagnostics);
  REQUIRE_FALSE(diagnostics.has_errors());
  const auto block = bind<StateBlock>(catalog, "vector", {R"({"size": 3, "unit": "deg/h"})"});
  CHECK(block->declaration().dof() == 3);
  CHECK(block->declaration().kind == "vector:3:deg/h");
}

}  // namespace bind_test
