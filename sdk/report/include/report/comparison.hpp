// SPDX-License-Identifier: Apache-2.0
// Several runs compared: what differs, as JSON, and one page on which they are overlaid.
#pragma once

#include <string>
#include <vector>

#include "report/page.hpp"
#include "results/results.hpp"

namespace binnacle::report {

/// One of them, by a name that no other has: that of its folder.
struct NamedRun {
  std::string name;
  std::string folder;
  results::RunResults run;
};

/// A filter of the first run, and what it is called in others.
struct FilterPair {
  std::string first, other;
};

/// Throws std::invalid_argument, one line, where no run has a filter that a pair names.
class Comparison {
 public:
  Comparison(const std::vector<NamedRun>& runs, const std::vector<FilterPair>& pairs);

  /// { "runs": [ { "name", "folder", "title", "command", "version", "seed", "created" } ],
  ///   "filters": [ { "name", "of": [ name or null, a run each ] } ],
  ///   "verdicts": [ { "filter", "states": [ … ], "codes": [ [ … ], … ] } ],
  ///   "metrics": [ { "name", "unit", "values": [ … ], "differences": [ null, second − first, … ] } ],
  ///   "config": [ { "pointer", "values": [ …, null where there is none ] } ],
  ///   "lacks": [ text ] }
  /// Of metrics all that there is in a summary but for times that the computer took; those that are equal in all runs too.
  const results::Json& json() const { return json_; }
  std::string page(const Limits& limits = {}) const;

 private:
  void match(const std::vector<FilterPair>& pairs);
  void add_runs();
  void add_verdicts();
  void add_metrics();
  void add_config();
  void add_lacks();

  const std::vector<NamedRun>& runs_;
  struct Matched {
    std::string shown;
    std::vector<std::string> of;  // its name in each run; empty where it has none
  };
  std::vector<Matched> filters_;
  results::Json json_;
};

}  // namespace binnacle::report
