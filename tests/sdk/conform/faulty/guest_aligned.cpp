// SPDX-License-Identifier: Apache-2.0
// Another Eigen alignment: accepted, for no owning Eigen object crosses, with a warning.
// fails: load.guard warn
#include "faulty.hpp"

BINNACLE_PLUGIN("guest_aligned", "1.0.0", registry) { faulty::register_all(registry); }
