// SPDX-License-Identifier: Apache-2.0
// JSON Schema (draft-07) of a config: what the checker accepts, as far as it shows without plugging blocks together.
#include "document/document.hpp"

#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include "binnacle/catalog.hpp"
#include "binnacle/local_axes.hpp"

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
  if (!spec.default_json.empty() && spec.default_json[0] != '/')
    schema["default"] = Json::parse(spec.default_json, nullptr, false);
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
      definitions[definition_name(*type)]["properties"]["systematic"] =
          described("a mean of its innovations that is no reason against the estimates, in the unit of its rows",
                    {{"type", {"number", "string"}}});
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
                        {{"description", "restart from a new sample of this channel (true) or of another channel"},
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
  definitions["estimate"] = described("estimated error components (default: all); the others are frozen", components);
  definitions["consider"] =
      described("considered components: they keep their covariance and are never corrected (Schmidt)", components);
  definitions["hold"] = described("true: the process does not propagate frozen components", {{"type", "boolean"}});
  definitions["learn_from_gated"] =
      described("true: the estimator keeps what it learnt from a gated sample; false: it discards this",
                {{"type", "boolean"}});
  definitions["samples_per_step"] = described("number of input samples per step, for multi-sample attitude algorithms",
                                              {{"type", "integer"}, {"minimum", 1}, {"maximum", 16}});
}

