// SPDX-License-Identifier: Apache-2.0
#include "motion_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "binnacle/eigen.hpp"
#include "record.hpp"
#include "shaping_fit.hpp"
#include "spectrum.hpp"

namespace binnacle::ship_motion {

namespace {

using namespace parameter;

ParameterSpec response_spec(const std::string& unit) {
  return object(
      "response",
      {number("omega", "rad/s").above(0).required().about("natural frequency"),
       number("zeta", "1").above(0).required().about("damping ratio"),
       number("gain", unit + "/m").about("response far below the natural frequency, per wave amplitude of 1 m"),
       number("slope_gain", unit)
           .about("response far below the natural frequency, per wave slope of 1 rad; \"1 rad\" follows the wave "
                  "surface")});
}

ParameterSpec sea_spec(const std::string& unit) {
  return object(
      "sea",
      {number("significant_height", "m").above(0).required().about("significant height of the waves, 4 √m₀"),
       number("peak_period", "s").above(0).required().about("peak period of the waves at a fixed point"),
       number("gamma", "1")
           .at_least(1)
           .at_most(10)
           .defaults("1")
           .about("peak enhancement: 1 Bretschneider, 3.3 JONSWAP"),
       number("speed", "m/s").at_least(0).defaults("0").about("speed of the ship"),
       number("heading", "rad")
           .defaults("\"180 deg\"")
           .about("angle between the directions of the ship and of the waves; 180 deg: head sea"),
       object("rao",
              {vector("omega", "rad/s").required().about("wave frequencies in increasing order"),
               vector("gain", unit + "/m").required().about("amplitude of the motion per wave amplitude of 1 m")})
           .about("response amplitude operator as a table, for this speed and heading; zero outside the table"),
       response_spec(unit).about("response as a resonance over the frequency of encounter; alternative to the table")});
}

ParameterSpec fit_spec(const std::string& unit) {
  auto record = RecordPlace::parameters();
  record.push_back(
      parameter::time("segment").above(0).about("segment length of Welch's method; default: a tenth of the record"));
  return object(
      "fit", {integer("order").at_least(2).at_most(4).defaults("2").about("2 or 4"),
              object("spectrum",
                     {vector("omega", "rad/s").required().about("frequencies in increasing order"),
                      vector("density", unit + "^2*s").required().about("one-sided power spectral density over rad/s")})
                  .about("spectrum of the motion as a table"),
              sea_spec(unit).about("a Bretschneider or JONSWAP sea spectrum and the ship's response"),
              object("record", std::move(record)).about("a recorded motion; its mean is removed")});
}

void check_table(const Eigen::VectorXd& omega, const Eigen::VectorXd& values, const std::string& pointer) {
  if (omega.size() != values.size()) throw ComponentError("one value for each frequency", pointer);
  if (omega.size() < 3) throw ComponentError("three frequencies at least", pointer);
  for (Eigen::Index i = 0; i < omega.size(); ++i)
    if (omega[i] < 0 || (i > 0 && omega[i] <= omega[i - 1]))
      throw ComponentError("frequencies increase from 0", pointer + "/omega");
  if (values.minCoeff() < 0 || !(values.maxCoeff() > 0))
    throw ComponentError("values are not negative, and not all zero", pointer);
}

Response read_response(const Parameters& sea) {
  const char* const pointer = "/fit/sea";
  if (sea.has("rao") == sea.has("response"))
    throw ComponentError("the response of the ship is either a table, 'rao', or a resonance, 'response'", pointer);
  if (sea.has("rao")) {
    const Parameters table = sea.object("rao");
    const Eigen::VectorXd omega = table.vector("omega"), gain = table.vector("gain");
    check_table(omega, gain, std::string(pointer) + "/rao");
    return tabulated_response(omega, gain);
  }
  const Parameters resonance = sea.object("response");
  const bool is_of_slope = resonance.has("slope_gain");
  if (is_of_slope == resonance.has("gain"))
    throw ComponentError("either 'gain' or 'slope_gain'", std::string(pointer) + "/response");
  return resonant_response(resonance.number("omega"), resonance.number("zeta"),
                           resonance.number(is_of_slope ? "slope_gain" : "gain"), is_of_slope);
}

Spectrum read_sea(const Parameters& sea) {
  const Spectrum spectrum =
      motion_spectrum(Sea(sea.number("significant_height"), sea.number("peak_period"), sea.number("gamma")),
                      {sea.number("speed"), sea.number("heading")}, read_response(sea));
  if (!(spectrum.moment(0) > 0)) throw ComponentError("the ship does not respond to this sea", "/fit/sea");
  return spectrum;
}

Spectrum read_table(const Parameters& table) {
  const Eigen::VectorXd omega = table.vector("omega"), density = table.vector("density");
  check_table(omega, density, "/fit/spectrum");
  return tabulated(omega, density);
}

ShapingFit fit_record(int order, const Parameters& fit_parameters, const std::string& si_unit) {
  const Record record = RecordPlace(fit_parameters, si_unit, "/fit/record").read();
  const Parameters parameters = fit_parameters.object("record");
  const double whole = record.interval * static_cast<double>(record.values.size());
  const double wanted = parameters.has("segment") ? seconds(parameters.time("segment")) : 0.1 * whole;
  const Eigen::Index length = 2 * static_cast<Eigen::Index>(std::llround(0.5 * wanted / record.interval));
  if (length < 16 || length > record.values.size())
    throw ComponentError("a segment of " + std::to_string(length) +
                             " samples; it takes 16 or more, and the record has " +
                             std::to_string(record.values.size()),
                         "/fit/record");
  if (!(record.values.squaredNorm() > 0)) throw ComponentError("the record contains no motion", "/fit/record");
  return fit(order, record.values, Welch(length, record.interval));
}

ShapingFit read_fit(const Parameters& parameters, const std::string& si_unit) {
  const int order = static_cast<int>(parameters.integer("order"));
  if (order == 3) throw ComponentError("an order is 2 or 4", "/fit/order");
  if (parameters.has("spectrum") + parameters.has("sea") + parameters.has("record") != 1)
    throw ComponentError("fitted to one of 'spectrum', 'sea', 'record'", "/fit");
  if (parameters.has("record")) return fit_record(order, parameters, si_unit);
  return fit(order,
             parameters.has("sea") ? read_sea(parameters.object("sea")) : read_table(parameters.object("spectrum")));
}

void report(const Binding& binding, const ShapingFit& fit, const std::string& si_unit) {
  const auto& filter = fit.filter;
  for (Eigen::Index k = 0; k < filter.omega.size(); ++k) {
    const std::string number = filter.omega.size() == 1 ? "" : " " + std::to_string(k + 1);
    binding.figure("omega" + number, filter.omega[k], "rad/s");
    binding.figure("zeta" + number, filter.zeta[k], "1");
  }
  binding.figure("sigma", filter.sigma, si_unit);
  binding.figure("significant amplitude, given", fit.given_significant, si_unit);
  binding.figure("significant amplitude, fitted", fit.model_significant, si_unit);
  binding.figure("peak, given", fit.given_peak, "rad/s");
  binding.figure("peak, fitted", fit.model_peak, "rad/s");
  binding.figure("resolution", fit.resolution, "rad/s");
  binding.figure("misfit", fit.misfit, "1");
  if (fit.is_good()) return;
  char text[200];
  std::snprintf(
      text, sizeof text,
      "the fit is poor: significant amplitude %.0f %% of the given, peak at %.3g rad/s instead of %.3g, %.0f %% of "
      "the area misplaced",
      100 * fit.model_significant / fit.given_significant, fit.model_peak, fit.given_peak, 100 * fit.misfit);
  binding.note(text);
}

ShapingFilter read_filter(const Parameters& parameters) {
  for (const char* name : {"omega", "zeta", "sigma"})
    if (!parameters.has(name))
      throw ComponentError(std::string("'") + name +
                           "' is missing; a motion is 'omega', 'zeta' and 'sigma', or a 'fit'");
  const ShapingFilter filter{parameters.vector("omega"), parameters.vector("zeta"), parameters.number("sigma")};
  if (filter.omega.size() != 1 && filter.omega.size() != 2)
    throw ComponentError("one frequency makes order 2, two make order 4; found " + std::to_string(filter.omega.size()),
                         "/omega");
  if (filter.zeta.size() != filter.omega.size()) throw ComponentError("one damping ratio for each frequency", "/zeta");
  return filter;
}

}  // namespace

std::vector<ParameterSpec> motion_parameters(const std::string& unit) {
  return {
      vector("omega", "rad/s").above(0).about("natural frequency, a list; two for order 4"),
      vector("zeta", "1").above(0).about("damping ratio, one for each frequency"),
      number("sigma", unit).at_least(0).about("standard deviation of the angle in the steady state"),
      fit_spec(unit).about("data to which frequencies, damping and sigma are fitted, instead of their values"),
  };
}

ShapingFilter read_motion(const Binding& binding, const std::string& si_unit) {
  const Parameters& parameters = binding.parameters();
  if (!parameters.has("fit")) return read_filter(parameters);
  for (const char* name : {"omega", "zeta", "sigma"})
    if (parameters.has(name)) throw ComponentError("a fitted value cannot be given as well", std::string("/") + name);
  const ShapingFit fit = read_fit(parameters.object("fit"), si_unit);
  report(binding, fit, si_unit);
  return fit.filter;
}

}  // namespace binnacle::ship_motion
