// SPDX-License-Identifier: Apache-2.0
// RecordJournal: the records of a run so far, beside its checkpoint, since the files that they go to can not be cut back.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/state_bytes.hpp"
#include "binnacle/step_log.hpp"
#include "score/run.hpp"

namespace binnacle::command {

/// Where records go: estimates, and what became of samples.
struct RecordTakers {
  std::function<void(int filter, Time t, std::span<const double> values)> record;
  std::function<StepObserver*(int filter)> step_observer;  // null: nobody's
};

/// Passes records on, and keeps them in a file that grows. A run that is resumed passes on those up to its checkpoint first.
class RecordJournal {
 public:
  /// keep: the file that is written, empty: none; resumed: that of the checkpoint which the run goes on from, empty: none. Throws
  /// UsageError where it cannot be written.
  RecordJournal(std::filesystem::path keep, std::filesystem::path resumed, RecordTakers takers, std::size_t filters);
  ~RecordJournal();
  RecordJournal(const RecordJournal&) = delete;
  RecordJournal& operator=(const RecordJournal&) = delete;

  void record(int filter, Time t, std::span<const double> values);
  StepObserver* step_observer(int filter);
  /// The checkpoint has the length of the file and its checksum. Throws ConfigError (B084) where the file does not hold that.
  void exchange(StateBytes& bytes);

 private:
  class Observer;
  class Checksum;
  void open(const char* mode);
  void put(const void* data, std::size_t size);
  template <class T>
  void put(const T& value) {
    put(&value, sizeof value);
  }
  void offered(int filter, const UpdateRecord& record);
  void replay(std::uint64_t length, std::uint64_t checksum);

  std::filesystem::path keep_, resumed_;
  RecordTakers takers_;
  std::vector<std::unique_ptr<Observer>> observers_;
  std::FILE* file_ = nullptr;
  int fault_ = 0;  // why it took no more, the first time
  std::uint64_t length_ = 0;
  std::unique_ptr<Checksum> checksum_;  // of so many bytes
};

}  // namespace binnacle::command
