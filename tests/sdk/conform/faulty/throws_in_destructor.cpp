// SPDX-License-Identifier: Apache-2.0
// Throws in its destructor.
// fails: life.create crash
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  ~Animal() override { throw_something(); }

 private:
  static void throw_something() { throw 7; }
};

}  // namespace

BINNACLE_PLUGIN("throws_in_destructor", "1.0.0", registry) { registry.add<Animal>(); }
