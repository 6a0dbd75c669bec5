// SPDX-License-Identifier: Apache-2.0
// A team whose messages go through MPI.
#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include <mpi.h>

#include "study/team.hpp"

namespace binnacle::study {

namespace {

constexpr int tag = 9;

using std::chrono::milliseconds;

/// Ends the process when a call of MPI that cannot be bounded takes too long. Time in which all was stopped, as by a batch
/// system, does not count.
class Alarm {
 public:
  Alarm(milliseconds longest, void (*give_up)(const char* message), std::string message)
      : thread_([this, longest, give_up, message] {
          constexpr milliseconds step{100};
          std::unique_lock lock(mutex_);
          for (auto left = longest; left > milliseconds(0); left -= step)
            if (changed_.wait_for(lock, std::min(left, step), [this] { return is_off_; })) return;
          give_up(message.c_str());
        }) {}
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;
  ~Alarm() {
    {
      const std::lock_guard lock(mutex_);
      is_off_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_off_ = false;
  std::thread thread_;
};

std::string in_seconds(milliseconds time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::seconds>(time).count()) + " s";
}

class MpiTeam final : public Team {
 public:
  MpiTeam(milliseconds longest, void (*give_up)(const char* message)) : longest_(longest), give_up_(give_up) {
    const Alarm alarm(longest, give_up,
                      "the ranks did not connect to each other within " + in_seconds(longest) +
                          "; one of them, or its machine, may be stopped");
    int given = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &given);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    MPI_Comm here = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
    MPI_Comm_size(here, &size_here_);
    MPI_Comm_free(&here);
    std::array<char, MPI_MAX_PROCESSOR_NAME> name{};
    int length = 0;
    MPI_Get_processor_name(name.data(), &length);
    machine_.assign(name.data(), static_cast<std::size_t>(length));
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int size_here() const override { return size_here_; }
  std::string machine() const override { return machine_; }

  void send(int to, std::string text) override {
    forget_sent();
    auto& sent = sent_.emplace_back(Sent{std::move(text), MPI_REQUEST_NULL});
    MPI_Isend(sent.text.data(), static_cast<int>(sent.text.size()), MPI_CHAR, to, tag, MPI_COMM_WORLD, &sent.request);
  }

  std::optional<Message> receive() override {
    forget_sent();
    begin_to_receive();
    // Of one sender in the order in which they were sent; one that is stopped in the middle of a message holds up no other.
    for (auto message = coming_.begin(); message != coming_.end(); ++message) {
      const bool is_first = std::none_of(coming_.begin(), message, [&](const Coming& earlier) {
        return earlier.message.from == message->message.from;
      });
      if (!is_first || !is_through(message->request)) continue;
      std::optional<Message> whole(std::move(message->message));
      coming_.erase(message);
      return whole;
    }
    return std::nullopt;
  }

  bool leave(milliseconds longest) override {
    // What others still send is taken in, though nobody waits for it, so that they come to an end too.
    const auto take_in_until = [&](const auto& is_done) {
      constexpr milliseconds pause{1};
      for (; !is_done(); longest -= pause) {
        if (longest <= milliseconds(0)) return false;
        while (receive()) {
        }
        std::this_thread::sleep_for(pause);
      }
      return true;
    };
    if (!take_in_until([this] { return sent_.empty(); })) return false;
    MPI_Request barrier = MPI_REQUEST_NULL;
    MPI_Ibarrier(MPI_COMM_WORLD, &barrier);
    if (!take_in_until([&barrier] { return is_through(barrier); })) return false;
    const Alarm alarm(longest_, give_up_,
                      "the ranks did not end together within " + in_seconds(longest_) +
                          "; one of them, or its machine, may be stopped");
    MPI_Finalize();
    return true;
  }

 private:
  struct Sent {
    std::string text;
    MPI_Request request;
  };
  struct Coming {
    Message message;
    MPI_Request request;
  };
  static bool is_through(MPI_Request& request) {
    int is_it = 0;
    MPI_Test(&request, &is_it, MPI_STATUS_IGNORE);
    return is_it != 0;
  }
  void forget_sent() {
    sent_.remove_if([](Sent& sent) { return is_through(sent.request); });
  }
  void begin_to_receive() {
    int has_arrived = 0;
    MPI_Message handle = MPI_MESSAGE_NULL;
    MPI_Status status;
    MPI_Improbe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &has_arrived, &handle, &status);
    if (!has_arrived) return;
    int length = 0;
    MPI_Get_count(&status, MPI_CHAR, &length);
    auto& coming = coming_.emplace_back(
        Coming{{status.MPI_SOURCE, std::string(static_cast<std::size_t>(length), '\0')}, MPI_REQUEST_NULL});
    MPI_Imrecv(coming.message.text.data(), length, MPI_CHAR, &handle, &coming.request);
  }

  milliseconds longest_;
  void (*give_up_)(const char* message);
  int rank_ = 0, size_ = 1, size_here_ = 1;
  std::string machine_;
  std::list<Sent> sent_;
  std::list<Coming> coming_;
};

}  // namespace

}  // namespace binnacle::study

/// Called once by the command, which never unloads this. Named after the interface it makes.
extern "C" __attribute__((visibility("default"))) binnacle::study::Team* binnacle_join_team_2(
    std::chrono::milliseconds longest, void (*give_up)(const char* message)) {
  return std::make_unique<binnacle::study::MpiTeam>(longest, give_up).release();
}
