// SPDX-License-Identifier: Apache-2.0
// A team whose messages go through MPI.
#include <array>
#include <chrono>
#include <list>
#include <memory>
#include <thread>
#include <utility>

#include <mpi.h>

#include "study/team.hpp"

namespace binnacle::study {

namespace {

constexpr int tag = 9;

class MpiTeam final : public Team {
 public:
  MpiTeam() {
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
    int has_arrived = 0;
    MPI_Message handle = MPI_MESSAGE_NULL;
    MPI_Status status;
    MPI_Improbe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &has_arrived, &handle, &status);
    if (!has_arrived) return std::nullopt;
    int length = 0;
    MPI_Get_count(&status, MPI_CHAR, &length);
    Message message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(length), '\0')};
    MPI_Mrecv(message.text.data(), length, MPI_CHAR, &handle, MPI_STATUS_IGNORE);
    return message;
  }

  void leave() override {
    // What others still send is taken in, though nobody waits for it, so that they come to an end too.
    const auto take_in_until = [this](const auto& is_through) {
      while (!is_through()) {
        while (receive()) {
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    };
    take_in_until([this] { return sent_.empty(); });
    MPI_Request barrier = MPI_REQUEST_NULL;
    MPI_Ibarrier(MPI_COMM_WORLD, &barrier);
    take_in_until([&barrier] {
      int is_through = 0;
      MPI_Test(&barrier, &is_through, MPI_STATUS_IGNORE);
      return is_through != 0;
    });
    MPI_Finalize();
  }

 private:
  struct Sent {
    std::string text;
    MPI_Request request;
  };
  void forget_sent() {
    sent_.remove_if([](Sent& sent) {
      int is_through = 0;
      MPI_Test(&sent.request, &is_through, MPI_STATUS_IGNORE);
      return is_through != 0;
    });
  }

  int rank_ = 0, size_ = 1, size_here_ = 1;
  std::string machine_;
  std::list<Sent> sent_;
};

}  // namespace

}  // namespace binnacle::study

/// Called once by the command, which never unloads this. Named after the interface it makes.
extern "C" __attribute__((visibility("default"))) binnacle::study::Team* binnacle_join_team_1() {
  return std::make_unique<binnacle::study::MpiTeam>().release();
}
