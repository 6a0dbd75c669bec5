// SPDX-License-Identifier: Apache-2.0
// Parameters as a plugin sees them: checked, complete, in SI.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "binnacle/time.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// Thrown by a plugin to refuse what it was given. The kernel turns it into a diagnostic that names file, line and JSON
/// pointer. Never let anything else escape: other exceptions are reported as a fault of the plugin.
class __attribute__((visibility("default"))) ComponentError : public std::runtime_error {
 public:
  /// The component's configuration as a whole, or the member at `pointer` relative to it ("/segments/3/radius").
  explicit ComponentError(const std::string& message, std::string pointer = {})
      : std::runtime_error(message), pointer_(std::move(pointer)) {}
  /// Bad data: `file` at `line` (0: the file as a whole). Exit status 5 instead of 3. `code` is one of the B06x codes.
  static ComponentError in_data(const std::string& message, std::string file, int line, std::string code) {
    ComponentError error(message);
    error.file_ = std::move(file);
    error.line_ = line;
    error.code_ = std::move(code);
    return error;
  }
  const std::string& pointer() const noexcept { return pointer_; }
  const std::string& file() const noexcept { return file_; }
  const std::string& code() const noexcept { return code_; }
  int line() const noexcept { return line_; }
  bool is_data_error() const noexcept { return !file_.empty(); }

 private:
  std::string pointer_, file_, code_;
  int line_ = 0;
};

/// A checked value. Built by the kernel; plugins read it through Parameters.
struct ParameterValue {
  /// Which of the members holds the value; absent: none.
  enum class Type { absent, boolean, integer, number, text, vector, matrix, list, object };
  Type type = Type::absent;
  bool boolean = false;
  std::int64_t integer = 0;  // integer, or nanoseconds of a time
  double number = 0;
  std::string text;
  std::vector<double> numbers;  // vector, or matrix column-major
  int rows = 0;
  int cols = 0;
  std::vector<ParameterValue> elements;                         // list
  std::vector<std::pair<std::string, ParameterValue>> members;  // object, map: in the order of the config

  // Defined below, where the type is complete: std::pair of it asks for these before (clang 14 with libstdc++).
  ParameterValue();
  ParameterValue(const ParameterValue&);
  ParameterValue(ParameterValue&&) noexcept;
  ParameterValue& operator=(const ParameterValue&);
  ParameterValue& operator=(ParameterValue&&) noexcept;
  ~ParameterValue();
};

inline ParameterValue::ParameterValue() = default;
inline ParameterValue::ParameterValue(const ParameterValue&) = default;
inline ParameterValue::ParameterValue(ParameterValue&&) noexcept = default;
inline ParameterValue& ParameterValue::operator=(const ParameterValue&) = default;
inline ParameterValue& ParameterValue::operator=(ParameterValue&&) noexcept = default;
inline ParameterValue::~ParameterValue() = default;

/// The parameters of one component, or of one object inside them. Everything declared with a default or as required is
/// there. Asking for an undeclared name or a wrong type is a defect of the plugin and throws std::logic_error.
class Parameters {
 public:
  Parameters() = default;
  explicit Parameters(const ParameterValue& object) : object_(&object) {}

  bool has(std::string_view name) const { return find(name) != nullptr; }
  double number(std::string_view name) const { return get(name, ParameterValue::Type::number).number; }
  std::int64_t integer(std::string_view name) const { return get(name, ParameterValue::Type::integer).integer; }
  bool boolean(std::string_view name) const { return get(name, ParameterValue::Type::boolean).boolean; }
  /// Text, choice or resolved path.
  const std::string& text(std::string_view name) const { return get(name, ParameterValue::Type::text).text; }
  Time time(std::string_view name) const { return get(name, ParameterValue::Type::integer).integer; }
  template <int Rows = dynamic>
  ConstMapOf<Rows> vector(std::string_view name) const {
    const auto& value = get(name, ParameterValue::Type::vector);
    return {value.numbers.data(), static_cast<int>(value.numbers.size())};
  }
  template <int Rows = dynamic, int Cols = dynamic>
  ConstMapOf<Rows, Cols> matrix(std::string_view name) const {
    const auto& value = get(name, ParameterValue::Type::matrix);
    return {value.numbers.data(), value.rows, value.cols};
  }
  Parameters object(std::string_view name) const { return Parameters(get(name, ParameterValue::Type::object)); }
  /// Elements of a list; read each through element<>() below or, for objects, Parameters(element).
  const std::vector<ParameterValue>& list(std::string_view name) const {
    return get(name, ParameterValue::Type::list).elements;
  }
  /// Members of a map or object in the order of the config.
  const std::vector<std::pair<std::string, ParameterValue>>& members(std::string_view name) const {
    return get(name, ParameterValue::Type::object).members;
  }

 private:
  const ParameterValue* find(std::string_view name) const {
    if (object_)
      for (const auto& [key, value] : object_->members)
        if (key == name && value.type != ParameterValue::Type::absent) return &value;
    return nullptr;
  }
  const ParameterValue& get(std::string_view name, ParameterValue::Type type) const {
    const auto* value = find(name);
    if (!value) throw std::logic_error("parameter '" + std::string(name) + "' is absent; ask has() first");
    if (value->type != type)
      throw std::logic_error("parameter '" + std::string(name) + "' was asked for as another type than declared");
    return *value;
  }

  const ParameterValue* object_ = nullptr;
};

}  // namespace binnacle
