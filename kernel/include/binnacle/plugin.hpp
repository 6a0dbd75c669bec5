// SPDX-License-Identifier: Apache-2.0
// The one header a plugin includes, and the macro that makes a shared library a plugin.
#pragma once

#include "binnacle/abi.hpp"
#include "binnacle/registry.hpp"

/// Defines the two exported symbols of a plugin, followed by the body of its registration function:
///
///     BINNACLE_PLUGIN("my_plugin", "1.0.0", registry) { registry.add<MyBlock>(); }
///
/// `name` is the plugin's own, before the slash of `my_plugin/my_block`. Once per library; a test may link several.
#define BINNACLE_PLUGIN(name, version, registry)                                                          \
  extern "C" __attribute__((visibility("default"), weak)) const ::binnacle::abi::Guard binnacle_guard_v1; \
  const ::binnacle::abi::Guard binnacle_guard_v1 = ::binnacle::abi::make_guard(name, version);            \
  extern "C" __attribute__((visibility("default"), weak)) void binnacle_register_v1(::binnacle::Registry& registry)

/// Beside BINNACLE_PLUGIN, where it is known at compile time: the types that the plugin registers, all of them, separated
/// by spaces. A config that names none of them then runs without loading the plugin; without the list it is loaded always.
/// A plugin that registers other types than these is refused.
///
///     BINNACLE_TYPES("my_block my_process");
#define BINNACLE_TYPES(names)                                                             \
  extern "C" __attribute__((visibility("default"), weak)) const char binnacle_types_v1[]; \
  const char binnacle_types_v1[] = names
