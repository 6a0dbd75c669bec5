// SPDX-License-Identifier: Apache-2.0
// Columns as the config names them: where they stand, what their numbers are.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "layout.hpp"
#include "row_reader.hpp"

namespace binnacle::csv {

/// An entry of "columns".
ParameterSpec column_spec();
/// "local": positions and velocities in metres from an origin.
ParameterSpec local_spec();

/// As the member stands, or null.
const ParameterValue* member(const ParameterValue& object, std::string_view name);

/// A key as a part of a JSON pointer.
std::string escaped(std::string key);

std::string list_of(const std::vector<std::string>& names);

std::size_t index_in_header(const std::string& name, const FirstRow& header, const std::string& pointer);
/// By name, or without header by number. Throws ComponentError at `pointer`.
std::size_t find_column(const std::string& name, const Format& format, const FirstRow& first,
                        const std::string& pointer);

/// Adds the column to the layout; the field that it becomes.
FieldSpec read_column(const std::string& field, const ParameterValue& value, const FirstRow& first, Layout& layout);

/// Adds the columns of "local", and the fields that they become: lat, lon, height, and vn, ve, vd.
void read_local(const Parameters& parameters, const FirstRow& first, Layout& layout, std::vector<FieldSpec>& fields);

}  // namespace binnacle::csv