void add_measurement_definitions(Json& definitions) {
  const Json quantity = quantity_schema(parameter::number("", "1"));
  const Json probability{{"type", {"number", "string"}}, {"exclusiveMinimum", 0}, {"exclusiveMaximum", 1}};
  definitions["gate"] = {{"description", "probability with which a correct sample, row or key passes"},
                         {"anyOf",
                          {probability,
                           closed_object({{"probability", probability}, {"by", {{"enum", {"sample", "row", "key"}}}}},
                                         {"probability"})}}};
  definitions["noise"] = described("noise estimator: R from past residuals, or a robust loss", ref("noise_estimator"));
  definitions["recover"] = described(
      "recovery of a filter that locks the measurement out: after this many refusals in a row, or after this time if "
      "other measurements contradict it; the covariance is increased along the measurement, or by these 1-sigma; "
      "false: no recovery",
      {{"anyOf",
        {{{"const", false}},
         closed_object({{"after", {{"type", "integer"}, {"minimum", 1}}},
                        {"against", ref("time")},
                        {"inflate", named(quantity)},
                        {"widen", {{"type", "boolean"}}}},
                       {})}}});
  const Json windows = list_of(ref("window"));
  definitions["withhold"] = {
      {"description", "samples withheld from the filter and scored instead: time windows, or every n-th sample"},
      {"anyOf", {windows, closed_object({{"every", {{"type", "integer"}, {"minimum", 1}}}, {"windows", windows}})}}};
  definitions["update"] =
      described("update method: one linearization (ekf), Gauss-Newton iterations, or sigma points",
                {{"anyOf",
                  {{{"enum", {"ekf", "iterated", "unscented"}}},
                   closed_object({{"type", {{"enum", {"ekf", "unscented"}}}}}, {"type"}),
                   closed_object({{"type", {{"const", "iterated"}}},
                                  {"max", {{"type", "integer"}, {"minimum", 1}, {"maximum", 1000}}},
                                  {"tolerance",
                                   {{"type", {"number", "string"}}, {"exclusiveMinimum", 0}, {"exclusiveMaximum", 1}}}},
                                 {"type"})}}});
  definitions["stacked_measurement"] =
      or_patch(closed_object({{"stack", described("measurement models whose rows are combined into one update",
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
      {"description", "limits of the filter's monitors, which determine its verdict; false: no monitoring"},
      {"anyOf",
       {off, closed_object(
                 {{"false_alarm",
                   limit("1", "probability that the innovations of a consistent filter fail a test in ten minutes")},
                  {"nis", described("whether NIS is tested", on)},
                  {"bias", described("whether the mean of innovations is tested", on)},
                  {"correlation", described("whether innovations are tested for correlation in time", on)},
                  {"beyond_reason", limit("1", "NIS per row beyond which a filter is lost")},
                  {"after", limit("1", "number of refusals in a row that is a lock-out")},
                  {"refused", limit("1", "fraction of a measurement's refused rows beyond which a filter is lost")},
                  {"hole", limit("s", "hole in the driving input beyond which a filter is doubtful")},
                  {"silent", limit("s", "time without a usable sample beyond which a filter is doubtful")},
                  {"frozen", limit("s", "time of a repeated driving input beyond which a filter is doubtful")},
                  {"except", described("measurements that are not monitored", {{"anyOf", {name, list_of(name)}}})}},
                 {})}}};
}

void add_filter_definitions(Json& definitions) {
  const Json name = {{"type", "string"}};
  add_trust_definition(definitions);
  definitions["filter"] = or_patch(closed_object(
      {{"blocks", described("state blocks that are estimated", some_named(ref("state_block")))},
       {"derived",
        described("values computed from blocks; models bind to them in the same way", named(ref("derived_block")))},
       {"process", described("process models; exactly one advances each block", named(ref("process_model")))},
       {"measurements", described("measurements, in the order of updates at one instant", named(ref("measurement")))},
       {"trust", ref("trust")},
       {"longest_bridge",
        described("longest hole in the driving input that one step bridges; after a longer one the filter starts anew; "
                  "default: 10 s if an `init` has `again`, else unlimited",
                  ref("quantity"))},
       {"covariance", described("form of the covariance P", {{"enum", {"joseph", "ud", "square_root"}}})},
       {"propagation",
        described("propagation of x and P: by the models' Jacobians (ekf), or by sigma points through the models",
                  {{"enum", {"ekf", "unscented"}}})},
       {"emit", described("instants of the estimates on its channel: after accepted measurements (`measurements`, "
                          "the default), or also after each step of its input (`input`)",
                          {{"enum", {"measurements", "input"}}})},
       {"history",
        described("largest delay of a sample that is still applied at its time; `steps`: largest number of instants "
                  "for one arrival",
                  {{"anyOf",
                    {ref("quantity"), or_patch(closed_object({{"length", ref("quantity")},
                                                              {"steps", {{"type", "integer"}, {"minimum", 2}}}},
                                                             {"length"}))}}})},
       {"smoother",
        described("smoother; its result is the filter NAME.smoothed",
                  {{"anyOf",
                    {{{"const", "fixed_interval"}},
                     or_patch(closed_object(
                         {{"type", {{"const", "fixed_lag"}}}, {"lag", ref("quantity")}, {"every", ref("quantity")}},
                         {"type", "lag"})),
                     or_patch(closed_object({{"type", {{"const", "fixed_interval"}}},
                                             {"iterations", {{"type", "integer"}, {"minimum", 0}, {"maximum", 100}}}},
                                            {"type"}))}}})},
       {"limits", described("largest errors that do not matter, by block; without it 3 sigma of each estimate",
                            named(ref("quantity")))},
       {"implied_states",
        described(
            "values of blocks implied by one measurement, with everything else from the filter; scored and recorded",
            named(or_patch(closed_object({{"measurement", described("measurement with the samples", name)},
                                          {"block", described("implied block", name)}},
                                         {"measurement", "block"}))))}},
      {"blocks"}));
  definitions["reference"] = {
      {"anyOf",
       {closed_object({{"withheld", described("a measurement with withheld samples", name)},
                       {"filter", described("filter of the measurement; required if several filters have it", name)}},
                      {"withheld"}),
        closed_object({{"channel", described("channel with the truth", name)},
                       {"blocks", described("FILTER/BLOCK: the channel's fields for its outputs",
                                            named({{"anyOf", {list_of(name), named(name)}}}))},
                       {"invalid", described("value that marks an invalid sample", {{"type", "number"}})}},
                      {"channel", "blocks"})}}};
}

Json evaluate_schema() {
  const Json name = {{"type", "string"}};
  const Json segments = closed_object(
      {{"lengths", described("lengths along the true path; default: 100 m, 200 m … 800 m", list_of(ref("quantity")))},
       {"every", described("time between poses of the path; default: 0.1 s", ref("quantity"))},
       {"start_every",
        described("number of poses between starts of segments; default: 10", {{"type", "integer"}, {"minimum", 1}})},
       {"attitude", described("attitude block, if several of the filter are scored", name)}});
  const Json metric = {{"anyOf", {name, closed_object({{"metric", name}, {"unit", name}}, {"metric"})}}};
  const Json window_of_filter = closed_object({{"filter", name}, {"span", ref("window")}}, {"span"});
  return closed_object(
      {{"after",
        described("start of scoring: a time of the data, or `start+10 s`, from the start of the filter", ref("time"))},
       {"until", described("end of scoring, in the same forms", ref("time"))},
       {"estimates",
        described("estimates of filters with history that are scored and recorded", {{"enum", {"settled", "live"}}})},
       {"segments",
        described("segments for the metrics FILTER/POSITION.segments/translation and /rotation, as in KITTI",
                  segments)},
       {"windows", described("time windows that are also scored separately: [from, to]",
                             named({{"anyOf", {ref("window"), window_of_filter}}}))},
       {"metrics",
        described("metrics to be printed, FILTER/BLOCK.OUTPUT/STATISTIC", {{"anyOf", {metric, list_of(metric)}}})}});
}

Json sections() {
  const Json name = {{"type", "string"}};
  return {
      {"binnacle", {{"const", 1}, {"description", "version of the config's format"}}},
      {"title", described("title in one line", name)},
      {"description", described("description in any form", Json::object())},
      {"extends",
       described("one or more configs over which this one is merged (RFC 7386)", {{"anyOf", {name, list_of(name)}}})},
      {"plugins",
       described("additional places of plugins",
                 list_of({{"type", "string"}, {"description", "a plugin file, or a folder of plugin files"}}))},
      {"vars", described("values of variables \"${NAME}\" in the config; --var NAME=TEXT overrides them",
                         {{"type", "object"}})},
      {"sources", described("sources of samples: files, live input, simulators", named(ref("source")))},
      {"transforms", described("transforms, which compute samples from samples", named(ref("transform")))},
      {"filters", described("filters; a filter may read the estimates of an earlier filter as a channel",
                            some_named(ref("filter")))},
      {"sinks", described("sinks of samples: files, live output", named(ref("sink")))},
      {"reference", described("reference values for the scores of the filters",
                              {{"anyOf", {ref("reference"), list_of(ref("reference"))}}})},
      {"evaluate", described("time windows and metrics of the scores", evaluate_schema())},
      {"record", described("records of --out",
                           closed_object({{"every", described("time between records: one record at the instant nearest "
                                                              "to each multiple after the first; default: every step",
                                                              ref("quantity"))}}))},
      {"study", described("study: variants, runs and tables; see its guide", {{"type", "object"}})},
      {"covariance", described("covariance analysis: truth models and outputs; see its guide", {{"type", "object"}})},
      {"tune", described("tuning: parameters and objective; see its guide", {{"type", "object"}})},
      {"metrics", described("metrics of every run, as \"metrics\" of \"study\"", Json::object())}};
}

}  // namespace

Json schema(const Catalog& catalog) {
  Json definitions = Json::object();
  add_components(catalog, definitions);
  add_value_definitions(definitions);
  add_block_definitions(definitions);
  add_measurement_definitions(definitions);
  add_filter_definitions(definitions);
  Json whole = sections();
  whole["origin"] = parameter_schema(parameter::origin());
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
