// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "binnacle/spec.hpp"

namespace binnacle::document {

inline const char* kind_name(FieldKind kind) {
  return kind == FieldKind::rate ? "rate" : kind == FieldKind::increment ? "increment" : "level";
}

}  // namespace binnacle::document
