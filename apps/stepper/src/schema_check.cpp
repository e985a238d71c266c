// SPDX-License-Identifier: MIT
#include "schema_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <regex>

#include <nlohmann/json.hpp>

#include "crease/stepper/suggest.hpp"
#include "schema_describe.hpp"

namespace crease {
namespace {

class Checker {
 public:
  Checker(const Json& root, ProblemList& problems) : root_(root), problems_(problems) {}

  Json check(const Json& value, const Json& schema_or_ref, const std::string& pointer) {
    if (problems_.at(pointer)) return nullptr;  // the parser could not even read it
    const Json schema = resolve(schema_or_ref);
    const std::optional<Json> typed = convert(value, schema);
    if (!typed)
      return report(pointer, "must be " + describe_schema(schema) + ", got " + shown(value) + hint(value, schema));
    Json filled = typed->is_object()  ? check_object(*typed, schema, pointer)
                  : typed->is_array() ? check_array(*typed, schema, pointer)
                                      : *typed;
    return is_available(filled, schema, pointer) ? filled : Json(nullptr);
  }

 private:
  Json report(const std::string& pointer, std::string message) {
    problems_.add(pointer, std::move(message));
    return nullptr;
  }

  Json resolve(const Json& schema) const {
    Json target =
        schema.contains("$ref") ? root_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))) : schema;
    if (target.contains("items") && target["items"].contains("$ref")) target["items"] = resolve(target["items"]);
    return target;
  }

  static bool in_bounds(double number, const Json& schema) {
    const auto bound = [&](const char* key, double otherwise) {
      return schema.contains(key) ? schema[key].get<double>() : otherwise;
    };
    return std::isfinite(number) && number >= bound("minimum", -INFINITY) && number <= bound("maximum", INFINITY) &&
           number > bound("exclusiveMinimum", -INFINITY) && number < bound("exclusiveMaximum", INFINITY);
  }

  // The value in the type the schema names, or nothing when it is of another type or out of range.
  static std::optional<Json> convert(const Json& value, const Json& schema) {
    if (schema.contains("enum")) {
      for (const Json& allowed : schema["enum"])
        if (value == allowed) return allowed;
      return std::nullopt;
    }
    const Json& type = schema["type"];
    const auto allows = [&](const char* name) {
      return type == name || (type.is_array() && std::find(type.begin(), type.end(), name) != type.end());
    };
    if (value.is_number()) {
      const double number = value.get<double>();
      if (!in_bounds(number, schema)) return std::nullopt;
      if (allows("number")) return Json(number);
      // Bounds keep integers well inside the range where a double counts them exactly.
      if (allows("integer") && number == std::floor(number)) return Json(static_cast<std::int64_t>(number));
    }
    if (value.is_boolean() && allows("boolean")) return value;
    if (value.is_string() && allows("string") && matches(value.get<std::string>(), schema)) return value;
    if (value.is_object() && allows("object")) return value;
    if (value.is_array() && allows("array") && has_right_length(value, schema)) return value;
    return std::nullopt;
  }

  static bool matches(const std::string& text, const Json& schema) {
    if (schema.contains("maxLength") && text.size() > schema["maxLength"].get<size_t>()) return false;
    return !schema.contains("pattern") || std::regex_match(text, std::regex(schema["pattern"].get<std::string>()));
  }

  static bool has_right_length(const Json& list, const Json& schema) {
    return (!schema.contains("minItems") || list.size() >= schema["minItems"].get<size_t>()) &&
           (!schema.contains("maxItems") || list.size() <= schema["maxItems"].get<size_t>());
  }

  static std::string hint(const Json& value, const Json& schema) {
    if (!value.is_string() || !schema.contains("enum")) return "";
    std::vector<std::string> names;
    for (const Json& allowed : schema["enum"])
      if (allowed.is_string()) names.push_back(allowed);
    const auto near = nearest_name(value.get<std::string>(), names);
    return near ? "; did you mean \"" + *near + "\"?" : "";
  }

  Json check_array(const Json& list, const Json& schema, const std::string& pointer) {
    Json filled = Json::array();
    for (size_t i = 0; i < list.size(); ++i) {
      const std::string item = pointer + "/" + std::to_string(i);
      filled.push_back(check(list[i], schema["items"], item));
      if (schema.value("uniqueItems", false) && !filled.back().is_null() &&
          std::find(filled.begin(), filled.end() - 1, filled.back()) != filled.end() - 1)
        filled.back() = report(item, shown(list[i]) + " stands twice in this list; give each value once");
    }
    return filled;
  }

  Json check_object(const Json& object, const Json& schema, const std::string& pointer) {
    const Json& properties = schema["properties"];
    check_one_of(object, schema, pointer);
    Json filled = Json::object();
    for (const auto& [key, property] : properties.items()) {
      const std::string child = child_pointer(pointer, key);
      if (object.contains(key)) {
        filled[key] = check(object[key], property, child);
      } else if (property.contains("default")) {
        filled[key] = check(property["default"], property, child);
      } else if (schema.contains("required") &&
                 std::find(schema["required"].begin(), schema["required"].end(), key) != schema["required"].end()) {
        filled[key] = report(child, "is missing; must be " + describe_schema(resolve(property)));
      }
    }
    report_unknown_keys(object, properties, pointer);
    return filled;
  }

  void report_unknown_keys(const Json& object, const Json& properties, const std::string& pointer) {
    std::vector<std::string> known;
    for (const auto& [key, unused] : properties.items()) known.push_back(key);
    for (const auto& [key, unused] : object.items())
      if (!properties.contains(key)) report(child_pointer(pointer, key), "unknown key" + suggestion(key, known));
  }

  void check_one_of(const Json& object, const Json& schema, const std::string& pointer) {
    if (!schema.contains("oneOf")) return;
    std::string present;
    int n_present = 0;
    for (const Json& branch : schema["oneOf"]) {
      const std::string key = branch["required"][0];
      if (!object.contains(key)) continue;
      present += (n_present++ ? ", " : "") + key;
    }
    if (n_present != 1)
      report(pointer, "must be " + describe_schema(schema) + ", got " + (n_present ? present : std::string("none")));
  }

  bool is_available(const Json& value, const Json& schema, const std::string& pointer) {
    if (!schema.contains("x-available") || value.is_null()) return true;
    const Json& available = schema["x-available"];
    if (std::find(available.begin(), available.end(), value) != available.end()) return true;
    const std::string name = pointer.substr(pointer.rfind('/') + 1);
    if (available.empty()) {
      report(pointer, "\"" + name + "\" is not available yet; leave it out");
    } else {
      report(pointer, "\"" + name + "\": " + shown(value) + " is not available yet; must be " +
                          describe_schema({{"enum", available}}));
    }
    return false;
  }

  const Json& root_;
  ProblemList& problems_;
};

}  // namespace

bool ProblemList::at(std::string_view pointer) const {
  return std::any_of(problems_.begin(), problems_.end(), [&](const SceneProblem& p) { return p.pointer == pointer; });
}

bool ProblemList::under(std::string_view pointer) const {
  return std::any_of(problems_.begin(), problems_.end(), [&](const SceneProblem& p) {
    return p.pointer.starts_with(pointer) && (p.pointer.size() == pointer.size() || p.pointer[pointer.size()] == '/');
  });
}

std::string child_pointer(const std::string& pointer, std::string_view key) {
  std::string escaped;
  for (const char c : key) escaped += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return pointer + "/" + escaped;
}

Json check_and_fill(const Json& value, const Json& schema, ProblemList& problems) {
  return Checker(schema, problems).check(value, schema, "");
}

}  // namespace crease
