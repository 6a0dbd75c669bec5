// SPDX-License-Identifier: Apache-2.0
// A study carried out by a team gives what one process gives; here the team are threads that pass notes.
#include "catch.hpp"

#include <cstring>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "drive_study.hpp"
#include "study/coordinator.hpp"
#include "study/summary.hpp"

namespace coordinator_test {

using namespace binnacle::test;
namespace study = binnacle::study;
using namespace std::chrono_literals;

namespace {

/// The letter boxes of all, and who has left.
struct Office {
  explicit Office(int size) : boxes(static_cast<std::size_t>(size)) {}
  std::mutex mutex;
  std::vector<std::deque<study::Message>> boxes;
  std::atomic<int> gone{0}, reports{0};
};

class Member final : public study::Team {
 public:
  Member(Office& office, int rank) : office_(office), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return static_cast<int>(office_.boxes.size()); }
  int size_here() const override { return size(); }
  std::string machine() const override { return "box" + std::to_string(rank_); }
  void send(int to, std::string text) override {
    const std::lock_guard lock(office_.mutex);
    if (text.starts_with(R"(["report")")) ++office_.reports;
    office_.boxes[static_cast<std::size_t>(to)].push_back({rank_, std::move(text)});
  }
  std::optional<study::Message> receive() override {
    const std::lock_guard lock(office_.mutex);
    auto& box = office_.boxes[static_cast<std::size_t>(rank_)];
    if (box.empty()) return std::nullopt;
    auto message = std::move(box.front());
    box.pop_front();
    return message;
  }
  bool leave(std::chrono::milliseconds longest) override {
    ++office_.gone;
    const auto begin = std::chrono::steady_clock::now();
    while (office_.gone < size()) {
      if (std::chrono::steady_clock::now() - begin > longest) return false;
      std::this_thread::sleep_for(1ms);
    }
    return true;
  }

 private:
  Office& office_;
  int rank_;
};

study::Study load(const Workbench& bench, std::uint64_t seed = 7) {
  study::StudyOptions options;
  options.load.sets = {"/plugins=[\"" BINNACLE_TEST_PLUGINS "\"]"};
  options.runs = 5;
  options.seed = seed;
  return study::Study::load(bench.path("drive.json"), options);
}

study::Results open_results(const study::Study& study) {
  return {study.variants().size(), static_cast<std::size_t>(study.runs())};
}

bool always() { return true; }
void ignore(std::size_t, std::size_t, const study::Figures&) {}

/// A rank other than 0, at work in a thread.
struct Server {
  Server(Office& office, int rank, std::function<study::Study()> read, std::function<bool()> goes_on = always)
      : thread([this, &office, rank, read, goes_on] {
          Member member(office, rank);
          was_dismissed = study::serve(member, read, 2, goes_on, {10ms, 10s});
        }) {}
  ~Server() {
    if (thread.joinable()) thread.join();
  }
  bool was_dismissed = false;
  std::thread thread;
};

std::string text_of(const study::Study& study, const study::Results& results) {
  return study::runs_csv(study, results) + study::summarize(study, results).dump();
}

}  // namespace

TEST_CASE("a team gives the figures of one process, whoever does which run") {
  const Workbench bench;
  write_drive(bench);
  const auto study = load(bench);
  auto alone = open_results(study);
  study::carry_out_all(study, alone, 1, always, ignore);

  Office office(3);
  Member first(office, 0);
  auto together = open_results(study);
  std::size_t entered = 0;
  {
    Server second(office, 1, [&] { return load(bench); }), third(office, 2, [&] { return load(bench); });
    study::Coordinator coordinator(first);
    REQUIRE(coordinator.assemble(study, always));
    coordinator.carry_out_all(study, together, 1, always, [&](auto, auto, const auto&) { ++entered; });
    coordinator.dismiss();
    second.thread.join();
    third.thread.join();
    CHECK(second.was_dismissed);
    CHECK(third.was_dismissed);
  }
  CHECK(entered == 20);
  CHECK(text_of(study, together) == text_of(study, alone));
}

TEST_CASE("what a run left undone in the results is all that a team does") {
  const Workbench bench;
  write_drive(bench);
  const auto study = load(bench);
  auto results = open_results(study);
  int done = 0;
  study::carry_out_all(
      study, results, 1, [&] { return done < 13; }, [&](auto, auto, const auto&) { ++done; });
  REQUIRE(done == 16);  // the variants of a run end together
  for (const std::size_t variant : {0u, 2u, 3u}) results.at(variant, 3) = {};
  done = 13;
  Office office(2);
  Member first(office, 0);
  const Server second(office, 1, [&] { return load(bench); });
  study::Coordinator coordinator(first);
  REQUIRE(coordinator.assemble(study, always));
  coordinator.carry_out_all(study, results, 1, always, [&](auto, auto, const auto&) { ++done; });
  CHECK(done == 20);
}

