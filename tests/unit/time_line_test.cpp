// SPDX-License-Identifier: Apache-2.0
// The time line by itself: what it asks to be done, when, and with which part of the input.
#include "filter/time_line.hpp"

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "filter/model_calls.hpp"

namespace time_line_test {

using namespace binnacle;
using namespace binnacle::internal::filter;

namespace {

/// Writes down what is asked of it: "step 10 [0,10 r=1 i=4]", "measure 0 @ 12".
class Diary final : public TimeLine::Work {
 public:
  void start(Time t) override {
    say("start " + std::to_string(t));
    time->start(t);
  }
  void step(Time t1, std::span<const InputSample> samples) override {
    std::string text = "step " + std::to_string(t1);
    for (const auto& sample : samples) {
      text += " [" + std::to_string(sample.t0) + "," + std::to_string(sample.t1);
      text += " r=" + std::to_string(std::lround(sample.fields[0]));
      text += " i=" + std::to_string(std::lround(sample.fields[1])) + (sample.is_fragment() ? " cut]" : "]");
    }
    say(text);
    if (t1 == throws_at) throw std::runtime_error("no further");
  }
  void stepped() override {}
  void measure(int measurement, const SampleView& sample) override {
    say("measure " + std::to_string(measurement) + " @ " + std::to_string(sample.t) +
        " z=" + std::to_string(std::lround(sample.fields[0])));
  }
  void refuse(Outcome outcome, const char*) override { say("refuse " + std::to_string(static_cast<int>(outcome))); }
  void wait() override { say("wait"); }
  void resume(int measurement, Time t) override {
    say("resume " + std::to_string(measurement) + " @ " + std::to_string(t));
  }
  std::vector<std::string> take() { return std::exchange(said, {}); }

  TimeLine* time = nullptr;
  Time throws_at = no_time;

 private:
  void say(const std::string& text) { said.push_back(text); }
  std::vector<std::string> said;
};

using Said = std::vector<std::string>;

/// Input of a rate and an increment, measurements of one field.
struct Fixture {
  explicit Fixture(int samples_per_step = 1, bool has_input = true) {
    channels.resize(2);
    channels[0].epoch_fields = 2;
    channels[1].epoch_fields = 1;
    plan.measurements.resize(2);
    for (auto& measurement : plan.measurements) measurement.channel = 1;
    plan.input_channel = has_input ? 0 : -1;
    plan.input_fields = 2;
    plan.input_kinds = {FieldKind::rate, FieldKind::increment};
    plan.input_used = {1, 1};
    plan.samples_per_step = samples_per_step;
    plan.queue_doubles = 1;
    Layout layout;
    plan.head = layout.add<TimeHead>(1);
    plan.pending = layout.add<PendingInput>(as_size(samples_per_step + 1));
    plan.pending_fields = layout.add<double>(as_size(2 * (samples_per_step + 1)));
    plan.last_input = layout.add<double>(2);
    plan.driving_rates = layout.add<double>(2);
    plan.queue = layout.add<QueueEntry>(3);
    plan.queue_data = layout.add<double>(3);
    arena.resize(layout.size() + Layout::alignment);
    auto begin = reinterpret_cast<std::uintptr_t>(arena.data());
    begin = (begin + Layout::alignment - 1) / Layout::alignment * Layout::alignment;
    time = std::make_unique<TimeLine>(plan, channels, reinterpret_cast<std::byte*>(begin), diary);
    diary.time = time.get();
    time->reset();
  }
  Said input(Time t0, Time t1, double rate, double increment) {
    const double fields[] = {rate, increment};
    SampleView sample;
    sample.t0 = t0;
    sample.t = t1;
    sample.fields = fields;
    time->input(sample);
    return diary.take();
  }
  Said offer(int measurement, Time t, double z = 0) {
    SampleView sample;
    sample.t = t;
    sample.fields = &z;
    time->offer(measurement, sample);
    return diary.take();
  }

  const TimeHead& head() const { return std::as_const(*time).head(); }

