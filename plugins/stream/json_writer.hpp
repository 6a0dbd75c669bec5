// SPDX-License-Identifier: Apache-2.0
// The json_writer sink: each sample of a channel as one line of JSON.
#pragma once

#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "output/text_output.hpp"

namespace binnacle::stream {

/// Numbers are in SI. One that is not finite is null.
class JsonWriter final : public Sink {
 public:
  static ComponentSpec spec();
  explicit JsonWriter(const Binding& binding);

  void report_to(Reporter& reporter) override { output_.report_to(reporter); }
  void open() override { output_.open(); }
  void on(Input from, const SampleView& sample) override;
  void close() override { output_.close(); }
  bool exchange(StateBytes& bytes) override {
    output_.exchange(bytes);
    return true;
  }

 private:
  enum class Covariance { none, sigma, full };

  void append_rows(const SampleView& sample);
  void append_covariance(const double* P);

  text_output::TextOutput output_;
  Covariance covariance_;
  std::string head_;                     // {"channel":"ins","t":
  std::vector<std::string> keys_;        // ,"lat":   by per-epoch field
  std::vector<std::string> row_keys_;    // by per-row field
  std::vector<std::string> sigma_keys_;  // by error component
  std::string line_;
};

}  // namespace binnacle::stream
