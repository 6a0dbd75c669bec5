// SPDX-License-Identifier: Apache-2.0
// A reader of files as a target: the bytes become a file, which is read to its end as the kernel does it.
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "../readers/reading.hpp"
#include "target.hpp"

namespace binnacle::fuzz {

/// `parameter`: which one names the file. Others than ComponentError are for the fuzzer to see: std::logic_error is of
/// samples that go back in time, or of a source that wrote where it may not.
template <class SourceType>
void read_file(const char* name, std::string_view bytes, nlohmann::json parameters, const char* parameter = "path") {
  static const test::Folder folder;
  parameters[parameter] = folder.write(name, std::string(bytes));
  try {
    const test::Recorded<SourceType> read(parameters);
  } catch (const ComponentError&) {
  }
}

}  // namespace binnacle::fuzz
