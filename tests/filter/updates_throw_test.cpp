// SPDX-License-Identifier: Apache-2.0
// A plugin that throws in the middle of an iteration, or at a sigma point, leaves x, P and the memories as they were; and nothing of
// it allocates.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "allocations.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "compose/composition_plan.hpp"
#include "filter/estimator.hpp"
#include "line.hpp"
#include "skip.hpp"

namespace updates_throw_test {

using namespace binnacle;
using namespace binnacle::internal::filter;

namespace {

std::string config(const std::string& update) {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}, "z2": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"pose": {"type": "curved_pose", "init": {"north": 1, "east": -2, "heading": 0.3}, "sigma": [8, 8, 0.5]}},
      "derived": {"tip": {"type": "curved_tip", "blocks": {"pose": "pose"}, "lever_arm": [6, 3]}},
      "process": {"keep": {"type": "random_constant", "blocks": {"x": "pose"}}},
      "measurements": {"see": {"type": "curved_ranges", "channel": "z", "blocks": {"tip": "tip"},
        "beacons": [[30, 5], [-10, 40], [-20, -35]], "sigma": 0.5, "update": )" +
         update + "}}}}}";
}

const double far_off[] = {25, 40, 55};

struct Fixture {
  explicit Fixture(const std::string& update)
      : composition(filter_tests::composition_of(config(update), CURVED_PLUGIN)) {
    const auto& layout = composition->plan().layout;
    memory.resize(layout.size() + Layout::alignment);
    void* begin = memory.data();
    std::size_t space = memory.size();
    arena = static_cast<std::byte*>(std::align(Layout::alignment, layout.size(), begin, space));
    estimator = std::make_unique<Estimator>(plan(), composition->plan().channels, arena, calls);
    estimator->reset();
    estimator->start(false);
  }
  const FilterPlan& plan() const { return composition->plan().filters[0]; }
  std::vector<std::byte> bytes() const { return {arena, arena + composition->plan().layout.size()}; }
  /// Up to the correction; what has been done is left as it is.
  void update() {
    const auto& see = plan().measurements[0];
    SampleView sample;
    sample.t = 0;
    sample.fields = far_off;
    const Driving now{0, nullptr};
    const Result seen = estimator->linearize(see, sample, now);
    REQUIRE(seen);
    const Judgement judged = estimator->judge(see, 0, 0, false);
    REQUIRE(judged.outcome == Outcome::accepted);
    before_iteration = bytes();
    if (see.update.type == UpdatePlan::Type::iterated) estimator->iterate(see, sample, now);
    estimator->correct(see);
  }

  std::shared_ptr<const Composition> composition;
  std::vector<std::byte> memory, before_iteration;
  std::byte* arena = nullptr;
  ModelCalls calls;
  std::unique_ptr<Estimator> estimator;
};

/// Lets the n-th call throw.
class Fuse {
 public:
  explicit Fuse(long calls) : left_(calls) {
    char address[32];
    std::snprintf(address, sizeof address, "%p", static_cast<void*>(&left_));
    ::setenv("CURVED_FUSE", address, 1);
  }
  Fuse(const Fuse&) = delete;
  Fuse& operator=(const Fuse&) = delete;
  ~Fuse() { ::unsetenv("CURVED_FUSE"); }

 private:
  long left_;
};

}  // namespace

TEST_CASE("what throws in the middle of an iterated or unscented update leaves x, P and memories as they were",
          "[updates]") {
  for (const char* update : {R"("iterated")", R"("unscented")"}) {
    CAPTURE(update);
    int thrown = 0;
    for (long call = 1;; ++call) {
      CAPTURE(call);
      Fixture f(update);
      const auto before = f.bytes();
      bool has_thrown = false;
      {
        const Fuse fuse(call);
        try {
          f.update();
        } catch (const std::runtime_error&) {
          has_thrown = true;
        }
      }
      if (!has_thrown) {
        CHECK(f.bytes() != before);
        break;
      }
      ++thrown;
      // The first call of the model itself is an ordinary linearization, whose memory the engine puts back.
      const bool is_plain = call <= 2;
      const bool is_correction = !f.before_iteration.empty() && f.bytes() == f.before_iteration;
      CHECK((is_plain || is_correction || f.bytes() == before));
      // The estimator works as before: values are read from the estimate again.
      Fixture fresh(update);
      f.estimator->roll_back(f.plan().measurements[0]);
      f.update();
      fresh.update();
      CHECK(std::memcmp(f.estimator->state(), fresh.estimator->state(), 3 * sizeof(double)) == 0);
      CHECK(f.estimator->covariance().as() == fresh.estimator->covariance().as());
    }
    CHECK(thrown > 10);
  }
}

TEST_CASE("the memory of models after an update is that of one call", "[updates]") {
  for (const char* update : {R"("ekf")", R"("iterated")", R"("unscented")"}) {
    Fixture f(update);
    f.update();
    const auto& place = f.plan().measurements[0].memory;
    long calls = 0;
    REQUIRE(place.count >= sizeof calls);
    std::memcpy(&calls, place.in(f.arena), sizeof calls);
    CHECK(calls == 1);
  }
}

TEST_CASE("iterated and unscented updates allocate nothing", "[updates]") {
  if (!conform::allocations_are_counted()) return test::skip("with this C library allocations can not be counted");
  for (const char* update : {R"("iterated")", R"("unscented")"}) {
    CAPTURE(update);
    Session session(filter_tests::composition_of(config(update), CURVED_PLUGIN));
    const auto channel = session.channel("z");
    session.push(channel, no_time, 0, far_off);
    const auto before = conform::allocations();
    for (Time t = 1; t < 50; ++t) session.push(channel, no_time, t, far_off);
    CHECK(conform::allocations() == before);
    CHECK(session.counts({{0}, 0}).by_outcome[0] == 50);
  }
}

}  // namespace updates_throw_test
