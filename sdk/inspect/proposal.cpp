// SPDX-License-Identifier: Apache-2.0
#include "inspect/inspect.hpp"
namespace binnacle::inspect {
Proposal propose(const Inspection&, const std::string&) { return {nullptr, "this is not built yet"}; }
}  // namespace binnacle::inspect
