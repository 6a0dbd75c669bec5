// SPDX-License-Identifier: Apache-2.0
// The oxts source: a folder of OXTS data, one text file for each sample.
#pragma once

#include <filesystem>
#include <vector>

#include "binnacle/source.hpp"
#include "oxts_record.hpp"
#include "text/faults.hpp"

namespace binnacle::kitti {

class OxtsSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit OxtsSource(const Binding& binding);

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& bytes, SourceOutput& output) const override;

 private:
  struct Row {
    Time t = no_time;
    int line = 0;  // of the stamps
    OxtsRecord record;
  };

  std::vector<Time> read_stamps(text_file::Faults& faults) const;
  bool read_data(std::size_t index, int line, text_file::Faults& faults, OxtsRecord& record) const;
  void report_strangers(std::size_t stamps, Reporter& reporter) const;
  void declare_channels();
  void write_imu(std::size_t index, SampleWriter& out) const;
  void write_solution(const Row& row, SampleWriter& out) const;

  std::filesystem::path folder_;  // that with timestamps.txt and data
  civil_time::UtcClock clock_;
  Time zone_, max_gap_;
  text_file::OnInvalid on_invalid_;
  OutputChannel solution_, imu_;
  OutputFields<3> position_, velocity_, attitude_, position_sd_, velocity_sd_;
  OutputFields<5> state_;
  OutputFields<6> inertial_;
  Memory<std::uint64_t> next_;  // two for each row

  std::vector<Row> rows_;
};

}  // namespace binnacle::kitti
