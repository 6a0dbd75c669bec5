// SPDX-License-Identifier: Apache-2.0
// The covariance that a measurement model asks for: of state blocks, of frozen components, of derived values.
#include <cmath>
#include <string>
#include <vector>

#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace read_covariance_test {

using namespace binnacle;

namespace {

/// A position that moves with its rate, of which the second component is frozen. `a` and `b` are what the model reads.
std::string knowing(const std::string& a, const std::string& b) {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z": {"unit": "1"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 2, "unit": "m", "init": {"x0": 3, "x1": 2}, "sigma": [1, 2]},
                 "v": {"type": "vector", "size": 2, "unit": "m/s", "sigma": [0.5, 0.3], "estimate": ["x0"]}},
      "derived": {"squared": {"type": "square", "blocks": {"x": "x"}}},
      "process": {"move": {"type": "integrated", "blocks": {"x": "x", "rate": "v"}},
                  "keep": {"type": "random_constant", "blocks": {"x": "v"}}},
      "measurements": {"know": {"type": "knowing", "channel": "z", "blocks": {"a": ")" +
         a + R"(", "b": ")" + b + R"("}}}}}})";
}

class KeepResidual : public StepObserver {
 public:
  void offered(const UpdateRecord& record) override {
    CHECK(record.outcome == Outcome::accepted);
    residual.assign(record.residual, record.residual + record.rows);
  }
  std::vector<double> residual;
};

/// P between a and b two seconds after the start, column by column. Nothing is learnt on the way: H is zero.
std::vector<double> covariance(const std::string& a, const std::string& b) {
  Session session = filter_tests::session_of(knowing(a, b));
  KeepResidual kept;
  session.attach(session.filter("f"), &kept);
  const double z[] = {0};
  for (const double t : {1.0, 3.0}) session.push(session.channel("z"), no_time, nanoseconds(t), z);
  CHECK(session.healthy(session.filter("f")));
  return kept.residual;
}

bool is_near(const std::vector<double>& found, const std::vector<double>& wanted) {
  if (found.size() != wanted.size()) return false;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (!(std::abs(found[i] - wanted[i]) < 1e-12)) return false;
  return true;
}

}  // namespace

TEST_CASE("a model that asks for it is given the covariance of what it reads") {
  CHECK(is_near(covariance("x", "x"), {1 + 0.25 * 4, 0, 0, 4}));
  CHECK(is_near(covariance("x", "v"), {0.25 * 2, 0, 0, 0}));  // v.x1 is frozen: 0
  CHECK(is_near(covariance("v", "x"), {0.25 * 2, 0, 0, 0}));
  CHECK(is_near(covariance("v", "v"), {0.25, 0, 0, 0}));
}

TEST_CASE("the covariance of a derived value is chained through its Jacobian") {
  // (x0², x0 x1) at (3, 2): J = [6, 0; 2, 3], P of x = diag(2, 4), P of x and v = [0.5, 0; 0, 0].
  CHECK(is_near(covariance("squared", "squared"), {36 * 2, 12 * 2, 12 * 2, 4 * 2 + 9 * 4}));
  CHECK(is_near(covariance("squared", "v"), {3, 1, 0, 0}));
  CHECK(is_near(covariance("x", "squared"), {6 * 2, 0, 2 * 2, 3 * 4}));
}

}  // namespace read_covariance_test
