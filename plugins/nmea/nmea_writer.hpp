// SPDX-License-Identifier: Apache-2.0
// The nmea_writer sink: a position, velocity and heading as sentences of NMEA 0183.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "output/text_output.hpp"
#include "sentence.hpp"

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
  enum class Type { gga, rmc, vtg, hdt };
  /// What a sample comes to.
  struct Fix {
    Utc utc;
    double lat, lon, height;
    double speed, course;  // over ground [m/s, rad]
    double yaw;
    bool is_valid;
  };

  void choose_sentences(const Binding& binding);
  void find_sigma(const Binding& binding);
  void append(Type type, const Fix& fix);
  double horizontal_sigma(const SampleView& sample) const;

  text_output::TextOutput output_;
  UtcClock clock_;
  std::string talker_;
  std::vector<Type> types_;
  char quality_, mode_;                 // of GGA; of RMC and VTG
  double geoid_separation_;             // NaN: not known
  double max_sigma_;                    // infinite: none
  std::array<std::size_t, 2> sigma_{};  // where in the covariance the variances of north and east are
  std::size_t covariance_dof_ = 0;
  Fields<3> position_;
  Fields<2> velocity_;
  Field yaw_;
  std::string text_;
};

}  // namespace binnacle::nmea
