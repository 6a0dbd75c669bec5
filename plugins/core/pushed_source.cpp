// SPDX-License-Identifier: Apache-2.0
#include "pushed_source.hpp"

namespace binnacle::core {

namespace {

FieldKind kind_of(const std::string& text) {
  return text == "rate" ? FieldKind::rate : text == "increment" ? FieldKind::increment : FieldKind::level;
}

}  // namespace

ComponentSpec PushedSource::spec() {
  ComponentSpec spec;
  spec.type = "pushed";
  spec.summary = "A channel that the embedding program fills, sample by sample.";
  spec.parameters = {
      parameter::map(
          "fields",
          parameter::object(
              "field",
              {parameter::number("unit", "*").required().about("SI unit of the numbers"),
               parameter::choice("kind", {"level", "rate", "increment"})
                   .defaults("\"level\"")
                   .about(
                       "level: value at an instant; rate: mean over an interval; increment: integral over an interval"),
               parameter::boolean("per_row").defaults("false").about("whether each row of the sample has a value")}))
          .required()
          .about("fields per epoch, in the order in which they are pushed"),
      parameter::integer("max_rows")
          .at_least(0)
          .at_most(1024)
          .defaults("0")
          .about("largest number of rows of a sample"),
      parameter::list("covariance", parameter::text("component"))
          .about("error components of an attached covariance, in order, for example \"position.north\""),
  };
  spec.example =
      R"json({"fields": {"wx": {"unit": "rad", "kind": "increment"}, "wy": {"unit": "rad", "kind": "increment"}}})json";
  return spec;
}

PushedSource::PushedSource(const Binding& binding) {
  const Parameters& parameters = binding.parameters();
  ChannelDeclaration channel;
  for (const auto& [name, value] : parameters.members("fields")) {
    const Parameters field(value);
    for (const auto& [key, member] : value.members)
      if (key == "unit") {
        if (member.number != 1.0)
          throw ComponentError("pushed samples are in SI; this unit is " + member.text + " times a factor",
                               "/fields/" + name + "/unit");
        channel.fields.push_back(
            {name, member.text, kind_of(field.text("kind")), false, field.boolean("per_row"), "pushed"});
      }
  }
  channel.max_rows = static_cast<int>(parameters.integer("max_rows"));
  if (parameters.has("covariance"))
    for (const auto& component : parameters.list("covariance")) channel.covariance.push_back({component.text, ""});
  declaration_.emits(std::move(channel));
}

}  // namespace binnacle::core
