// SPDX-License-Identifier: Apache-2.0
#include "worker.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>

#include <sys/eventfd.h>
#include <unistd.h>

namespace binnacle::text_output {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t least_ring = 256 * 1024;

/// How long a receiver may read nothing at the end. A program behind a pipe may still be starting.
Clock::duration patience_with(address::Kind kind) {
  return kind == address::Kind::standard_output || kind == address::Kind::file ? 10s : 1s;
}

/// Threads begun meanwhile get no signal: those of the process go to others, and a pipe without reader is a fault of write().
class WithoutSignals {
 public:
  WithoutSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~WithoutSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  WithoutSignals(const WithoutSignals&) = delete;
  WithoutSignals& operator=(const WithoutSignals&) = delete;

 private:
  sigset_t before_;
};

}  // namespace

Worker::Worker(const address::Address& address, std::size_t buffer)
    : ring_(std::max(least_ring, std::bit_ceil(buffer))),
      bell_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      patience_(patience_with(address.kind)) {
  if (!bell_) throw std::runtime_error(std::string("cannot be served: ") + std::strerror(errno));
  const Warn warn = [this](const char* code, std::string message) {
    const std::lock_guard lock(mutex_);
    warnings_.push_back({code, std::move(message)});
    has_warnings_.store(true, std::memory_order_release);
  };
  destination_ = address.kind == address::Kind::tcp_server ? make_server(address, buffer, warn)
                                                           : make_single(address, buffer, warn);
  const WithoutSignals guard;
  thread_ = std::thread([this] { run(); });
}

Worker::~Worker() { stop(Stage::leaves); }

void Worker::add(std::string_view line) noexcept {
  if (!ring_.push(line)) ++overrun_;
  if (sleeps_.load(std::memory_order_seq_cst)) wake();
}

void Worker::finish() {
  stop(Stage::finishes);
  destination_->conclude();
  if (overrun_ > 0) {
    const std::lock_guard lock(mutex_);
    warnings_.push_back(
        {"B145", std::to_string(overrun_) + " lines were lost before they could be sent: the machine was busy"});
    has_warnings_ = true;
  }
}

std::vector<Worker::Warning> Worker::take_warnings() {
  const std::lock_guard lock(mutex_);
  has_warnings_ = false;
  return std::exchange(warnings_, {});
}

void Worker::stop(Stage stage) {
  if (!thread_.joinable()) return;
  stage_ = stage;
  wake();
  thread_.join();
}

void Worker::wake() noexcept {
  sleeps_ = false;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(bell_.get(), &one, sizeof one);
}

void Worker::run() {
  auto deadline = Clock::time_point::max();
  std::size_t least = std::numeric_limits<std::size_t>::max();  // that waited since the end
  const pollfd* ready = nullptr;
  for (;;) {
    const Stage stage = stage_;
    if (stage == Stage::leaves) return;
    distribute();
    destination_->serve(ready);
    if (stage == Stage::finishes) {
      const std::size_t waiting = destination_->waiting();
      if (waiting < least) {
        least = waiting;
        deadline = Clock::now() + patience_;
      }
      if (waiting == 0 || Clock::now() >= deadline) return;
    }
    rest(deadline);
    ready = descriptors_.data() + 1;
  }
}

void Worker::distribute() {
  ring_.take(lines_);
  for (std::string_view rest = lines_; !rest.empty();) {
    const auto line = rest.substr(0, rest.find('\n') + 1);
    destination_->add(line);
    rest.remove_prefix(line.size());
  }
}

/// Until there are lines, or the destination has something to do.
void Worker::rest(Clock::time_point until) {
  descriptors_.clear();
  descriptors_.push_back({bell_.get(), POLLIN, 0});
  destination_->watch(descriptors_);
  until = std::min(until, destination_->wakes_at());
  int milliseconds = -1;
  if (until != Clock::time_point::max()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    milliseconds = static_cast<int>(std::clamp<std::int64_t>(left, 0, 60'000));
  }
  sleeps_ = true;
  if (!ring_.empty()) milliseconds = 0;
  ::poll(descriptors_.data(), descriptors_.size(), milliseconds);
  sleeps_ = false;
  std::uint64_t rings = 0;
  [[maybe_unused]] const auto count = ::read(bell_.get(), &rings, sizeof rings);
}

}  // namespace binnacle::text_output
