// SPDX-License-Identifier: Apache-2.0
// Its version is no version.
// fails: metadata.version
#include "faulty.hpp"

BINNACLE_PLUGIN("odd_version", "newest", registry) { registry.add<faulty::Process>(); }
