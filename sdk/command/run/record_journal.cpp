// SPDX-License-Identifier: Apache-2.0
#include "record_journal.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "binnacle/diagnostic.hpp"
#include "output.hpp"
#include "wording/checksum.hpp"

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

enum class Entry : std::int32_t { record, sample };

/// Of a sample, without what its entry has further on.
struct SampleEntry {
  std::int32_t filter = 0, measurement = 0, outcome = 0, rows = 0;
  Time t = no_time;
  double nis = 0;
  std::int32_t reason_length = 0, is_linearized = 0;
};

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw ConfigError(Diagnostic{Severity::error, "B084", Origin{file.string(), 0, 0}, "",
                               "the run cannot be resumed: the records of its checkpoint " + why});
}

class Reader {
 public:
  Reader(const fs::path& path, std::uint64_t length) : path_(path), left_(length) {
    std::error_code none;
    const auto size = fs::file_size(path, none);
    if (none) refuse(path, "are not there");
    if (size < length) refuse(path, fmt::format("are torn, {} bytes of {}", size, length));
    file_ = std::fopen(path.c_str(), "rb");
    if (!file_) refuse(path, std::string("can not be read: ") + std::strerror(errno));
  }
  ~Reader() {
    if (file_) std::fclose(file_);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  [[noreturn]] void refuse_damaged() const { refuse(path_, "are damaged"); }
  bool is_over() const { return left_ == 0; }
  std::uint64_t left() const { return left_; }
  void get(void* data, std::size_t size) {
    if (size > left_ || std::fread(data, 1, size, file_) != size) refuse(path_, "are torn");
    left_ -= size;
  }
  template <class T>
  T get() {
    T value;
    get(&value, sizeof value);
    return value;
  }
  template <class T>
  void get(std::vector<T>& items, std::int64_t count) {
    if (count < 0 || static_cast<std::uint64_t>(count) > left_ / sizeof(T)) refuse(path_, "are torn");
    items.resize(static_cast<std::size_t>(count));
    get(items.data(), items.size() * sizeof(T));
  }

 private:
  const fs::path& path_;
  std::uint64_t left_;
  std::FILE* file_ = nullptr;
};

constexpr std::int32_t most_rows = 1 << 12;  // S and R are squares

/// A sample as it was recorded: of S and R the diagonal.
class ReadSample {
 public:
  explicit ReadSample(Reader& reader) : head_(reader.get<SampleEntry>()) {
    reader.get(reason_, head_.reason_length);
    reason_.push_back('\0');
    if (!head_.is_linearized) return;
    if (head_.rows > most_rows) reader.refuse_damaged();
    reader.get(keys_, head_.rows);
    reader.get(groups_, head_.rows);
    reader.get(residual_, head_.rows);
    for (auto* diagonal : {&S_, &R_}) {
      std::vector<double> values;
      reader.get(values, head_.rows);
      diagonal->assign(values.size() * values.size(), 0.0);
      for (std::size_t i = 0; i < values.size(); ++i) (*diagonal)[i * (values.size() + 1)] = values[i];
    }
  }
  int filter() const { return head_.filter; }
  UpdateRecord record() const {
    UpdateRecord record;
    record.measurement = head_.measurement;
    record.t = head_.t;
    record.outcome = static_cast<Outcome>(head_.outcome);
    record.reason = reason_.data();
    record.rows = head_.rows;
    record.nis = head_.nis;
    if (!head_.is_linearized) return record;
    record.row_keys = keys_.data();
    record.row_groups = groups_.data();
    record.residual = residual_.data();
    record.S = {S_.data(), head_.rows, head_.rows, head_.rows};
    record.R = {R_.data(), head_.rows, head_.rows, head_.rows};
    return record;
  }

 private:
  SampleEntry head_;
  std::vector<char> reason_;
  std::vector<std::int64_t> keys_;
  std::vector<int> groups_;
  std::vector<double> residual_, S_, R_;
};

}  // namespace

class RecordJournal::Checksum : public wording::Checksum {};

class RecordJournal::Observer final : public StepObserver {
 public:
  Observer(RecordJournal& journal, int filter) : journal_(journal), filter_(filter) {}
  void offered(const UpdateRecord& record) override { journal_.offered(filter_, record); }

 private:
  RecordJournal& journal_;
  int filter_;
};

