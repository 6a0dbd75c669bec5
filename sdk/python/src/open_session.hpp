// SPDX-License-Identifier: Apache-2.0
// A Session with what Python's calls need of it: names found without a search, and one thread at a time.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "binnacle/session.hpp"
#include "convert.hpp"

namespace binnacle::python {

/// How much a sample of a channel holds.
struct SampleShape {
  std::string name;
  std::vector<std::string> fields, row_fields, covariance;  // names, in the order of a sample's numbers
  int max_rows = 0;
};

struct OpenSession {
  OpenSession(std::shared_ptr<const Composition> composition, std::uint64_t seed, int run, Estimates estimates);

  /// Throw KeyError with the nearest name.
  int channel(std::string_view name);
  BlockId block(std::string_view name);
  MeasurementId measurement(std::string_view name);
  /// The only one where the name is empty.
  FilterId filter(std::string_view name) const;

  Session session;
  std::vector<SampleShape> shapes;  // by channel
  std::vector<double> numbers;      // room for one sample's that do not lie as the kernel reads them
  bool is_busy = false;             // read and written by who holds the GIL

 private:
  std::unordered_map<std::string, int> channels_;
  std::unordered_map<std::string, BlockId> blocks_;
};

/// For the time of a call. A session that is in a call refuses another (RuntimeError): of a thread, while the GIL is
/// released, or of a model in Python that the call came to.
class Busy {
 public:
  explicit Busy(OpenSession& session) : session_(session) {
    if (session.is_busy) refuse();
    session.is_busy = true;
  }
  ~Busy() { session_.is_busy = false; }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  [[noreturn]] static void refuse();

  OpenSession& session_;
};

}  // namespace binnacle::python
