// SPDX-License-Identifier: Apache-2.0
// Declares a row of Phi for a port that it only reads.
// fails: metadata.example
#include "faulty.hpp"

namespace faulty::couples_what_it_reads {

class Subject final : public Process {
 public:
  static ComponentSpec spec() {
    auto spec = Process::spec();
    spec.ports.push_back(reads("b", "vector:2:m/s", "a bias"));
    spec.example = R"({"blocks": {"p": "position", "v": "velocity", "b": "bias"}})";
    return spec;
  }
  explicit Subject(const Binding& binding) : Process(binding) {
    declaration_.noise.push_back({2, 2, Structure::diagonal});
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("couples_what_it_reads")); }

}  // namespace faulty::couples_what_it_reads