TEST_CASE("a rank with another study, or none, is refused by name") {
  const Workbench bench;
  write_drive(bench);
  const auto study = load(bench);
  const auto refusal = [&](std::function<study::Study()> other) -> std::pair<int, std::string> {
    Office office(3);
    Member first(office, 0);
    const Server second(office, 1, [&] { return load(bench); }), third(office, 2, other);
    study::Coordinator coordinator(first);
    try {
      coordinator.assemble(study, always);
    } catch (const binnacle::Error& error) {
      return {error.exit_status(), error.what()};
    }
    return {0, ""};
  };
  CHECK(refusal([&] { return load(bench); }).second.empty());
  CHECK(refusal([&] { return load(bench, 8); }) ==
        std::pair<int, std::string>{2, "rank 2 on box2: error: its seed is another than that of rank 0"});
  const Workbench other;
  write_drive(other);
  other.write("drive.json",
              read_file(other.path("drive.json")).replace(read_file(other.path("drive.json")).find("30 deg"), 2, "31"));
  CHECK(refusal([&] { return load(other); }).second ==
        "rank 2 on box2: error: its config is another than that of rank 0");
  const auto unread = refusal([&] {
    study::StudyOptions options;
    return study::Study::load(bench.path("nowhere.json"), options);
  });
  CHECK(unread.first == 3);
  CHECK(unread.second.starts_with("rank 2 on box2: error: it cannot read the study: "));
}

TEST_CASE("a rank that falls silent is reported, and what the others did is kept") {
  const Workbench bench;
  write_drive(bench);
  const auto study = load(bench);
  auto results = open_results(study);
  Office office(2);
  Member first(office, 0);
  const auto begin = std::chrono::steady_clock::now();
  // Reports, and gives no further sign once rank 0 has done one: a killed one that nobody has noticed.
  std::atomic<int> done{0};
  const Server second(
      office, 1, [&] { return load(bench); }, [&] { return office.reports == 0 || done == 0; });
  study::Coordinator coordinator(first, {10ms, 300ms});
  REQUIRE(coordinator.assemble(study, always));
  std::string error;
  try {
    coordinator.carry_out_all(study, results, 1, always, [&](auto, auto, const auto&) { ++done; });
  } catch (const binnacle::Error& thrown) {
    error = thrown.what();
  }
  CHECK(error.starts_with("rank 1 on box1: error: no message for 0 s"));
  CHECK(done >= 1);   // its own; how many is a matter of time
  CHECK(done <= 16);  // less what was handed to the other
  CHECK(std::chrono::steady_clock::now() - begin < 20s);
}

TEST_CASE("a rank that is stopped before it has read its study is reported") {
  const Workbench bench;
  write_drive(bench);
  const auto study = load(bench);
  Office office(3);
  Member first(office, 0);
  const Server second(office, 1, [&] { return load(bench); });  // of rank 2 nothing comes
  const auto begin = std::chrono::steady_clock::now();
  study::Coordinator coordinator(first, {10ms, 1500ms});
  std::string error;
  try {
    coordinator.assemble(study, always);
  } catch (const binnacle::Error& thrown) {
    error = thrown.what();
  }
  CHECK(error == "rank 2: error: no message for 1 s, so it is considered dead; it has not read its study");
  CHECK(std::chrono::steady_clock::now() - begin < 20s);
  first.send(1, R"(["over"])");
  office.gone = 2;
}

TEST_CASE("a rank that takes long to read its study is waited for, and so is rank 0") {
  const Workbench bench;
  write_drive(bench);
  Office office(2);
  Member first(office, 0);
  const auto slow = [&] {
    std::this_thread::sleep_for(3s);
    return load(bench);
  };
  for (const bool is_first_slow : {true, false}) {
    office.gone = 0;
    bool was_dismissed = false;
    std::string error;
    std::thread second([&] {
      Member member(office, 1);
      try {
        const std::function<study::Study()> quick = [&] { return load(bench); };
        was_dismissed = study::serve(member, is_first_slow ? quick : slow, 1, always, {10ms, 1500ms});
      } catch (const binnacle::Error& thrown) {
        error = thrown.what();
      }
    });
    {
      study::Coordinator coordinator(first, {10ms, 1500ms});
      const auto study = coordinator.load([&] { return is_first_slow ? slow() : load(bench); });
      CHECK(coordinator.assemble(study, always));
      CHECK(coordinator.dismiss());
    }
    second.join();
    CHECK(was_dismissed);
    CHECK(error == "");
  }
}

TEST_CASE("rank 0 that is stopped is reported by the others, loading and at work") {
  const Workbench bench;
  write_drive(bench);
  for (const bool gets_work : {false, true}) {
    Office office(2);
    Member first(office, 0), second(office, 1);
    if (gets_work) first.send(1, R"(["runs", [[[0], 0]]])");
    const auto begin = std::chrono::steady_clock::now();
    std::string error;
    try {
      study::serve(second, [&] { return load(bench); }, 1, always, {10ms, 1500ms});
    } catch (const binnacle::Error& thrown) {
      error = thrown.what();
    }
    CHECK(error == "rank 0: error: no message for 1 s, so it is considered dead");
    CHECK(std::chrono::steady_clock::now() - begin < 20s);
  }
}

TEST_CASE("a rank that does not leave holds rank 0 up no longer than a time-out") {
  Office office(2);
  Member first(office, 0);
  study::Coordinator coordinator(first, {10ms, 300ms});
  CHECK_FALSE(coordinator.dismiss());
}

TEST_CASE("what cannot be entered ends the work of all") {
  const Workbench bench;
  write_drive(bench);
  const auto study = load(bench);
  auto results = open_results(study);
  Office office(2);
  Member first(office, 0);
  Server second(office, 1, [&] { return load(bench); });
  {
    study::Coordinator coordinator(first);
    REQUIRE(coordinator.assemble(study, always));
    CHECK_THROWS_AS(coordinator.carry_out_all(study, results, 1, always,
                                              [](auto, auto, const auto&) { throw std::runtime_error("disk full"); }),
                    std::runtime_error);
  }
  second.thread.join();
  CHECK(second.was_dismissed);
}

}  // namespace coordinator_test
