// SPDX-License-Identifier: Apache-2.0
// open() throws what it should not: an exception of its own, whose text is gone with the library.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Trouble final : public std::exception {
 public:
  const char* what() const noexcept override { return "trouble of its own"; }
};

class Subject final : public faulty::Source {
 public:
  using Source::Source;
  void open(binnacle::Reporter&) override { throw Trouble(); }
};

}  // namespace

BINNACLE_PLUGIN("open_throws", "1.0.0", registry) { registry.add<Subject>(); }
