// SPDX-License-Identifier: Apache-2.0
// The nmea_writer sink: a position, velocity and heading as sentences of NMEA 0183.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "output/text_output.hpp"
#include "sentences/motion_report.hpp"

namespace binnacle::nmea {

class NmeaWriter final : public Sink {
 public:
  static ComponentSpec spec();
  explicit NmeaWriter(const Binding& binding);

  void report_to(Reporter& reporter) override { output_.report_to(reporter); }
  void open() override { output_.open(); }
  void on(Input from, const SampleView& sample) override;
  void close() override { output_.close(); }
  bool exchange(StateBytes& bytes) override {
    output_.exchange(bytes);
    return true;
  }

 private:
  void read_report(const Parameters& parameters);
  void choose_sentences(const Binding& binding);
  void find_sigma(const Binding& binding);
  double horizontal_sigma(const SampleView& sample) const;

  text_output::TextOutput output_;
  civil_time::UtcClock clock_;
  std::optional<sentences::MotionReport> report_;
  std::vector<sentences::Type> types_;
  double max_sigma_;                    // infinite: none
  std::array<std::size_t, 2> sigma_{};  // where in the covariance the variances of north and east are
  std::size_t covariance_dof_ = 0;
  Fields<3> position_;
  Fields<2> velocity_;
  Field yaw_;
  std::string text_;
};

}  // namespace binnacle::nmea
