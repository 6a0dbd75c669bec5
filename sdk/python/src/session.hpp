// SPDX-License-Identifier: Apache-2.0
// Sessions: samples in, estimates out, snapshots.
#pragma once

#include <memory>

#include "open_session.hpp"

namespace binnacle::python {

/// Handles keep their session open.
struct Channel {
  std::shared_ptr<OpenSession> open;
  int index = 0;
};
struct Block {
  std::shared_ptr<OpenSession> open;
  BlockId id;
  std::size_t outputs = 0;
};

void bind_session(py::module_& module);
/// push() and add() of both classes, push_many().
void bind_push(py::handle session, py::handle channel, py::module_& module);

}  // namespace binnacle::python
