// SPDX-License-Identifier: Apache-2.0
// Throws in its destructor.
// fails: life.create crash
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  ~Subject() override { throw_something(); }

 private:
  static void throw_something() { throw 7; }
};

}  // namespace

BINNACLE_PLUGIN("throws_in_destructor", "1.0.0", registry) { registry.add<Subject>(); }
