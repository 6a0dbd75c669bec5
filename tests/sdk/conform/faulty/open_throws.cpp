// SPDX-License-Identifier: Apache-2.0
// open() throws what it should not: an exception of its own, whose text is gone with the library.
// fails: life.calls
#include "faulty.hpp"

namespace faulty::open_throws {

class Trouble final : public std::exception {
 public:
  const char* what() const noexcept override { return "trouble of its own"; }
};

class Subject final : public Source {
 public:
  using Source::Source;
  void open(Reporter&) override { throw Trouble(); }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("open_throws")); }

}  // namespace faulty::open_throws
