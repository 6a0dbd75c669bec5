// SPDX-License-Identifier: Apache-2.0
// Measurement models: H against differences of h(x), R.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "algebra/decompositions.hpp"
#include "binnacle/view.hpp"
#include "differences.hpp"
#include "guarded.hpp"

namespace binnacle::testing {

namespace {

/// What a call writes, between canaries. H and R are zero on entry, as the kernel leaves them.
struct Outputs {
  Outputs(const MeasurementDeclaration& declared, const PortStates& ports, double fill)
      : rows(declared.max_rows),
        residual(as_size(rows), fill),
        R(as_size(rows) * as_size(rows), 0.0),
        by_port(ports.size()),
        keys(as_size(rows)) {
    for (const int port : declared.read_ports)
      H.emplace_back(as_size(rows) * as_size(ports.at(as_size(port)).dof()), 0.0);
    for (std::size_t i = 0; i < H.size(); ++i) {
      const auto port = as_size(declared.read_ports[i]);
      views.push_back({H[i].data(), rows, ports[port].dof(), rows});
      by_port[port] = views.back();
    }
    std::iota(keys.begin(), keys.end(), 0);
    at = {0, {residual.data(), rows}, by_port.data(), {R.data(), rows, rows, rows}, keys};
  }
  int rows;
  Guarded residual, R;
  std::vector<Guarded> H;
  std::vector<MatrixView> views, by_port;  // per entry of read_ports; per port
  std::vector<std::int64_t> keys;
  MeasurementOutput at;

