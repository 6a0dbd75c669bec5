// SPDX-License-Identifier: Apache-2.0
// Team: the processes that carry out one study together, as mpirun started them.
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace binnacle::study {

struct Message {
  int from = 0;
  std::string text;
};

/// Passes messages. One thread of a process makes all calls, and none of them waits but leave(), which has a limit.
class Team {
 public:
  virtual ~Team() = default;
  /// 0 leads.
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// How many of them share this machine.
  virtual int size_here() const = 0;
  virtual std::string machine() const = 0;

  /// Messages of one process to another arrive in the order in which they were sent.
  virtual void send(int to, std::string text) = 0;
  /// What arrived, if anything.
  virtual std::optional<Message> receive() = 0;
  /// Once all have called it, it returns, and all that was sent has arrived. False where somebody has not come within
  /// `longest`.
  virtual bool leave(std::chrono::milliseconds longest) = 0;
};

/// What the MPI module exports as binnacle_join_team_2: joins the others. When that, or MPI's own end, takes longer than
/// `longest`, it calls `give_up`, which ends the process with that message.
using JoinTeam = Team* (*)(std::chrono::milliseconds longest, void (*give_up)(const char* message));

}  // namespace binnacle::study
