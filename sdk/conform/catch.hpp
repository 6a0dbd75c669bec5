// SPDX-License-Identifier: Apache-2.0
// Catch2, version 2 or 3: a check's process is one session of it.
#pragma once

#if __has_include(<catch2/catch_session.hpp>)
#include <catch2/catch_session.hpp>
#include <catch2/catch_test_macros.hpp>
#else
#define CATCH_CONFIG_RUNNER
#define CATCH_CONFIG_NO_POSIX_SIGNALS  // a crash is the driver's to report
#include <catch2/catch.hpp>
#endif
