// SPDX-License-Identifier: Apache-2.0
// A filter along a path that is known: what it did with each sample, the states of the path, and the linear filter of the
// deviations from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "binnacle/composition.hpp"
#include "binnacle/step_log.hpp"

namespace binnacle::smooth {

class Stretch;

/// What became of each sample that was offered, in order, and which rows of it were used.
class Decisions {
 public:
  enum Kind : unsigned char { unused, whole, part, withheld };
  struct Row {
    int group;
    std::int64_t key;
    bool operator==(const Row&) const = default;
  };

  void note(const UpdateRecord& record);
  /// What `later` noted came after.
  void append(const Decisions& later);
  void clear() { *this = {}; }

  std::size_t size() const { return kinds_.size(); }
  Kind operator[](std::size_t sample) const { return static_cast<Kind>(kinds_[sample]); }
  /// Rows of a sample of which a part was used: those from `first` on that follow; moves `first` behind them.
  std::size_t next_rows(std::size_t& first) const;
  const Row& row(std::size_t i) const { return rows_[i]; }

 private:
  std::vector<unsigned char> kinds_;
  std::vector<Row> rows_;  // of each sample of which a part was used, with their number before them as a key
};

/// Stored states after the start and after each step, in a file without a name; written from the last to the first.
class PathFile {
 public:
  explicit PathFile(int stored_size);
  void write(const double* x);
  /// index: 0 is the start. False beyond the end.
  bool read(std::int64_t index, double* x) const;
  std::int64_t count() const { return count_; }
  void clear() { count_ = 0; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::size_t size_;
  std::int64_t count_ = 0;
};

/// Drives a filter along a path x̄, and filters the deviations δ of x = x̄ ⊞ δ with what its models give there: steps
/// δ ← Φ δ + (f(x̄₀) ⊟ x̄₁), updates with the residual r − H δ of what was accepted before. That is one iteration of Gauss
/// and Newton over the interval once δ is smoothed (Bell, The iterated Kalman smoother as a Gauss–Newton method, SIAM Journal
/// on Optimization 4, 1994). Where the path's steps leave process noise, its tangent spaces are taken to be parallel.
class PathFilter final : public StepObserver {
 public:
  /// considered: per row of P; empty: none.
  PathFilter(const FilterInfo& filter, std::vector<unsigned char> considered);

  /// path and decisions stay alive meanwhile.
  void begin(const PathFile& path, const Decisions& decisions);
  /// What is filtered goes to this log; null: to none.
  void record_to(Stretch* stretch) { stretch_ = stretch; }

  /// Why the path cannot be followed further; empty: it can.
  const std::string& trouble() const { return trouble_; }
  const double* x() const { return x_.data(); }
  const double* deviation() const { return delta_.data(); }
  ConstMatrixView covariance() const;

  /// All that changes.
  struct Snapshot {
    std::int64_t index = -1;
    std::size_t sample = 0, row = 0;
    Eigen::VectorXd delta;
    Eigen::MatrixXd P;
  };
  Snapshot snapshot() const { return {index_, sample_, row_, delta_, P_}; }
  void restore(const Snapshot& snapshot);

  Wants wants() const override { return Wants::transition | Wants::jacobian; }
  const double* nominal() override { return index_ < 0 || !trouble_.empty() ? nullptr : x_.data(); }
  void started(Time t, const double* x, ConstMatrixView P) override;
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;

 private:
  void read_path(std::int64_t index, std::vector<double>& x);
  void minus(const double* y, const double* x, Time t, Eigen::VectorXd& delta);
  bool choose_rows(const UpdateRecord& record, Decisions::Kind kind, std::size_t first);
  void update(const UpdateRecord& record);

  const FilterInfo& filter_;
  std::vector<unsigned char> considered_;
  const PathFile* path_ = nullptr;
  const Decisions* decisions_ = nullptr;
  Stretch* stretch_ = nullptr;
  std::string trouble_;
  std::int64_t index_ = -1;  // of the path; −1: not started
  std::size_t sample_ = 0, row_ = 0;
  std::vector<double> x_, next_x_;
  std::vector<double> block_delta_;
  Eigen::VectorXd delta_, defect_;
  Eigen::MatrixXd P_, scratch_;
  std::vector<int> chosen_;
  Eigen::MatrixXd H_, R_, S_, K_;
  Eigen::VectorXd r_;
};

}  // namespace binnacle::smooth
