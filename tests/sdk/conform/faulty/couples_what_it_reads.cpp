// SPDX-License-Identifier: Apache-2.0
// Declares a row of Phi for a port that it only reads.
// fails: metadata.example
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  static binnacle::ComponentSpec spec() {
    auto spec = Process::spec();
    spec.ports.push_back(binnacle::reads("b", "vector:2:m/s", "a bias"));
    spec.example = R"({"blocks": {"p": "position", "v": "velocity", "b": "bias"}})";
    return spec;
  }
  explicit Subject(const binnacle::Binding& binding) : Process(binding) {
    declaration_.noise.push_back({2, 2, binnacle::Structure::diagonal});
  }
};

}  // namespace

BINNACLE_PLUGIN("couples_what_it_reads", "1.0.0", registry) { registry.add<Subject>(); }
