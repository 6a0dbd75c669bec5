// SPDX-License-Identifier: Apache-2.0
// robustness: hostile numbers, parameters and memory meet a typed refusal or finite output, never a crash.
#include <algorithm>
#include <cmath>

#include "fixture.hpp"
#include "miniature.hpp"
#include "tried_roles.hpp"

namespace binnacle::conform {

namespace {

void finite(Trial& trial) {
  const auto subject = fixture_of_example(trial);
  const auto inputs = subject->hostile_finite();
  if (inputs.empty()) Trial::not_applicable("it takes no numbers besides its ports'");
  for (const auto& input : inputs) {
    auto memory = subject->fresh_memory();
    Answer answer;
    try {
      answer = subject->hostile(input, memory.data());
    } catch (const std::exception& error) {
      trial.fail("input '", input, "': an exception crosses: ", error.what());
      return;
    }
    if (trial.role == Role::transform) continue;  // it may have nothing to say of a field
    trial.expect(!answer.result || answer.is_finite(), "input '", input, "': neither refused nor finite");
    trial.expect(answer.damage.empty(), "input '", input, "': ", answer.damage);
  }
}

void nonfinite(Trial& trial) {
  const auto subject = fixture_of_example(trial);
  const auto inputs = subject->hostile_nonfinite();
  if (inputs.empty()) Trial::not_applicable("it takes no numbers besides its ports'");
  for (const auto& input : inputs) {
    auto memory = subject->fresh_memory();
    try {
      const Answer answer = subject->hostile(input, memory.data());
      trial.expect(answer.damage.empty(), "input '", input, "': ", answer.damage);
    } catch (const std::exception& error) {
      trial.fail("input '", input, "': an exception crosses: ", error.what());
      return;
    }
  }
}

void memory(Trial& trial) {
  const auto subject = fixture_of_example(trial);
  if (subject->memory_bytes() == 0) Trial::not_applicable("it has no memory");
  for (int repeat = 0; repeat < trial.repeats(20); ++repeat) {
    auto random = trial.random(800 + static_cast<std::uint64_t>(repeat));
    std::vector<std::byte> bytes(subject->memory_bytes());
    for (auto& byte : bytes) byte = static_cast<std::byte>(random());
    try {
      for (std::uint64_t k = 0; k < 3; ++k) subject->turn(k, bytes.data(), 0.0);
    } catch (const std::exception& error) {
      trial.fail("with random bytes as memory an exception crosses: ", error.what());
      return;
    }
  }
}

// ---- parameters

/// A quantity as a config may write it: text with a unit, and where the unit is not one to write (that of a port's block,
/// or any), a number in SI.
Json quantity(double number, const std::string& unit) {
  if (unit == "*" || unit.rfind('@', 0) == 0) return number;
  std::ostringstream text;
  text.precision(17);
  text << number;
  if (!unit.empty() && unit != "1") text << " " << unit;
  return text.str();
}

double inside(const ParameterSpec& spec, std::mt19937_64& random) {
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const double low = std::isfinite(spec.minimum) ? spec.minimum : -10.0;
  const double high = std::isfinite(spec.maximum) ? spec.maximum : std::max(low, 0.0) + 10.0;
  switch (random() % 3) {
    case 0:
      if (std::isfinite(spec.minimum) && !spec.minimum_excluded) return spec.minimum;
      break;
    case 1:
      if (std::isfinite(spec.maximum) && !spec.maximum_excluded) return spec.maximum;
      break;
    default: break;
  }
  return low + (high - low) * (0.001 + 0.998 * uniform());
}

/// A value that the spec allows; null where none can be made up.
Json allowed(const ParameterSpec& spec, std::mt19937_64& random) {
  switch (spec.type) {
    case ParameterType::number: return quantity(inside(spec, random), spec.unit);
    case ParameterType::integer: {
      const double low = std::ceil(std::isfinite(spec.minimum) ? spec.minimum : 0);
      const double high = std::floor(std::isfinite(spec.maximum) ? std::min(spec.maximum, low + 20) : low + 20);
      return static_cast<std::int64_t>(low) +
             static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1));
    }
    case ParameterType::boolean: return random() % 2 == 0;
    case ParameterType::choice: return spec.choices[random() % spec.choices.size()];
    case ParameterType::vector: {
      if (!spec.size_of_port.empty()) return quantity(inside(spec, random), spec.unit);  // one stands for all
      if (spec.size <= 0) return nullptr;
      Json list = Json::array();
      for (int i = 0; i < spec.size; ++i) list.push_back(quantity(inside(spec, random), spec.unit));
      return list;
    }
    default: return nullptr;
  }
}

/// The example with some of its parameters made up; the example itself where none was.
Json made_up_settings(const ComponentSpec& spec, const Json& example, std::mt19937_64& random) {
  Json settings = example;
  for (const auto& parameter : spec.parameters) {
    if (random() % 2) continue;
    const Json value = allowed(parameter, random);
    if (!value.is_null()) settings[parameter.name] = value;
  }
  return settings;
}

