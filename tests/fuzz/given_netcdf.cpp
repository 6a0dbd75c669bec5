// SPDX-License-Identifier: Apache-2.0
#include "given_netcdf.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "results/netcdf_library.hpp"

namespace binnacle::fuzz {

namespace {

using Json = nlohmann::ordered_json;

struct Dimension {
  std::string name;
  std::size_t size = 0;
};

struct Variable {
  std::string name;
  nc_type type = NC_DOUBLE;
  std::vector<int> dimensions;
  Json attributes = Json::object(), values;
};

struct Group {
  std::string name;
  Json attributes = Json::object();
  std::vector<Variable> variables;
  std::vector<int> groups;
};

/// Ids are places in these lists, as in NetCDF those of dimensions are of the whole file. Names too long for it are none.
struct Given {
  std::vector<Group> groups;
  std::vector<Dimension> dimensions;

  using Scope = std::vector<std::pair<std::string, int>>;

  static const Json& part(const Json& node, const char* key) {
    static const Json none = Json::object();
    const auto found = node.is_object() ? node.find(key) : node.end();
    return node.is_object() && found != node.end() && found->is_object() ? *found : none;
  }

  static nc_type type_of(const Json& node) {
    static const std::pair<const char*, nc_type> types[] = {
        {"char", NC_CHAR}, {"byte", NC_BYTE}, {"int", NC_INT}, {"int64", NC_INT64}, {"string", NC_STRING}};
    for (const auto& [name, type] : types)
      if (node.is_object() && node.contains("type") && node["type"] == name) return type;
    return NC_DOUBLE;
  }

