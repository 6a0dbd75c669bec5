// SPDX-License-Identifier: Apache-2.0
// How a component refuses what it is bound to.
#pragma once

#include <string>

#include "bind.hpp"
#include "catch.hpp"

namespace binnacle::test {

/// Pointer and words of the error with which a component refuses its setup; "" where it takes it.
template <class Component>
std::string refusal_of(const Setup& setup) {
  try {
    bind<Component>(setup);
  } catch (const ComponentError& error) {
    return error.pointer() + ": " + error.what();
  }
  return "";
}

inline bool says(const std::string& message, const std::string& part) {
  UNSCOPED_INFO(message);
  return message.find(part) != std::string::npos;
}

}  // namespace binnacle::test
