// SPDX-License-Identifier: Apache-2.0
// stream/json: one JSON object a line.
#pragma once

#include "line_source.hpp"

namespace binnacle::stream {

class JsonSource final : public LineSource {
 public:
  static ComponentSpec spec();
  explicit JsonSource(const Binding& binding);

 private:
  class Reader;
  bool parse(std::string_view line, LineSample& sample) const override;
};

}  // namespace binnacle::stream
