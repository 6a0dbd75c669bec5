// SPDX-License-Identifier: Apache-2.0
// RunPage: the report's page of a run that goes on, for browsers.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "binnacle/session.hpp"
#include "binnacle/step_log.hpp"

namespace binnacle::live {

using Json = nlohmann::ordered_json;

/// An address that is none, or that cannot be served at. One line: what was found, what is expected.
class AddressError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Serves one page, and its data as server-sent events, from a thread of its own, for as long as it lives. begin() to
/// finished() are those of a score::RunObserver: they never wait for a browser, and while no page is open they read and
/// keep nothing. What a page shows begins with the first that was opened; counts and verdict are of the whole run.
class RunPage {
 public:
  /// `address`: [HOST:]PORT; the loopback unless a host is given; port 0: any free one. Throws AddressError.
  RunPage(const std::string& address, const Json& config, const Json& provenance);
  /// Open pages have a second to take what is left.
  ~RunPage();
  RunPage(const RunPage&) = delete;
  RunPage& operator=(const RunPage&) = delete;

  /// "http://127.0.0.1:8080/"
  std::string url() const;

  void begin_run(const Session& session);
  /// `next` sees the same step log; null: nobody.
  StepObserver* step_observer(int filter, StepObserver* next);
  void after_instant();
  void finished();
  /// The summary of the run, which is over: open pages show it, and stay as they are.
  void conclude(const Json& summary);

 private:
  struct Contents;
  std::unique_ptr<Contents> contents_;
};

}  // namespace binnacle::live
