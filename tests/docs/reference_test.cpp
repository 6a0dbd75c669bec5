// SPDX-License-Identifier: Apache-2.0
// sdk/docs/reference.md is what the specs say now.
#include "catch.hpp"
#include "document.hpp"
#include "project_folder.hpp"

namespace reference_test {

using namespace binnacle::test;

TEST_CASE("the config reference is that of the plugins") {
  std::string printed;
  REQUIRE(ProjectFolder().run("build/release/bin/binnacle describe --all", printed) == 0);
  const bool is_current = text_of(in_project("sdk/docs/reference.md")) == printed;
  INFO("binnacle describe --all > sdk/docs/reference.md makes it anew");
  CHECK(is_current);
}

}  // namespace reference_test
