// SPDX-License-Identifier: Apache-2.0
// metadata: what a component says of itself is complete, and is what it then does.
#include <algorithm>
#include <cctype>
#include <set>

#include "fixture.hpp"
#include "miniature.hpp"
#include "tried_roles.hpp"

namespace binnacle::conform {

namespace {

bool is_one_line(const std::string& text) { return !text.empty() && text.find('\n') == std::string::npos; }

void texts_of(Trial& trial, const std::vector<ParameterSpec>& parameters, const std::string& where, bool named) {
  for (const auto& parameter : parameters) {
    const std::string who = named ? where + "/" + parameter.name : where;
    if (named) trial.expect(is_one_line(parameter.text), "parameter '", who, "' has no line of text (.about(…))");
    const bool is_list = parameter.type == ParameterType::list || parameter.type == ParameterType::map;
    texts_of(trial, parameter.members, who, !is_list);
  }
}

void text(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentSpec& spec = component(trial, catalog).spec;
  trial.expect(is_one_line(spec.summary), "has no one-line summary");
  texts_of(trial, spec.parameters, "", true);
  for (const auto& port : spec.ports)
    trial.expect(is_one_line(port.text), "port '", port.name, "' has no line of text");
  const auto fields = [&](const std::vector<FieldSpec>& list, const std::string& where) {
    for (const auto& field : list)
      trial.expect(is_one_line(field.text), "field '", where, field.name, "' has no line of text");
  };
  fields(spec.fields, "");
  fields(spec.driving_rates, "driving_rates/");
  for (const auto& input : spec.inputs) {
    trial.expect(is_one_line(input.text), "input '", input.name, "' has no line of text");
    fields(input.fields, input.name + "/");
  }
}

void units_of(Trial& trial, const std::vector<ParameterSpec>& parameters, const std::string& where) {
  for (const auto& parameter : parameters) {
    const std::string who = where + "/" + parameter.name;
    const bool has_numbers = parameter.type == ParameterType::number || parameter.type == ParameterType::vector ||
                             parameter.type == ParameterType::matrix;
    trial.expect(!has_numbers || !parameter.unit.empty(), "parameter '", who,
                 "' is a number without unit (\"1\" for a pure one)");
    units_of(trial, parameter.members, who);
  }
}

void units(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentSpec& spec = component(trial, catalog).spec;
  units_of(trial, spec.parameters, "");
  const auto fields = [&](const std::vector<FieldSpec>& list, const std::string& where) {
    for (const auto& field : list) trial.expect(!field.unit.empty(), "field '", where, field.name, "' has no unit");
  };
  fields(spec.fields, "");
  fields(spec.driving_rates, "driving_rates/");
  for (const auto& input : spec.inputs) fields(input.fields, input.name + "/");
}

/// Never unmade: the process ends without, so that what is wrong with its end is life.create's to find.
const Composition& kept(std::shared_ptr<const Composition> composition) {
  return **new std::shared_ptr<const Composition>(std::move(composition));
}

void version(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const std::string& version = component(trial, catalog).plugin_version;
  const auto dots = std::count(version.begin(), version.end(), '.');
  trial.expect(dots == 2 && std::isdigit(static_cast<unsigned char>(version.front())), "the plugin's version '",
               version, "' is not MAJOR.MINOR.PATCH");
}

void example(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  if (!trial.expect(!type.spec.example.empty(), "has no example in its spec")) return;
  const Json settings = Json::parse(type.spec.example, nullptr, false, true);
  if (!trial.expect(settings.is_object(), "its example is not a JSON object: ", type.spec.example)) return;
  if (const std::string wrong = wrong_shape(type.spec); !trial.expect(wrong.empty(), wrong)) return;
  const Json config = miniature(trial, type, catalog, settings);
  trial.stage("constructor");
  try {
    kept(compose(trial, config));
  } catch (const Error& error) {
    trial.fail("its example does not compose:\n", error.what(), "\nin ", config.dump(2));
  }
  trial.stage("");
}

void declared_block(Trial& trial, const Composition& composition, const ComponentSpec& spec) {
  const auto value = parts::block(composition, filter_name, component_name);
  const auto& declared = value.block->declaration();
  const auto prefix = spec.kind.substr(0, spec.kind.find('*'));
  trial.expect(declared.kind.rfind(prefix, 0) == 0, "its kind is '", declared.kind, "', and its spec says '", spec.kind,
               "'");
  trial.expect(declared.dof() > 0, "has no error component");
  trial.expect(declared.stored_size > 0, "stores nothing");
  std::set<std::string> names;
  for (const auto& error : declared.error) {
    trial.expect(names.insert(error.name).second, "has two error components '", error.name, "'");
    trial.expect(!error.unit.empty(), "error component '", error.name, "' has no unit");
  }
  names.clear();
  for (const auto& output : declared.outputs) {
    trial.expect(names.insert(output.name).second, "has two outputs '", output.name, "'");
    trial.expect(!output.unit.empty(), "output '", output.name, "' has no unit");
  }
  for (const auto& norm : declared.norms)
    for (const int i : norm.components)
      trial.expect(i >= 0 && i < declared.dof(), "norm '", norm.name, "' is of a component ", i, " of ",
                   declared.dof());
  // A kind that states size and unit ("vector:3:rad/s") must be what the block is.
  if (declared.kind.rfind("vector:", 0) == 0) {
    const auto colon = declared.kind.find(':', 7);
    const std::string unit = declared.kind.substr(colon + 1);
    trial.expect(std::stoi(declared.kind.substr(7)) == declared.dof(), "its kind '", declared.kind,
                 "' states another size than its ", declared.dof(), " components");
    for (const auto& error : declared.error)
      trial.expect(error.unit == unit, "its kind '", declared.kind, "' states another unit than its component '",
                   error.name, "', ", error.unit);
  }
}

void declared_process(Trial& trial, const Composition& composition, const ComponentSpec& spec) {
  const auto part = parts::process(composition, filter_name, component_name);
  const auto& declared = part.model->declaration();
  trial.expect(declared.has_closed_form || declared.has_continuous_form, "has neither a closed nor a continuous form");
  const auto is_port = [&](int i) { return i >= 0 && i < static_cast<int>(part.ports.size()); };
  const auto check = [&](const std::vector<Coupling>& couplings, const char* what, bool both_advance) {
    std::set<std::pair<int, int>> seen;
    for (const auto& c : couplings) {
      if (!trial.expect(is_port(c.to) && is_port(c.from), what, " couples port ", c.to, " to ", c.from,
                        ", and there are ", part.ports.size()))
        continue;
      trial.expect(seen.insert({c.to, c.from}).second, what, " lists (", c.to, ", ", c.from, ") twice");
      trial.expect(spec.ports[static_cast<std::size_t>(c.to)].access == PortAccess::advances, what,
                   " has rows of a port that is only read");
      if (both_advance)
        trial.expect(spec.ports[static_cast<std::size_t>(c.from)].access == PortAccess::advances, what,
                     " has columns of a port that is only read");
      trial.expect(!part.ports[static_cast<std::size_t>(c.to)].name.empty() &&
                       !part.ports[static_cast<std::size_t>(c.from)].name.empty(),
                   what, " couples an open port");
    }
  };
  check(declared.transition, "transition", false);
  check(declared.noise, "noise", true);
}

void declared_measurement(Trial& trial, const Composition& composition) {
  const auto part = parts::measurement(composition, filter_name, component_name);
  const auto& declared = part.model->declaration();
  trial.expect(declared.max_rows > 0, "declares no row");
  std::set<int> seen;
  for (const int port : declared.read_ports) {
    if (!trial.expect(port >= 0 && port < static_cast<int>(part.ports.size()), "reads a port ", port,
                      " that it has not"))
      continue;
    trial.expect(!part.ports[static_cast<std::size_t>(port)].name.empty(), "reads an open port");
    trial.expect(seen.insert(port).second, "reads port ", port, " twice");
  }
  for (const auto& group : declared.groups) {
    trial.expect(group.first_row >= 0 && group.first_row + group.rows <= declared.max_rows, "group '", group.name,
                 "' goes beyond its ", declared.max_rows, " rows");
    trial.expect(group.port >= 0 || !group.unit.empty(), "group '", group.name, "' has neither port nor unit");
  }
}

void declared_derived(Trial& trial, const Composition& composition, const ComponentSpec& spec) {
  const auto part = parts::derived(composition, filter_name, component_name);
  const auto& declared = part.model->declaration();
  const auto prefix = spec.kind.substr(0, spec.kind.find('*'));
  trial.expect(declared.kind.rfind(prefix, 0) == 0, "it yields '", declared.kind, "', and its spec says '", spec.kind,
               "'");
  const auto yields = block_of_kind(trial, declared.kind);
  trial.expect(declared.stored_size == yields->declaration().stored_size, "it yields ", declared.stored_size,
               " numbers, and a block of the kind '", declared.kind, "' stores ", yields->declaration().stored_size);
  trial.expect(declared.dof() == yields->declaration().dof(), "it yields ", declared.dof(),
               " error components, and the kind '", declared.kind, "' has ", yields->declaration().dof());
}

void declared_channels(Trial& trial, const std::vector<ChannelDeclaration>& channels) {
  trial.expect(!channels.empty(), "has no channel");
  for (const auto& channel : channels)
    for (const auto& field : channel.fields) {
      trial.expect(!field.name.empty(), "channel '", channel.name, "' has a field without name");
      trial.expect(!field.unit.empty(), "field '", field.name, "' of channel '", channel.name, "' has no unit");
    }
}

void declared(Trial& trial) {
  const Composition& composition = kept(compose_example(trial));
  const ComponentSpec& spec = component(trial, composition.catalog()).spec;
  switch (trial.role) {
    case Role::state_block: return declared_block(trial, composition, spec);
    case Role::process_model: return declared_process(trial, composition, spec);
    case Role::measurement_model: return declared_measurement(trial, composition);
    case Role::derived_block: return declared_derived(trial, composition, spec);
    case Role::source:
      return declared_channels(trial, parts::source(composition, component_name).model->declaration().channels);
    case Role::transform:
      return declared_channels(trial, parts::transform(composition, component_name).model->declaration().channels);
    default: Trial::not_applicable("this role declares nothing once it is bound");
  }
}

}  // namespace

std::vector<Check> metadata_checks() {
  return {
      check("metadata.text", 1, every_role, {"load.register"},
            "component, parameters, ports and fields have a line of text", text),
      check("metadata.units", 1, every_role, {"load.register"}, "every number has a unit: parameters and fields",
            units),
      check("metadata.version", 1, every_role, {"load.register"}, "the plugin's version is MAJOR.MINOR.PATCH", version),
      check("metadata.example", 1, every_role, {"load.register"}, "its example composes without an error", example),
      check("metadata.declared", 2, every_role, {"metadata.example", "metadata.units"},
            "what it declares once bound agrees with its spec and with itself", declared),
  };
}

}  // namespace binnacle::conform
