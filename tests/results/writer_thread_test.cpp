// SPDX-License-Identifier: Apache-2.0
// WriterThread: the order of tasks, how much may wait, and what becomes of failures.
#include "results/writer_thread.hpp"

#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>
#include <vector>

#include "catch.hpp"

namespace writer_thread_test {

using binnacle::results::WriterThread;

namespace {

/// A task that waits until it is let go.
class Gate {
 public:
  void open() { promise_.set_value(); }
  auto task() {
    return [future = promise_.get_future().share()] { future.wait(); };
  }

 private:
  std::promise<void> promise_;
};

}  // namespace

TEST_CASE("tasks are carried out in their order, on another thread, and finish waits for them") {
  WriterThread writer;
  std::vector<int> order;
  std::thread::id worker;
  for (int i = 0; i < 1000; ++i)
    writer.post(1, [&, i] {
      worker = std::this_thread::get_id();
      order.push_back(i);
    });
  writer.finish();
  REQUIRE(order.size() == 1000);
  for (int i = 0; i < 1000; ++i) CHECK(order[static_cast<std::size_t>(i)] == i);
  CHECK(worker != std::this_thread::get_id());
}

TEST_CASE("post waits only where too much waits already, and a task of any size is taken by itself") {
  WriterThread writer(100);
  Gate gate;
  writer.post(1000, gate.task());
  std::atomic<int> posted = 0;
  std::thread run([&] {
    writer.post(60, [] {});
    ++posted;
    writer.post(60, [] {});
    ++posted;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK(posted == 0);
  gate.open();
  run.join();
  CHECK(posted == 2);
  writer.finish();
}

TEST_CASE("what a task throws comes out of post and finish from then on, and no task follows it") {
  WriterThread writer;
  bool is_carried_out = false;
  Gate gate;
  writer.post(1, gate.task());
  writer.post(1, [] { throw std::runtime_error("no space left"); });
  writer.post(1, [&] { is_carried_out = true; });
  gate.open();
  for (int i = 0; i < 2; ++i) CHECK_THROWS_WITH(writer.finish(), "no space left");
  CHECK_THROWS_WITH(writer.post(1, [&] { is_carried_out = true; }), "no space left");
  CHECK_FALSE(is_carried_out);
}

TEST_CASE("a run that waits for a full queue learns of a failure there") {
  WriterThread writer(10);
  Gate gate;
  writer.post(10, gate.task());
  auto thrown = std::async(std::launch::async, [&]() -> std::string {
    try {
      writer.post(10, [] { throw std::runtime_error("no space left"); });
      writer.post(10, [] {});
      writer.post(10, [] {});
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  });
  gate.open();
  CHECK(thrown.get() == "no space left");
}

TEST_CASE("a run that breaks while its queue is full drops what waits, and ends") {
  int carried_out = 0;
  Gate gate;
  std::thread opener;
  try {
    WriterThread writer(100);
    writer.post(50, gate.task());
    writer.post(50, [&] { ++carried_out; });
    opener = std::thread([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      gate.open();
    });
    throw std::runtime_error("of the filter");
  } catch (const std::runtime_error& error) {
    CHECK(std::string(error.what()) == "of the filter");
  }
  opener.join();
  CHECK(carried_out == 0);
}

}  // namespace writer_thread_test