  FilterPlan plan;
  std::vector<ChannelPlan> channels;
  std::vector<std::byte> arena;
  Diary diary;
  std::unique_ptr<TimeLine> time;
};

}  // namespace

TEST_CASE("a time line without values from channels starts where the first input interval begins") {
  Fixture f;
  CHECK(f.input(0, 10, 1, 4) == Said{"start 0", "step 10 [0,10 r=1 i=4]"});
  CHECK(f.head().t == 10);
  CHECK(f.head().steps == 1);
  REQUIRE(f.time->driving_rates());
  CHECK(f.time->driving_rates()[0] == 1);
  CHECK(std::abs(f.time->driving_rates()[1] - 4 / 10e-9) < 1);
}

TEST_CASE("whole samples wait for their group, a measurement inside one cuts it: increments by time, rates not") {
  Fixture f(2);
  CHECK(f.input(0, 10, 1, 4) == Said{"start 0"});
  CHECK(f.input(10, 20, 2, 6) == Said{"step 20 [0,10 r=1 i=4] [10,20 r=2 i=6]"});
  CHECK(f.input(20, 30, 3, 10).empty());
  CHECK(f.offer(0, 24, 9) == Said{"step 24 [20,24 r=3 i=4 cut]", "measure 0 @ 24 z=9"});
  CHECK(f.input(30, 40, 4, 8) == Said{"step 30 [24,30 r=3 i=6 cut]", "step 40 [30,40 r=4 i=8]"});
  CHECK(f.offer(0, 39) == Said{"refuse 2"});  // late
}

TEST_CASE("what is ahead of the input waits, by time and then by the order in the config, a full queue refuses") {
  Fixture f;
  f.input(0, 10, 1, 4);
  CHECK(f.offer(1, 14, 1) == Said{"wait"});
  CHECK(f.offer(1, 12, 2) == Said{"wait"});
  CHECK(f.offer(0, 14, 3) == Said{"wait"});
  CHECK(f.offer(0, 15, 4) == Said{"refuse 6"});
  CHECK(f.input(10, 20, 1, 10) == Said{"resume 1 @ 12", "step 12 [10,12 r=1 i=2 cut]", "measure 1 @ 12 z=2",
                                       "resume 0 @ 14", "step 14 [12,14 r=1 i=2 cut]", "measure 0 @ 14 z=3",
                                       "resume 1 @ 14", "measure 1 @ 14 z=1", "step 20 [14,20 r=1 i=6 cut]"});
}

TEST_CASE("a hole is bridged alone with the mean rates, and counted, what is not finite or goes back is left out") {
  Fixture f(2);
  f.input(0, 10, 1, 4);
  f.input(10, 20, 2, 6);
  CHECK(f.input(40, 50, 3, 8) == Said{"step 40 [20,40 r=2 i=12]"});
  CHECK(f.head().gaps == 1);
  CHECK(f.input(45, 48, 1, 1).empty());
  CHECK(f.input(50, 60, std::nan(""), 1).empty());
  CHECK(f.head().gaps == 3);
  CHECK(f.head().newest == 60);  // by which the verdict knows that the input has ended
  CHECK(f.head().input_end == 50);
  CHECK(f.input(50, 60, 4, 8) == Said{"step 60 [40,50 r=3 i=8] [50,60 r=4 i=8]"});
}

TEST_CASE("the first sample of increments without an interval stops the filter") {
  Fixture f;
  CHECK(f.input(no_time, 10, 1, 4) == Said{"start 10"});
  CHECK_THROWS_AS(f.input(no_time, 20, 1, 4), Stop);
}

TEST_CASE("without input the time line steps from measurement to measurement") {
  Fixture f(1, false);
  f.time->start(5);
  CHECK(f.offer(0, 5) == Said{"measure 0 @ 5 z=0"});
  CHECK(f.offer(0, 9) == Said{"step 9", "measure 0 @ 9 z=0"});
  CHECK(f.offer(0, 7) == Said{"refuse 2"});
}

TEST_CASE("after a step that throws, the queue can still be emptied: each sample once") {
  Fixture f;
  f.input(0, 10, 1, 4);
  f.offer(0, 12);
  f.offer(1, 13);
  f.diary.throws_at = 12;
  CHECK_THROWS(f.input(10, 20, 1, 4));
  CHECK(f.diary.take() == Said{"resume 0 @ 12", "step 12 [10,12 r=1 i=1 cut]"});  // the first is another's to close
  f.time->flush(Outcome::rejected, "");
  CHECK(f.diary.take() == Said{"resume 1 @ 13", "refuse 6"});
  CHECK(f.head().queued == 0);
}

}  // namespace time_line_test
