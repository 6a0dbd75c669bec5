// SPDX-License-Identifier: Apache-2.0
// It lists a type that it does not register, and lacks the one that it does.
// fails: load.register
#include "faulty.hpp"

BINNACLE_TYPES("nothing");
BINNACLE_PLUGIN("wrong_list", "1.0.0", registry) { registry.add<faulty::Process>(); }
