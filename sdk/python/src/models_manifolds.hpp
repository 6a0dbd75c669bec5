// SPDX-License-Identifier: Apache-2.0
// The manifolds of a model's ports, for Jacobians by differences: known once a filter is composed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/binding.hpp"
#include "binnacle/section.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle::python {

/// ⊞ and ⊟ of what is on a port: the block's; of a derived value those of a block of its kind; of a vector without any, sums.
class Manifold {
 public:
  Manifold() = default;
  Manifold(std::string kind, int stored_size, const std::vector<NamedUnit>& components);

  void set(std::shared_ptr<const StateBlock> block) { block_ = std::move(block); }
  bool is_known() const { return block_ || is_vector_; }
  const std::string& kind() const { return kind_; }
  int dof() const { return static_cast<int>(units_.size()); }
  int stored_size() const { return stored_size_; }
  /// x ⊞ (size in one component).
  void move(const double* x, int component, double size, double* moved) const;
  /// y ⊟ x.
  void minus(const double* y, const double* x, double* delta) const;
  /// How far one component is moved: where the model states nothing, 1e-4 of an angle, 0.1 m, or of a vector a thousandth of
  /// its value or of 1.
  double step(const double* x, int component) const;

 private:
  std::string kind_;
  int stored_size_ = 0;
  bool is_vector_ = false;
  std::vector<std::string> units_;
  std::shared_ptr<const StateBlock> block_;
};

/// ∂/∂δ of one component by central differences at `step` and at half of it, as jacobian::by_differences takes them, of values
/// whose size is known at run time only. value_at(δ): Eigen::VectorXd, already as a difference where it is on a manifold.
template <class ValueAt>
Eigen::VectorXd by_differences(const ValueAt& value_at, double step) {
  const auto central = [&](double h) -> Eigen::VectorXd {
    const Eigen::VectorXd above = value_at(h), below = value_at(-h);
    return (above - below) / (2 * h);
  };
  const Eigen::VectorXd at_half = central(0.5 * step), at_whole = central(step);
  return (4 * at_half - at_whole) / 3;
}

/// A component whose manifolds are bound after it is made, while its filter is composed, and never again.
class OnManifolds {
 public:
  virtual ~OnManifolds() = default;
  const std::vector<Manifold>& manifolds() const { return *manifolds_; }

 protected:
  std::shared_ptr<std::vector<Manifold>> manifolds_ = std::make_shared<std::vector<Manifold>>();
  /// Of what a derived block yields: the last one.
  void add_manifold(const PortBinding& block);

 private:
  friend class ManifoldBinder;
};

/// Binds the models of a filter to its blocks, and marks them for explain.
std::shared_ptr<const Section> manifolds_section();

}  // namespace binnacle::python
