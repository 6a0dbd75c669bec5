// SPDX-License-Identifier: Apache-2.0
// JSON Schema (draft-07) of a config: what the checker accepts, as far as it shows without plugging blocks together.
#include "document/document.hpp"

#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include "binnacle/catalog.hpp"

namespace binnacle::document {

using Json = nlohmann::ordered_json;

namespace {

Json text_schema(const char* description) { return {{"type", "string"}, {"description", description}}; }

/// The schema with what an editor shows of it, and the reference prints.
Json described(const char* description, Json schema) {
  schema["description"] = description;
  return schema;
}

Json ref(const std::string& name) { return {{"$ref", "#/definitions/" + name}}; }

Json closed_object(Json properties, const std::vector<std::string>& required = {}) {
  Json schema{{"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
  if (!required.empty()) schema["required"] = required;
  return schema;
}

/// What extends another object is a patch: which of its parts must be there does not show in it.
Json or_patch(Json whole) {
  Json schema{{"if", {{"type", "object"}, {"required", {"extends"}}}}};
  schema["then"] = Json::object();
  schema["else"] = std::move(whole);
  return schema;
}

/// Free keys, each with such a value.
Json named(const Json& value) { return or_patch({{"type", "object"}, {"additionalProperties", value}}); }

Json some_named(const Json& value) {
  return or_patch({{"type", "object"}, {"minProperties", 1}, {"additionalProperties", value}});
}

Json list_of(const Json& items) { return {{"type", "array"}, {"items", items}}; }

// ---- parameters

void add_bounds(const ParameterSpec& spec, Json& schema) {
  if (std::isfinite(spec.minimum)) schema[spec.minimum_excluded ? "exclusiveMinimum" : "minimum"] = spec.minimum;
  if (std::isfinite(spec.maximum)) schema[spec.maximum_excluded ? "exclusiveMaximum" : "maximum"] = spec.maximum;
}

/// A number, or text that begins with one, or with a variable that may hold one.
Json quantity_schema(const ParameterSpec& spec) {
  Json schema{{"type", {"number", "string"}}};
  if (spec.unit != "*") schema["pattern"] = R"(^[ \t]*[+-]?\.?[0-9]|\$\{)";
  add_bounds(spec, schema);
  return schema;
}

Json array_of(const Json& items, int size) {
  Json schema = list_of(items);
  if (size != ParameterSpec::any_size) schema["minItems"] = schema["maxItems"] = size;
  return schema;
}

Json vector_schema(const ParameterSpec& spec) {
  const Json element = quantity_schema(spec);
  const Json list = array_of(element, spec.size_of_port.empty() ? spec.size : ParameterSpec::any_size);
  if (spec.size == ParameterSpec::any_size && spec.size_of_port.empty()) return list;
  return {{"anyOf", {element, list}}};
}

Json object_schema(const std::vector<ParameterSpec>& members);

Json shape_of(const ParameterSpec& spec) {
  switch (spec.type) {
    case ParameterType::number:
    case ParameterType::time: return quantity_schema(spec);
    case ParameterType::integer: {
      Json schema{{"type", "integer"}};
      add_bounds(spec, schema);
      return schema;
    }
    case ParameterType::boolean: return {{"type", "boolean"}};
    case ParameterType::text: return {{"type", "string"}};
    case ParameterType::path: return {{"type", "string"}, {"minLength", 1}};
    case ParameterType::choice: return {{"enum", spec.choices}};
    case ParameterType::vector: return vector_schema(spec);
    case ParameterType::matrix: {
      Json schema = array_of(array_of(quantity_schema(spec), spec.cols), spec.size);
      if (spec.size == ParameterSpec::any_size) schema["minItems"] = 1;
      return schema;
    }
    case ParameterType::list: return list_of(shape_of(spec.members.front()));
    case ParameterType::map: return named(shape_of(spec.members.front()));
    case ParameterType::object: return object_schema(spec.members);
  }
  return Json::object();
}

Json parameter_schema(const ParameterSpec& spec) {
  Json schema = shape_of(spec);
  schema["description"] = (spec.text.empty() ? "" : spec.text + " ") + "(" + requirement_text(spec) + ")";
  if (!spec.default_json.empty()) schema["default"] = Json::parse(spec.default_json, nullptr, false);
  return schema;
}

void add_parameters(const std::vector<ParameterSpec>& specs, Json& properties, std::vector<std::string>& required) {
  for (const ParameterSpec& spec : specs) {
    properties[spec.name] = parameter_schema(spec);
    if (spec.is_required) required.push_back(spec.name);
  }
}

Json object_schema(const std::vector<ParameterSpec>& members) {
  Json properties = Json::object();
  std::vector<std::string> required;
  add_parameters(members, properties, required);
  return or_patch(closed_object(std::move(properties), required));
}

// ---- components

/// The keys that a component has besides its parameters, by its place in the config.
class ReservedKeys {
 public:
  ReservedKeys(const ComponentSpec& spec, Role role) : spec_(spec) {
    switch (role) {
      case Role::state_block: add_block_keys(); break;
      case Role::derived_block: add_ports(); break;
      case Role::process_model: add_process_keys(); break;
      case Role::measurement_model: add_measurement_keys(); break;
      case Role::noise_estimator: properties["learn_from_gated"] = ref("learn_from_gated"); break;
      case Role::source: add_source_keys(); break;
      case Role::transform:
      case Role::sink: add_input_keys(); break;
    }
  }

  Json properties = Json::object();
  std::vector<std::string> required;

 private:
  void add_source_keys() {
    const Json time = ref("quantity");
    const auto form = [](const char* name, const Json& schema) {
      return or_patch(closed_object({{name, schema}}, {name}));
    };
    properties["latency"] =
        described("how long after its time a sample arrives",
                  {{"anyOf",
                    {time, form("field", {{"type", "string"}}), form("exponential", time),
                     form("uniform", {{"type", "array"}, {"items", time}, {"minItems", 2}, {"maxItems", 2}}),
                     form("normal", closed_object({{"mean", time}, {"sigma", time}}))}}});
  }

  void add_block_keys() {
    for (const char* key : {"init", "sigma", "estimate", "consider", "hold"}) properties[key] = ref(key);
  }

  void add_ports() {
    Json ports = Json::object();
    std::vector<std::string> needed;
    for (const PortSpec& port : spec_.ports) {
      ports[port.name] = {{"type", "string"}, {"description", port.text + " (" + port.kind + ")"}};
      if (!port.is_optional) needed.push_back(port.name);
    }
    if (!needed.empty()) required.push_back("blocks");
    properties["blocks"] = closed_object(std::move(ports), needed);
  }

  static Json mapping(const std::vector<FieldSpec>& fields) {
    Json names = Json::object();
    for (const FieldSpec& field : fields) names[field.name] = {{"type", "string"}, {"description", field.text}};
    return closed_object(std::move(names));
  }

  void add_process_keys() {
    add_ports();
    add_auxiliary_keys();
    properties["samples_per_step"] = ref("samples_per_step");
    if (spec_.fields.empty()) return;
    properties["input"] = text_schema("the channel that drives the filter");
    required.push_back("input");
  }

  void add_measurement_keys() {
    add_ports();
    add_auxiliary_keys();
  }

  void add_auxiliary_keys() {
    properties["fields"] = mapping(all_fields());
    if (spec_.inputs.empty()) return;
    properties["inputs"] = inputs();
    if (needs_named_inputs()) required.push_back("inputs");
  }

  std::vector<FieldSpec> all_fields() const {
    std::vector<FieldSpec> fields = spec_.fields;
    for (const ChannelPort& input : spec_.inputs) fields.insert(fields.end(), input.fields.begin(), input.fields.end());
    return fields;
  }

  void add_input_keys() {
    properties["fields"] = mapping(all_fields());
    properties["input"] = text_schema("name of a channel");
    properties["inputs"] = inputs();
  }

  bool needs_named_inputs() const {
    for (const ChannelPort& input : spec_.inputs) {
      if (!input.is_optional) return true;
    }
    return false;
  }

  Json inputs() const {
    Json ports = Json::object();
    for (const ChannelPort& input : spec_.inputs) ports[input.name] = {{"type", "string"}, {"description", input.text}};
    return closed_object(std::move(ports));
  }

  const ComponentSpec& spec_;
};

std::string definition_name(const ComponentType& type) { return type.plugin + "." + type.spec.type; }

Json component_schema(const ComponentType& type, const Json& names) {
  ReservedKeys reserved(type.spec, type.role);
  Json properties{{"type", {{"enum", names}}}};
  for (const auto& [key, schema] : reserved.properties.items()) properties[key] = schema;
  std::vector<std::string> required = reserved.required;
  required.insert(required.begin(), "type");
  add_parameters(type.spec.parameters, properties, required);
  Json schema = closed_object(std::move(properties), required);
  if (!type.spec.summary.empty()) schema["description"] = type.spec.summary;
  return schema;
}

/// "type" decides which of the definitions holds: an error is then about that one, not about all.
Json choice_of(const std::vector<std::pair<Json, std::string>>& types) {
  Json all = Json::array();
  for (const auto& [names, definition] : types) all.push_back(names);
  Json every_name = Json::array();
  for (const Json& names : all)
    for (const Json& name : names) every_name.push_back(name);
  Json schema{{"type", "object"}, {"required", {"type"}}, {"properties", {{"type", {{"enum", every_name}}}}}};
  if (types.empty()) return schema;
  schema["allOf"] = Json::array();
  for (const auto& [names, definition] : types) {
    schema["allOf"].push_back(
        {{"if", {{"required", {"type"}}, {"properties", {{"type", {{"enum", names}}}}}}}, {"then", ref(definition)}});
  }
  return schema;
}

constexpr const char* place_of(Role role) {
  switch (role) {
    case Role::state_block: return "state_block";
    case Role::process_model: return "process_model";
    case Role::measurement_model: return "measurement_model";
    case Role::derived_block: return "derived_block";
    case Role::noise_estimator: return "noise_estimator";
    case Role::source: return "source";
    case Role::transform: return "transform";
    case Role::sink: return "sink";
  }
  return "";
}

void add_components(const Catalog& catalog, Json& definitions) {
  std::map<Role, std::vector<std::pair<Json, std::string>>> choices;
  for (const ComponentType* type : catalog.types()) {
    Json names = Json::array({type->full_name()});
    if (catalog.find(type->role, type->spec.type) == type) names.push_back(type->spec.type);
    definitions[definition_name(*type)] = component_schema(*type, names);
    if (type->role == Role::measurement_model) {
      // Alone it stands beside the keys of a measurement, in a stack it does not.
      Json alone = definitions[definition_name(*type)];
      for (const char* key : {"channel", "noise", "gate", "recover", "withhold", "update"})
        alone["properties"][key] = ref(key);
      alone["required"].push_back("channel");
      definitions[definition_name(*type) + ".alone"] = std::move(alone);
    }
    choices[type->role].emplace_back(names, definition_name(*type));
  }
  for (const Role role : all_roles) definitions[place_of(role)] = or_patch(choice_of(choices[role]));
  for (auto& [names, definition] : choices[Role::measurement_model]) definition += ".alone";
  definitions["lone_measurement"] = or_patch(choice_of(choices[Role::measurement_model]));
}

// ---- what is no component's

void add_value_definitions(Json& definitions) {
  const Json quantity = quantity_schema(parameter::number("", "1"));
  const Json name = {{"type", "string"}};
  definitions["quantity"] = quantity;
  definitions["channel"] = text_schema("name of a channel");
  definitions["time"] = {{"type", {"number", "string"}}, {"description", "\"228 s\", \"start+60 s\" or seconds"}};
  definitions["window"] = {{"type", "array"}, {"items", ref("time")}, {"minItems", 2}, {"maxItems", 2}};
  Json again = closed_object({{"channel", name},
                              {"fields", named(name)},
                              {"max_age", quantity},
                              {"covariance", {{"anyOf", {name, list_of(name)}}}}},
                             {"channel"});
  definitions["init"] = {
      {"description", "initial value: by output, as a list, one for all, or from a channel"},
      {"anyOf",
       {closed_object({{"channel", name},
                       {"fields", named(name)},
                       {"max_age", quantity},
                       {"covariance", {{"anyOf", {name, list_of(name)}}}},
                       {"again",
                        {{"description", "start anew from a new sample of this channel (true) or of another one"},
                         {"anyOf", {{{"type", "boolean"}}, again}}}}},
                      {"channel"}),
        {{"type", "object"}, {"not", {{"required", {"channel"}}}}, {"additionalProperties", quantity}},
        list_of(quantity),
        quantity}}};
  definitions["sigma"] = {{"description", "initial standard deviation: by component, as a list, or one for all"},
                          {"anyOf", {named(quantity), list_of(quantity), quantity}}};
}

/// Keys of a block, beside its parameters.
void add_block_definitions(Json& definitions) {
  const Json name = {{"type", "string"}};
  const Json components = {{"anyOf", {{{"type", "boolean"}}, name, list_of(name)}}};
  definitions["estimate"] =
      described("error components that are estimated (default: all); the others are frozen", components);
  definitions["consider"] =
      described("components that keep their covariance and are never corrected (Schmidt)", components);
  definitions["hold"] = described("frozen components do not move with their process", {{"type", "boolean"}});
  definitions["learn_from_gated"] =
      described("what a gated sample taught is kept; else it is taken back", {{"type", "boolean"}});
  definitions["samples_per_step"] = described("inputs that go into one step, for multi-sample attitude algorithms",
                                              {{"type", "integer"}, {"minimum", 1}, {"maximum", 16}});
}

void add_measurement_definitions(Json& definitions) {
  const Json quantity = quantity_schema(parameter::number("", "1"));
  const Json probability{{"type", {"number", "string"}}, {"exclusiveMinimum", 0}, {"exclusiveMaximum", 1}};
  definitions["gate"] = {{"description", "probability with which a right sample passes, or a right row or key"},
                         {"anyOf",
                          {probability,
                           closed_object({{"probability", probability}, {"by", {{"enum", {"sample", "row", "key"}}}}},
                                         {"probability"})}}};
  definitions["noise"] =
      described("a noise estimator: R from what the residuals were, or a robust loss", ref("noise_estimator"));
  definitions["recover"] = described(
      "how a filter that locks the measurement out is opened again: after so many refusals in a row, or after a time "
      "where "
      "others contradict it; along what the measurement sees, or by these 1-sigma; false: never",
      {{"anyOf",
        {{{"const", false}},
         closed_object(
             {{"after", {{"type", "integer"}, {"minimum", 1}}}, {"against", ref("time")}, {"inflate", named(quantity)}},
             {})}}});
  const Json windows = list_of(ref("window"));
  definitions["withhold"] = {
      {"description", "samples kept from the filter and scored instead: spans of time, or every so many"},
      {"anyOf", {windows, closed_object({{"every", {{"type", "integer"}, {"minimum", 1}}}, {"windows", windows}})}}};
  definitions["update"] =
      described("how a sample corrects the state: one linearization (ekf), Gauss-Newton's method, or sigma points",
                {{"anyOf",
                  {{{"enum", {"ekf", "iterated", "unscented"}}},
                   closed_object({{"type", {{"enum", {"ekf", "unscented"}}}}}, {"type"}),
                   closed_object({{"type", {{"const", "iterated"}}},
                                  {"max", {{"type", "integer"}, {"minimum", 1}, {"maximum", 1000}}},
                                  {"tolerance",
                                   {{"type", {"number", "string"}}, {"exclusiveMinimum", 0}, {"exclusiveMaximum", 1}}}},
                                 {"type"})}}});
  definitions["stacked_measurement"] =
      or_patch(closed_object({{"stack", described("measurement models whose rows make one update",
                                                  some_named(ref("measurement_model")))},
                              {"channel", ref("channel")},
                              {"noise", ref("noise")},
                              {"gate", ref("gate")},
                              {"recover", ref("recover")},
                              {"withhold", ref("withhold")},
                              {"update", ref("update")}},
                             {"stack", "channel"}));
  definitions["measurement"] = {{"if", {{"required", {"stack"}}}},
                                {"then", ref("stacked_measurement")},
                                {"else", ref("lone_measurement")}};
}

/// Limits of a filter's monitors.
void add_trust_definition(Json& definitions) {
  const Json off{{"const", false}}, on{{"type", "boolean"}}, name{{"type", "string"}};
  const auto limit = [&](const char* unit, const char* about) {
    return described(about, {{"anyOf", {off, quantity_schema(parameter::number("", unit))}}});
  };
  definitions["trust"] = {
      {"description", "limits of the filter's monitors, from which its verdict follows; false: no monitor counts"},
      {"anyOf",
       {off,
        closed_object(
            {{"false_alarm", limit("1", "probability that innovations of a right filter fail, in ten minutes")},
             {"nis", described("whether NIS is tested", on)},
             {"bias", described("whether the mean of innovations is tested", on)},
             {"correlation", described("whether innovations are tested for correlation in time", on)},
             {"beyond_reason", limit("1", "NIS over its rows beyond which a filter is lost")},
             {"after", limit("1", "refusals in a row that are a lock-out")},
             {"refused", limit("1", "share of a measurement's rows beyond which a filter is lost")},
             {"hole", limit("s", "hole in the driving input beyond which a filter is doubtful")},
             {"silent", limit("s", "time without a sample of use beyond which a filter is doubtful")},
             {"frozen", limit("s", "time that the driving input repeats itself beyond which a filter is doubtful")},
             {"except", described("measurements that are not watched", {{"anyOf", {name, list_of(name)}}})}},
            {})}}};
}

void add_filter_definitions(Json& definitions) {
  const Json name = {{"type", "string"}};
  add_trust_definition(definitions);
  definitions["filter"] = or_patch(closed_object(
      {{"blocks", described("what is estimated", some_named(ref("state_block")))},
       {"derived",
        described("values computed from blocks, which models bind to as to blocks", named(ref("derived_block")))},
       {"process", described("how blocks move; each is advanced by exactly one", named(ref("process_model")))},
       {"measurements", described("what is seen of them; at one instant in this order", named(ref("measurement")))},
       {"trust", ref("trust")},
       {"longest_bridge", ref("quantity")},
       {"covariance", described("the form in which P is kept", {{"enum", {"joseph", "ud", "square_root"}}})},
       {"propagation",
        described("how x and P are propagated: by the models' Jacobians (ekf), or by sigma points through "
                  "the models",
                  {{"enum", {"ekf", "unscented"}}})},
       {"emit",
        described("when its channel has estimates: after accepted measurements, or after each step of its input too",
                  {{"enum", {"measurements", "input"}}})},
       {"history",
        described("how late a sample may be and is still applied at its time; `steps`: how many instants one arrival "
                  "may cost",
                  {{"anyOf",
                    {ref("quantity"), or_patch(closed_object({{"length", ref("quantity")},
                                                              {"steps", {{"type", "integer"}, {"minimum", 2}}}},
                                                             {"length"}))}}})},
       {"smoother",
        described("smooths the filter; what comes of it is the filter NAME.smoothed",
                  {{"anyOf",
                    {{{"const", "fixed_interval"}},
                     or_patch(closed_object(
                         {{"type", {{"const", "fixed_lag"}}}, {"lag", ref("quantity")}, {"every", ref("quantity")}},
                         {"type", "lag"})),
                     or_patch(closed_object({{"type", {{"const", "fixed_interval"}}},
                                             {"iterations", {{"type", "integer"}, {"minimum", 0}, {"maximum", 100}}}},
                                            {"type"}))}}})},
       {"implied_states", described("the value of a block that one measurement implies, all else in it taken from the "
                                    "filter; scored and recorded",
                                    named(or_patch(closed_object({{"measurement", described("whose samples", name)},
                                                                  {"block", described("what they imply", name)}},
                                                                 {"measurement", "block"}))))}},
      {"blocks"}));
  definitions["reference"] = {
      {"anyOf",
       {closed_object({{"withheld", described("a measurement with withheld samples", name)},
                       {"filter", described("whose; needed where several have it", name)}},
                      {"withheld"}),
        closed_object({{"channel", described("the channel with the truth", name)},
                       {"blocks", described("FILTER/BLOCK: the channel's fields for its outputs",
                                            named({{"anyOf", {list_of(name), named(name)}}}))},
                       {"invalid", described("a value that means there is none", {{"type", "number"}})}},
                      {"channel", "blocks"})}}};
}

Json evaluate_schema() {
  const Json name = {{"type", "string"}};
  const Json metric = {{"anyOf", {name, closed_object({{"metric", name}, {"unit", name}}, {"metric"})}}};
  const Json window_of_filter = closed_object({{"filter", name}, {"span", ref("window")}}, {"span"});
  return closed_object({{"after", described("nothing earlier is scored", ref("time"))},
                        {"until", described("nothing later is scored", ref("time"))},
                        {"estimates", described("of filters with history: what is scored and recorded",
                                                {{"enum", {"settled", "live"}}})},
                        {"windows", described("spans of time that are scored on their own too: [from, to]",
                                              named({{"anyOf", {ref("window"), window_of_filter}}}))},
                        {"metrics", described("FILTER/BLOCK.OUTPUT/STATISTIC, printed by name",
                                              {{"anyOf", {metric, list_of(metric)}}})}});
}

Json sections() {
  const Json name = {{"type", "string"}};
  return {{"binnacle", {{"const", 1}, {"description", "version of the config's format"}}},
          {"title", described("one line, for people", name)},
          {"description", described("anything, for people", Json::object())},
          {"extends", described("a config that this one is merged over (RFC 7386), or several",
                                {{"anyOf", {name, list_of(name)}}})},
          {"plugins", described("where else plugins are searched for",
                                list_of({{"type", "string"}, {"description", "a plugin file, or a folder of them"}}))},
          {"vars", described("text for \"${NAME}\" anywhere in the config; --var NAME=TEXT overrides it",
                             {{"type", "object"}})},
          {"sources", described("where samples come from: files, simulators", named(ref("source")))},
          {"transforms", described("what makes samples out of samples", named(ref("transform")))},
          {"filters", described("the filters; a later one may read an earlier one's estimates as a channel",
                                some_named(ref("filter")))},
          {"sinks", described("where samples go", named(ref("sink")))},
          {"reference", described("what the filters are scored against",
                                  {{"anyOf", {ref("reference"), list_of(ref("reference"))}}})},
          {"evaluate", described("when and by what the errors are scored", evaluate_schema())},
          {"record",
           described("what --out records",
                     closed_object({{"every", described("one record for every multiple of this after the first, of the "
                                                        "instant nearest to it; else every step",
                                                        ref("quantity"))}}))},
          {"study", described("variants, runs and tables: see the guide to studies", {{"type", "object"}})},
          {"covariance",
           described("truth models and outputs: see the guide to covariance analysis", {{"type", "object"}})},
          {"tune", described("parameters and objective: see the guide to tuning", {{"type", "object"}})},
          {"metrics", described("what a study reports of every run, as \"metrics\" of \"study\"", Json::object())}};
}

}  // namespace

Json schema(const Catalog& catalog) {
  Json definitions = Json::object();
  add_components(catalog, definitions);
  add_value_definitions(definitions);
  add_block_definitions(definitions);
  add_measurement_definitions(definitions);
  add_filter_definitions(definitions);
  const Json whole = sections();
  Json any = Json::object();
  for (const auto& [key, section] : whole.items()) any[key] = Json::object();
  return {{"$schema", "http://json-schema.org/draft-07/schema#"},
          {"title", "Binnacle config"},
          {"type", "object"},
          {"if", {{"required", {"extends"}}}},
          {"then", closed_object(any)},
          {"else", closed_object(whole, {"binnacle", "filters"})},
          {"definitions", std::move(definitions)}};
}

}  // namespace binnacle::document