RecordJournal::RecordJournal(fs::path keep, fs::path resumed, RecordTakers takers, std::size_t filters)
    : keep_(std::move(keep)),
      resumed_(std::move(resumed)),
      takers_(std::move(takers)),
      checksum_(std::make_unique<Checksum>()) {
  for (std::size_t f = 0; f < filters; ++f)
    observers_.push_back(std::make_unique<Observer>(*this, static_cast<int>(f)));
  if (!keep_.empty() && resumed_.empty()) open("wb");
}

RecordJournal::~RecordJournal() {
  if (file_) std::fclose(file_);
}

StepObserver* RecordJournal::step_observer(int filter) { return observers_[static_cast<std::size_t>(filter)].get(); }

void RecordJournal::open(const char* mode) {
  file_ = std::fopen(keep_.c_str(), mode);
  if (!file_) throw UsageError(fmt::format("cannot write '{}': {}", keep_.string(), std::strerror(errno)));
}

/// What can not be written is seen by exchange(): a step observer must not throw.
void RecordJournal::put(const void* data, std::size_t size) {
  if (!file_) return;
  length_ += size;
  checksum_->add(data, size);
  if (std::fwrite(data, 1, size, file_) != size && fault_ == 0) fault_ = errno;
}

void RecordJournal::record(int filter, Time t, std::span<const double> values) {
  takers_.record(filter, t, values);
  put(Entry::record);
  put(static_cast<std::int32_t>(filter));
  put(t);
  put(static_cast<std::int64_t>(values.size()));
  put(values.data(), values.size_bytes());
}

void RecordJournal::offered(int filter, const UpdateRecord& record) {
  if (StepObserver* const next = takers_.step_observer(filter)) next->offered(record);
  if (!file_) return;
  SampleEntry head{filter, record.measurement, static_cast<std::int32_t>(record.outcome), record.rows, record.t};
  head.nis = record.nis;
  head.reason_length = static_cast<std::int32_t>(std::strlen(record.reason));
  head.is_linearized = record.residual != nullptr;
  put(Entry::sample);
  put(head);
  put(record.reason, static_cast<std::size_t>(head.reason_length));
  if (!head.is_linearized) return;
  const auto rows = static_cast<std::size_t>(record.rows);
  put(record.row_keys, rows * sizeof *record.row_keys);
  put(record.row_groups, rows * sizeof *record.row_groups);
  put(record.residual, rows * sizeof *record.residual);
  for (int i = 0; i < record.rows; ++i) put(record.S(i, i));
  for (int i = 0; i < record.rows; ++i) put(record.R(i, i));
}

void RecordJournal::exchange(StateBytes& bytes) {
  if (file_ && std::fflush(file_) != 0 && fault_ == 0) fault_ = errno;
  if (fault_ != 0) throw OutputError(could_not_write(keep_, std::strerror(fault_)));
  std::uint64_t length = length_, checksum = checksum_->value();
  bytes.value(length);
  bytes.value(checksum);
  if (bytes.is_reading() && bytes.holds()) replay(length, checksum);
}

/// Nothing is passed on of a file that is not whole.
void RecordJournal::replay(std::uint64_t length, std::uint64_t checksum) {
  for (Reader all(resumed_, length); !all.is_over();) {
    char block[1 << 16];
    const std::size_t size = std::min<std::uint64_t>(sizeof block, all.left());
    all.get(block, size);
    checksum_->add(block, size);
  }
  if (checksum_->value() != checksum) refuse(resumed_, "are damaged: their checksum is not that of the checkpoint");
  Reader reader(resumed_, length);
  std::vector<double> values;
  const auto check_filter = [&](int filter) {
    if (filter < 0 || static_cast<std::size_t>(filter) >= observers_.size()) reader.refuse_damaged();
  };
  while (!reader.is_over()) {
    const auto entry = reader.get<std::int32_t>();
    if (entry == static_cast<std::int32_t>(Entry::sample)) {
      const ReadSample sample(reader);
      check_filter(sample.filter());
      if (StepObserver* const next = takers_.step_observer(sample.filter())) next->offered(sample.record());
      continue;
    }
    if (entry != static_cast<std::int32_t>(Entry::record)) reader.refuse_damaged();
    const auto filter = reader.get<std::int32_t>();
    check_filter(filter);
    const auto t = reader.get<Time>();
    reader.get(values, reader.get<std::int64_t>());
    takers_.record(filter, t, values);
  }
  if (keep_.empty()) return;
  std::error_code error;
  if (!fs::equivalent(keep_, resumed_, error)) fs::copy_file(resumed_, keep_, fs::copy_options::overwrite_existing);
  fs::resize_file(keep_, length);
  length_ = length;
  open("ab");
}

}  // namespace binnacle::command
