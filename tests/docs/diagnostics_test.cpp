// SPDX-License-Identifier: Apache-2.0
// sdk/docs/diagnostics.md is the kernel's own table of codes.
#include <cstdlib>
#include <fstream>
#include <string>

#include "catch.hpp"
#include "document.hpp"
#include "document/codes.hpp"

namespace diagnostics_test {

namespace {

using namespace binnacle;
using namespace binnacle::test;

const char* const path = "sdk/docs/diagnostics.md";

std::string reference() {
  std::string text =
      "# Diagnostics\n\n"
      "A message reads `FILE:LINE:COLUMN: error[CODE] POINTER: text`. The pointer is that of the resolved config and "
      "can\n"
      "be pasted into `--set POINTER=VALUE`. B00x to B03x are about the config, B04x about plugins, B06x about data, "
      "B08x\n"
      "about running filters, B09x about studies. Exit status: 3 when the config is wrong, 4 when a plugin cannot be\n"
      "loaded, 5 when only data are, 1 when a filter broke or never started, 2 when a journal is of another study.\n"
      "Warnings (B031, B032, B043, B047, B065, B083 and others that a source reports) do not change it.\n\n"
      "This file is made from the table in `sdk/document/codes.cpp`; `BINNACLE_WRITE_DOCS=1 tests/run -L docs` "
      "writes\n"
      "it anew.\n";
  for (const auto& entry : document::diagnostic_codes())
    text += "\n## " + std::string(entry.code) + ": " + std::string(entry.title) + "\n\n" + std::string(entry.cause) +
            "\n\n*Remedy:* " + std::string(entry.remedy) + "\n";
  return text;
}

}  // namespace

TEST_CASE("the reference of diagnostic codes is that of the kernel") {
  if (const char* write = std::getenv("BINNACLE_WRITE_DOCS"); write && *write == '1')
    std::ofstream(in_project(path)) << reference();
  INFO("BINNACLE_WRITE_DOCS=1 tests/run -L docs writes it anew");
  CHECK(text_of(in_project(path)) == reference());
}

}  // namespace diagnostics_test
