// SPDX-License-Identifier: Apache-2.0
// One receiver of lines, and what waits for it.
#pragma once

#include <string>
#include <string_view>

#include "address/descriptor.hpp"
#include "output/line_queue.hpp"

namespace binnacle::text_output {

class Connection {
 public:
  enum class Way { stream, stream_socket, datagrams };

  Connection(Way way, std::size_t buffer) : way_(way), queue_(buffer) {}

  /// Lines go there from now on; without a descriptor they wait.
  void attach(address::Descriptor descriptor);
  int descriptor() const { return descriptor_.get(); }
  bool is_open() const { return static_cast<bool>(descriptor_); }

  /// Where there is no room for it, what goes is sent before something is lost.
  void add(std::string_view line) {
    ++lines_;
    if (is_open() && !queue_.has_room(line.size())) fault_ = send();
    queue_.push(line);
  }
  /// What goes without waiting. "", or why no more goes there.
  std::string send();
  /// Of a stream: what the receiver sends is of no interest, but its end is. "", or that it has gone.
  std::string read_and_forget();
  /// Of datagrams: what the network said of one that was sent. "": nothing.
  std::string take_refusal();

  std::size_t waiting() const { return queue_.waiting().size(); }  // bytes
  std::int64_t lines() const { return lines_; }                    // that it was given
  std::int64_t lost() const { return queue_.lost(); }
  /// What still waits is lost too.
  std::int64_t unsent() const { return queue_.lost() + queue_.lines(); }

 private:
  std::string send_stream();
  std::string send_datagrams();

  Way way_;
  address::Descriptor descriptor_;
  LineQueue queue_;
  std::int64_t lines_ = 0;
  std::string fault_;  // found by add()
};

}  // namespace binnacle::text_output
