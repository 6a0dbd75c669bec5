// SPDX-License-Identifier: Apache-2.0
// The library of all types at fault, one for each source of the folder above.
#include "../faulty.hpp"
#include "faulty_types.hpp"

BINNACLE_PLUGIN("faulty", "1.0.0", registry) {
  for (const faulty::Fault& fault : faulty::types) fault.add(registry);
}