  void examine_ends(std::string& damage) const {
    examine(residual, "residual", 0.0, damage);
    examine(R, "R", 0.0, damage);
    for (const auto& block : H) examine(block, "H", 0.0, damage);
  }
};

/// Independent errors of the ports' scales.
struct Covariance {
  Covariance(const PortStates& ports, Inputs& inputs) {
    const int n = offset(ports, ports.size());
    Eigen::VectorXd variances(n);
    for (std::size_t i = 0; i < ports.size(); ++i) {
      first_row.push_back(ports[i].is_open() ? -1 : offset(ports, i));
      if (!ports[i].is_open()) variances.segment(offset(ports, i), ports[i].dof()) = ports[i].scale.cwiseAbs2();
    }
    const Eigen::MatrixXd P = variances.asDiagonal();
    at = {inputs.keep("P", P.data(), static_cast<std::size_t>(P.size())), n, first_row.data()};
  }
  std::vector<int> first_row;
  PortCovariance at;
};

void collect(const Outputs& outputs, double fill, Measured& out) {
  const int rows = outputs.at.rows;
  if (rows < 0 || rows > outputs.rows) {
    out.damage = "it wrote " + std::to_string(rows) + " rows, and declared at most " + std::to_string(outputs.rows);
    return;
  }
  for (int i = 0; i < rows; ++i)
    if (out.damage.empty() && std::isnan(fill) && same_bits(outputs.residual.data()[i], fill))
      out.damage = "residual: not written completely";
  out.residual = vector_at(outputs.residual.data(), rows);
  for (const auto& view : outputs.views) out.H.push_back(view.as().topRows(rows));
  out.R = outputs.at.R.as().topLeftCorner(rows, rows);
  out.keys.assign(outputs.keys.begin(), outputs.keys.begin() + rows);
  append(out.numbers, {out.residual.data(), out.residual.data() + rows});
  for (const auto& h : out.H) append(out.numbers, {h.data(), h.data() + h.size()});
  append(out.numbers, {out.R.data(), out.R.data() + out.R.size()});
}

}  // namespace

std::vector<std::byte> MeasurementCaller::fresh_memory() const {
  std::vector<std::byte> memory(model_->declaration().memory_bytes);
  called("start", [&] { return model_->start(memory.data()), 0; });
  return memory;
}

Measured MeasurementCaller::linearize(const Given& given, const PortStates& ports, const std::vector<std::byte>& memory,
                                      double fill, bool with_H) const {
  Inputs inputs;
  SampleView sample = given.sample;
  std::vector<SampleView> auxiliary(given.auxiliary.begin(), given.auxiliary.end());
  if (spec_) {
    sample = guarded_sample(given.sample, spec_->fields, "the sample", inputs);
    auxiliary = guarded_inputs(given.auxiliary, *spec_, inputs);
  }
  const double* rates = spec_ ? inputs.keep("the driving rates", given.u.rates.data(), spec_->driving_rates.size())
                              : given.u.rates.data();
  const auto x = pointers(ports, spec_, inputs);
  const Covariance P(ports, inputs);
  Outputs outputs(model_->declaration(), ports, fill);
  if (!with_H) outputs.at.H = {};
  Measured out;
  out.memory = memory;
  const MeasurementInput input{sample,
                               auxiliary.data(),
                               x.data(),
                               {given.u.t, rates},
                               out.memory.data(),
                               model_->declaration().needs_covariance ? P.at : PortCovariance(),
                               {}};
  out.result = called("linearize", [&] { return model_->linearize(input, outputs.at); });
  out.damage = inputs.damage("linearize");
  outputs.examine_ends(out.damage);
  if (out.result) collect(outputs, fill, out);
  return out;
}

Complaints check_measurement(const MeasurementCaller& measurement, const Given& given, const PortStates& ports,
                             const std::vector<std::byte>& memory, const Tolerance& tolerance, double resolution) {
  Complaints out;
  const auto call = [&](const PortStates& at) { return measurement.linearize(given, at, memory); };
  const Measured nominal = call(ports);
  if (!nominal.damage.empty()) out.add(nominal.damage);
  if (!nominal.result) return out.add("refused: ", nominal.result.reason), out;
  const Eigen::Index rows = nominal.residual.size();
  const Function predicted = [&](const PortStates& at) -> Eigen::VectorXd {
    const Measured m = call(at);
    return m.result && m.residual.size() == rows ? Eigen::VectorXd(-m.residual) : Eigen::VectorXd::Constant(rows, NAN);
  };
  const auto& reads = measurement.model().declaration().read_ports;
  for (std::size_t port = 0; port < ports.size(); ++port) {
    if (ports[port].is_open() || rows == 0) continue;
    const auto found = std::find(reads.begin(), reads.end(), static_cast<int>(port));
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(rows, ports[port].dof());
    if (found != reads.end()) H = nominal.H[static_cast<std::size_t>(found - reads.begin())];
    compare({"H of '" + measurement.spec().ports[port].name + "'", H,
             found == reads.end() ? "the port is not declared as read" : "",
             [&](Eigen::Index i, Eigen::Index j) {
               const double row = H.row(i).cwiseAbs().dot(ports[port].scale.transpose());
               return (tolerance.relative * row + tolerance.neglected * std::sqrt(nominal.R(i, i))) /
                      ports[port].scale[j];
             },
             resolution},
            ports, port, predicted, tolerance.steps, out);
  }
  return out;
}

namespace {

bool same(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && std::equal(a.data(), a.data() + a.size(), b.data(), same_bits);
}

}  // namespace

Complaints check_values(const MeasurementCaller& measurement, const Given& given, const PortStates& ports,
                        const std::vector<std::byte>& memory) {
  Complaints out;
  const Measured with = measurement.linearize(given, ports, memory);
  const Measured without = measurement.linearize(given, ports, memory, unwritten(), false);
  if (!without.damage.empty()) out.add("without H: ", without.damage);
  if (with.result.refusal != without.result.refusal) out.add("without H it refuses otherwise");
  if (!same(with.residual, without.residual)) out.add("the residual differs when no H is requested");
  if (!same(with.R, without.R)) out.add("R differs when no H is requested");
  if (with.keys != without.keys) out.add("the keys of the rows differ when no H is requested");
  // Of its memory counts what the next call makes of it: bytes of padding may differ.
  const Measured next = measurement.linearize(given, ports, with.memory);
  const Measured other = measurement.linearize(given, ports, without.memory);
  if (next.result.refusal != other.result.refusal || !same(next.residual, other.residual) || !same(next.R, other.R))
    out.add("its memory differs when no H is requested: the next call gives a different answer");
  return out;
}

Complaints check_covariance(const Eigen::MatrixXd& R) {
  Complaints out;
  if (R.size() == 0) return out;
  const double largest = R.cwiseAbs().maxCoeff();
  if (!((R - R.transpose()).cwiseAbs().maxCoeff() <= 1e-14 * largest)) out.add("R is not symmetric:\n", R);
  const double least = algebra::eigenvalues(R).minCoeff();
  if (!(R.diagonal().minCoeff() > 0))
    out.add("R has a 0 on its diagonal: R is 0 on entry, and the model writes each row's variance");
  if (!(least >= -1e-12 * largest)) out.add("R is not positive semidefinite: it has the eigenvalue ", least);
  return out;
}

}  // namespace binnacle::testing