/// Composes with the settings and makes a few calls.
void use(Trial& trial, const ComponentType& type, const Catalog& catalog, const Json& settings) {
  trial.stage("constructor");
  const auto composition = compose(trial, miniature(trial, type, catalog, settings));
  trial.stage("");
  if (trial.role == Role::sink) return;
  const auto subject = fixture(trial, composition);
  auto memory = subject->fresh_memory();
  for (std::uint64_t k = 0; k < 3; ++k) {
    const Answer answer = subject->turn(k, memory.data(), 0.0);
    if (trial.role == Role::source || trial.role == Role::transform) continue;
    if (!trial.expect(!answer.result || answer.is_finite(), "with ", settings.dump(),
                      " it gives numbers that are not finite"))
      return;
  }
}

bool own_words(Trial& trial, const Json& settings, const std::string& message) {
  return trial.expect(message.find(" threw: ") == std::string::npos, "with ", settings.dump(), ": ", message,
                      "; throw ComponentError for what is refused");
}

/// Parameters may exclude each other: then they are refused with a pointer at the component, and by its own words.
bool examine(Trial& trial, const Json& settings, const Error& refusal) {
  const std::string pointer = component_pointer(trial.role);
  for (const auto& item : refusal.diagnostics().items()) {
    if (item.severity != Severity::error) continue;  // such as the guard's, that the library was built otherwise
    if (!trial.expect(item.pointer.rfind(pointer, 0) == 0 || item.pointer.rfind("/filters", 0) == 0, "with ",
                      settings.dump(), " the refusal points at '", item.pointer, "': ", item.message) ||
        !own_words(trial, settings, item.message))
      return false;
  }
  return true;
}

void parameters(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  if (type.spec.parameters.empty()) Trial::not_applicable("it has no parameters");
  const Json example = example_of(type.spec);
  auto random = trial.random(900);
  int tried = 0, accepted = 0;
  std::string last;
  for (int repeat = 0; repeat < trial.repeats(10); ++repeat) {
    const Json settings = made_up_settings(type.spec, example, random);
    if (settings == example) continue;
    ++tried;
    try {
      use(trial, type, catalog, settings);
      ++accepted;
    } catch (const Error& refusal) {
      if (!examine(trial, settings, refusal)) return;
      last = refusal.what();
    } catch (const OpenRefused& refusal) {
      if (!own_words(trial, settings, refusal.what())) return;
      last = refusal.what();
    }
  }
  if (tried == 0) Trial::skip("it has no parameter that can be made up");
  if (accepted == 0)
    Trial::skip("none of " + std::to_string(tried) +
                " settings that were made up is accepted; the last is refused: " + last);
}

/// A value that the spec does not allow.
Json forbidden(const ParameterSpec& spec, std::uint64_t which) {
  if (which % 3 == 0) return Json::object({{"no_such_key_as_this", 1}});
  if (spec.type == ParameterType::number || spec.type == ParameterType::integer) {
    if (which % 3 == 1 && std::isfinite(spec.minimum)) return quantity(spec.minimum - 1, spec.unit);
    if (std::isfinite(spec.maximum)) return quantity(spec.maximum + 1, spec.unit);
    return "1 furlong";
  }
  if (spec.type == ParameterType::choice) return "none_of_the_choices";
  if (spec.type == ParameterType::boolean) return "perhaps";
  return Json::object({{"no_such_key_as_this", 1}});
}

void refusals(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  const Json example = example_of(type.spec);
  if (type.spec.parameters.empty()) Trial::not_applicable("it has no parameters");
  for (const auto& parameter : type.spec.parameters)
    for (std::uint64_t which = 0; which < 3; ++which) {
      Json settings = example;
      settings[parameter.name] = forbidden(parameter, which);
      const std::string pointer = component_pointer(trial.role) + "/" + parameter.name;
      try {
        const auto composition = compose(trial, miniature(trial, type, catalog, settings));
        const bool takes_anything = parameter.type == ParameterType::map || parameter.type == ParameterType::object ||
                                    parameter.type == ParameterType::matrix;
        trial.expect(takes_anything, "accepts ", settings[parameter.name].dump(), " as '", parameter.name, "'");
      } catch (const Error& refusal) {
        const auto& items = refusal.diagnostics().items();
        trial.expect(std::any_of(items.begin(), items.end(),
                                 [&](const auto& item) {
                                   return item.pointer.rfind(component_pointer(trial.role), 0) == 0;
                                 }),
                     "the refusal of ", settings[parameter.name].dump(), " as '", parameter.name,
                     "' does not point at ", pointer, ": ", refusal.what());
      }
    }
}

}  // namespace

std::vector<Check> robustness_checks() {
  return {
      check("robustness.finite", 3, called_roles, {"life.repeatable"},
            "zero, tiny, huge numbers, dt 0, 1e-9, 1e6, negative: refused or finite", finite),
      check("robustness.nonfinite", 3, called_roles, {"life.repeatable"},
            "NaN and infinity: no crash, no exception, nothing written elsewhere", nonfinite),
      check("robustness.memory", 4, called_roles, {"life.repeatable", "life.snapshot"},
            "random bytes as memory do not crash", memory),
      check("robustness.parameters", 3, every_role, {"life.create", "life.repeatable"},
            "random allowed parameters, bounds included, work or are refused with a pointer", parameters),
      check("robustness.refusals", 3, every_role, {"life.create"},
            "parameters that are not allowed are refused with a pointer", refusals),
  };
}

}  // namespace binnacle::conform
