// SPDX-License-Identifier: Apache-2.0
// Which attitude algorithm a config chose.
#include "attitude/choice.hpp"

#include <string>

namespace binnacle::attitude {

namespace {

constexpr const char* keeps_powers = "power_";
constexpr const char* keeps_terms = "terms_";

Truncation read_truncation(const std::string& text) {
  if (text.starts_with(keeps_powers)) return Truncation::at_power(text.back() - '0');
  if (text.starts_with(keeps_terms)) return Truncation::after_terms(text.back() - '0');
  return Truncation::exact();
}

}  // namespace

ParameterSpec choice_parameter() {
  using namespace parameter;
  auto samples = integer("samples").at_least(1).at_most(most_samples);
  samples.text =
      "gyro samples per update, equal to 'samples_per_step'; default: one sample per update, for any number of samples "
      "per step";
  return object(
             "attitude",
             {std::move(samples),
              choice("form", {"coning", "polynomial"})
                  .defaults("\"coning\"")
                  .about("coefficients for 3 and 4 samples: optimal for coning motion, or for polynomial rates"),
              boolean("previous")
                  .defaults("true")
                  .about(
                      "whether an update from one sample uses the previous sample to estimate the change of the rates"),
              choice("precision", {"double", "float"})
                  .defaults("\"double\"")
                  .about("floating-point precision of the rotation vector and the quaternion"),
              choice("truncation", {"exact", "power_2", "power_4", "power_5", "terms_2", "terms_4", "terms_5"})
                  .defaults("\"exact\"")
                  .about("truncation of the update quaternion's series: by the highest power of the angle, or by the "
                         "number of terms of each series")})
      .defaults("{}")
      .about("algorithm of the attitude update");
}

Algorithm read_choice(const Binding& binding) {
  const Parameters parameters = binding.parameters().object("attitude");
  Algorithm::Choice choice;
  choice.uses_previous = parameters.boolean("previous");
  choice.form = parameters.text("form") == "polynomial" ? Form::polynomial : Form::coning;
  choice.update.precision = parameters.text("precision") == "float" ? Precision::float_ : Precision::double_;
  choice.update.truncation = read_truncation(parameters.text("truncation"));
  if (parameters.has("samples")) {
    choice.samples = static_cast<int>(parameters.integer("samples"));
    if (choice.samples != binding.samples_per_step())
      throw ComponentError("the attitude algorithm takes " + std::to_string(choice.samples) +
                               " samples, and 'samples_per_step' of the process is " +
                               std::to_string(binding.samples_per_step()) + ": make them equal",
                           "/attitude/samples");
  }
  return Algorithm(choice);
}

}  // namespace binnacle::attitude
