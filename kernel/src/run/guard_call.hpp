// SPDX-License-Identifier: Apache-2.0
// Calls into sources, transforms and sinks while a run goes on: what escapes becomes an error at the component's place
// that names plugin, component, call and sample.
#pragma once

#include <string>
#include <utility>

#include "binnacle/diagnostic.hpp"
#include "compose/composition_plan.hpp"

namespace binnacle::runtime {

/// "plugin 'csv', component 'csv': next at 12.3 s", for faults that are no exception.
inline std::string call_text(const ComponentType& type, const char* call_name, Time t) {
  CallSite site;
  site.enter(&type.plugin, type.spec.type, call_name);
  site.set_time(t);
  return site.text();
}

/// `component`: a SourcePlan, TransformPlan or SinkPlan. Throws RunError (DataError, FilterError): the run ends.
template <class RunError, class ComponentPlan, class Call>
auto guard_call(const compose::CompositionPlan& plan, const ComponentPlan& component, const char* call_name, Time t,
                Call&& call) {
  try {
    return component.type->guarded(call_name, std::forward<Call>(call), t);
  } catch (const ComponentError& error) {
    if (error.is_data_error())
      throw RunError(Diagnostic{Severity::error, error.code(), Origin{error.file(), error.line(), 0}, component.pointer,
                                error.what()});
    // A ComponentError that the component made itself does not say which call it came from.
    std::string message = error.what();
    if (const std::string who = call_text(*component.type, call_name, t); !message.starts_with(who))
      message = who + " threw: " + message;
    throw RunError(
        Diagnostic{Severity::error, "B045", plan.document.origin(component.pointer), component.pointer, message});
  }
}

}  // namespace binnacle::runtime
