// SPDX-License-Identifier: Apache-2.0
// The thread that sends.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "address/descriptor.hpp"
#include "destination.hpp"
#include "line_ring.hpp"

namespace binnacle::text_output {

/// Lines are handed over without a lock, and all that may wait is done by its thread.
class Worker {
 public:
  struct Warning {
    const char* code;
    std::string message;
  };

  /// Throws std::runtime_error where the address cannot be opened.
  Worker(const address::Address& address, std::size_t buffer);
  /// What still waits is lost.
  ~Worker();

  /// Neither waits nor allocates.
  void add(std::string_view line) noexcept;
  /// Sends what waits, until the receiver has read nothing for a while, and concludes.
  void finish();

  bool has_warnings() const noexcept { return has_warnings_.load(std::memory_order_acquire); }
  std::vector<Warning> take_warnings();

 private:
  enum class Stage { runs, finishes, leaves };

  void run();
  void distribute();
  void rest(Clock::time_point until);
  void wake() noexcept;
  void stop(Stage stage);

  LineRing ring_;
  address::Descriptor bell_;  // an eventfd
  Clock::duration patience_;  // with a receiver that does not read at the end
  std::atomic<bool> sleeps_ = false;
  std::atomic<Stage> stage_ = Stage::runs;
  std::int64_t overrun_ = 0;  // lines for which the ring had no room

  std::mutex mutex_;  // of warnings_
  std::vector<Warning> warnings_;
  std::atomic<bool> has_warnings_ = false;

  std::unique_ptr<Destination> destination_;
  std::string lines_;
  std::vector<pollfd> descriptors_;
  std::thread thread_;
};

}  // namespace binnacle::text_output
