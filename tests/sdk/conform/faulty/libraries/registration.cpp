// SPDX-License-Identifier: Apache-2.0
// A healthy library, the control. In copies of it faulty_check.py alters its guard, its list of types, its dynamic section,
// or what it registers: all healthy types, the process alone, or what a fault of the folder ../registration registers.
#include <string>

#include "../faulty.hpp"
#include "faulty_registration.hpp"

namespace {

// Read when it registers, from the file that a copy may differ in.
const volatile char registers[48] = "registers:all";

std::string chosen() {
  std::string text;
  for (const volatile char* c = registers; *c != '\0'; ++c) text += *c;
  return text.substr(text.find(':') + 1);
}

}  // namespace

BINNACLE_TYPES("process measurement derived block noise source transform");
BINNACLE_PLUGIN("registration", "1.0.0", registry) {
  const std::string name = chosen();
  if (name == "all") faulty::register_all(registry);
  if (name == "process") registry.add<faulty::Process>();
  for (const faulty::Fault& fault : faulty::registration)
    if (name == fault.name) fault.add(registry);
}