  int add(const std::string& name, const Json& node, Scope scope, int depth = 0) {
    const auto id = groups.size();
    groups.push_back({name, part(node, "attributes"), {}, {}});
    for (const auto& [key, size] : part(node, "dimensions").items()) {
      scope.emplace_back(key, static_cast<int>(dimensions.size()));
      dimensions.push_back({key.substr(0, NC_MAX_NAME), size.is_number_unsigned() ? size.get<std::size_t>() : 0});
    }
    for (const auto& [key, its] : part(node, "variables").items()) {
      Variable variable{key.substr(0, NC_MAX_NAME), type_of(its), {}, part(its, "attributes"), {}};
      if (its.is_object() && its.contains("values")) variable.values = its["values"];
      if (its.is_object() && its.contains("dimensions"))
        for (const Json& of : its["dimensions"])
          if (const auto at = std::find_if(scope.rbegin(), scope.rend(), [&](const auto& d) { return of == d.first; });
              at != scope.rend())
            variable.dimensions.push_back(at->second);
      groups[id].variables.push_back(std::move(variable));
    }
    for (const auto& [key, inner] : part(node, "groups").items())
      if (depth < 8) {
        const int made = add(key.substr(0, NC_MAX_NAME), inner, scope, depth + 1);
        groups[id].groups.push_back(made);
      }
    return static_cast<int>(id);
  }
};

Given given;

const Group& group(int id) { return given.groups.at(static_cast<std::size_t>(id)); }
const Variable& variable(int id, int v) { return group(id).variables.at(static_cast<std::size_t>(v)); }

/// Null: there is none.
const Json* attribute(int id, int v, const char* name) {
  const Json& all = v == NC_GLOBAL ? group(id).attributes : variable(id, v).attributes;
  const auto found = all.find(name);
  return found == all.end() ? nullptr : &*found;
}

std::size_t length_of(const Json& value) {
  return value.is_string() ? value.get_ref<const std::string&>().size() : value.is_array() ? value.size() : 1;
}

/// Numbers outside of a type's range are an error of NetCDF's, which comes with the values: here zero.
template <class T>
T number_of(const Json& value) {
  if (value.is_number_integer()) return static_cast<T>(value.get<std::int64_t>());
  if (!value.is_number()) return T(0);
  const double number = value.get<double>();
  if constexpr (std::is_floating_point_v<T>) return number;
  return std::abs(number) < 100 ? static_cast<T>(static_cast<int>(number)) : T(0);
}

template <class T>
int give(int id, int v, const std::size_t*, const std::size_t* count, T* to) {
  const Variable& of = variable(id, v);
  if (of.type == NC_CHAR) return NC_ECHAR;
  if (of.type == NC_STRING) return NC_EBADTYPE;
  std::size_t most = 1;
  for (std::size_t i = 0; i < of.dimensions.size(); ++i)
    if (__builtin_mul_overflow(most, count[i], &most)) most = std::size_t{1} << 40;
  for (std::size_t i = 0; i < most; ++i)
    to[i] = of.values.is_array() && !of.values.empty() ? number_of<T>(of.values[i % of.values.size()]) : T(1);
  return NC_NOERR;
}

int give_text(int id, int v, char* to) {
  const Variable& of = variable(id, v);
  if (of.type != NC_CHAR) return NC_ECHAR;
  const std::string text = of.values.is_string() ? of.values.get<std::string>() : std::string();
  std::size_t most = 1;
  for (const int dimension : of.dimensions)
    if (__builtin_mul_overflow(most, given.dimensions.at(static_cast<std::size_t>(dimension)).size, &most))
      most = std::size_t{1} << 40;
  for (std::size_t i = 0; i < most; ++i) to[i] = i < text.size() ? text[i] : '\0';
  return NC_NOERR;
}

int named(const std::string& name, char* to) {
  std::memcpy(to, name.c_str(), name.size() + 1);
  return NC_NOERR;
}

template <class T>
void put(T* to, auto value) {
  if (to) *to = static_cast<T>(value);
}

void answer_of_groups(results::nc::Library& is) {
  is.nc_open = [](const char*, int, int* id) { return *id = 0, given.groups.empty() ? NC_ENOTNC : NC_NOERR; };
  is.nc_close = [](int) { return NC_NOERR; };
  is.nc_inq_grps = [](int id, int* count, int* ids) {
    put(count, group(id).groups.size());
    if (ids) std::copy(group(id).groups.begin(), group(id).groups.end(), ids);
    return NC_NOERR;
  };
  is.nc_inq_ncid = [](int id, const char* name, int* found) {
    for (const int inner : group(id).groups)
      if (group(inner).name == name) return *found = inner, NC_NOERR;
    return NC_ENOGRP;
  };
  is.nc_inq_grpname = [](int id, char* name) { return named(group(id).name, name); };
}

void answer_of_variables(results::nc::Library& is) {
  is.nc_inq_nvars = [](int id, int* count) { return put(count, group(id).variables.size()), NC_NOERR; };
  is.nc_inq_varid = [](int id, const char* name, int* found) {
    const auto& all = group(id).variables;
    const auto at = std::find_if(all.begin(), all.end(), [&](const Variable& v) { return v.name == name; });
    return put(found, at - all.begin()), at == all.end() ? NC_ENOTVAR : NC_NOERR;
  };
  is.nc_inq_varname = [](int id, int v, char* name) { return named(variable(id, v).name, name); };
  is.nc_inq_vartype = [](int id, int v, nc_type* type) { return *type = variable(id, v).type, NC_NOERR; };
  is.nc_inq_varndims = [](int id, int v, int* count) {
    return put(count, variable(id, v).dimensions.size()), NC_NOERR;
  };
  is.nc_inq_vardimid = [](int id, int v, int* ids) {
    std::copy(variable(id, v).dimensions.begin(), variable(id, v).dimensions.end(), ids);
    return NC_NOERR;
  };
  is.nc_inq_dimlen = [](int, int d, std::size_t* size) {
    return *size = given.dimensions.at(static_cast<std::size_t>(d)).size, NC_NOERR;
  };
  is.nc_inq_dimname = [](int, int d, char* name) {
    return named(given.dimensions.at(static_cast<std::size_t>(d)).name, name);
  };
  is.nc_inq_type = [](int, nc_type type, char*, std::size_t* size) {
    return put(size, type == NC_CHAR || type == NC_BYTE ? 1 : type == NC_INT ? 4 : 8), NC_NOERR;
  };
  is.nc_get_var_text = give_text;
  is.nc_get_vara_double = give<double>;
  is.nc_get_vara_int = give<int>;
  is.nc_get_vara_longlong = give<long long>;
  is.nc_get_vara_schar = give<signed char>;
}

void answer_of_attributes(results::nc::Library& is) {
  is.nc_inq_attid = [](int id, int v, const char* name, int* number) {
    return put(number, 0), attribute(id, v, name) ? NC_NOERR : NC_ENOTATT;
  };
  is.nc_inq_att = [](int id, int v, const char* name, nc_type* type, std::size_t* length) {
    const Json* const value = attribute(id, v, name);
    if (!value) return NC_ENOTATT;
    *type = value->is_string() ? NC_CHAR : value->is_array() ? NC_BYTE : NC_INT64;
    return *length = length_of(*value), NC_NOERR;
  };
  is.nc_inq_attlen = [](int id, int v, const char* name, std::size_t* length) {
    const Json* const value = attribute(id, v, name);
    return put(length, value ? length_of(*value) : 0), value ? NC_NOERR : NC_ENOTATT;
  };
  is.nc_get_att_text = [](int id, int v, const char* name, char* to) {
    const Json* const value = attribute(id, v, name);
    if (!value || !value->is_string()) return NC_ECHAR;
    const auto& text = value->get_ref<const std::string&>();
    return std::copy(text.begin(), text.end(), to), NC_NOERR;
  };
  is.nc_get_att_schar = [](int id, int v, const char* name, signed char* to) {
    const Json* const value = attribute(id, v, name);
    if (!value || value->is_string()) return NC_ECHAR;
    if (value->is_array())
      for (const Json& number : *value) *to++ = number_of<signed char>(number);
    else
      *to = number_of<signed char>(*value);
    return NC_NOERR;
  };
  is.nc_get_att_ulonglong = [](int id, int v, const char* name, unsigned long long* to) {
    const Json* const value = attribute(id, v, name);
    if (!value || value->is_string()) return NC_ECHAR;
    return *to = number_of<unsigned long long>(value->is_array() ? (*value)[0] : *value), NC_NOERR;
  };
}

results::nc::Library answers() {
  results::nc::Library is{};
  is.H5dont_atexit = []() { return herr_t{0}; };
  is.H5Eset_auto2 = [](hid_t, H5E_auto2_t, void*) { return herr_t{0}; };
  is.nc_strerror = [](int) { return "NetCDF: as it was given"; };
  answer_of_groups(is);
  answer_of_variables(is);
  answer_of_attributes(is);
  return is;
}

}  // namespace

bool give_netcdf(std::string_view json) {
  given = {};
  const Json root = Json::parse(json, nullptr, false);
  if (!root.is_object()) return false;
  given.add("/", root, {});
  return true;
}

}  // namespace binnacle::fuzz

/// In place of the one that loads it: this object is linked before the archive that has that one.
const binnacle::results::nc::Library& binnacle::results::nc::library() {
  static const Library all = binnacle::fuzz::answers();
  return all;
}
