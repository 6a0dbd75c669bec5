// SPDX-License-Identifier: Apache-2.0
// Throws in its destructor.
// fails: life.create crash
#include "faulty.hpp"

namespace faulty::throws_in_destructor {

class Subject final : public Process {
 public:
  using Process::Process;
  ~Subject() override { throw_something(); }

 private:
  static void throw_something() { throw 7; }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("throws_in_destructor")); }

}  // namespace faulty::throws_in_destructor
