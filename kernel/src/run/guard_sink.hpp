// SPDX-License-Identifier: Apache-2.0
// Calls into sinks: what escapes becomes an error that names the sink.
#pragma once

#include <utility>

#include "binnacle/diagnostic.hpp"
#include "compose/composition_plan.hpp"

namespace binnacle::runtime {

using namespace compose;

/// Throws DataError: a sink that cannot write ends the run.
template <class Call>
void guard_sink(const CompositionPlan& plan, const SinkPlan& sink, const char* call_name, Call&& call) {
  try {
    sink.type->guarded(call_name, std::forward<Call>(call));
  } catch (const ComponentError& error) {
    const bool in_data = error.is_data_error();
    throw DataError(Diagnostic{Severity::error, in_data ? error.code() : "B045",
                               in_data ? Origin{error.file(), error.line(), 0} : plan.document.origin(sink.pointer),
                               sink.pointer, error.what()});
  }
}

}  // namespace binnacle::runtime
