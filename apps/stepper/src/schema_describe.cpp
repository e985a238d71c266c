// SPDX-License-Identifier: MIT
#include <algorithm>

#include <nlohmann/json.hpp>

#include "schema_check.hpp"
#include "schema_describe.hpp"

namespace crease {
namespace {

std::string dump(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string bounds(const Json& schema) {
  std::string text;
  for (const auto& [key, sign] : {std::pair("minimum", " >= "), std::pair("exclusiveMinimum", " > "),
                                  std::pair("maximum", " <= "), std::pair("exclusiveMaximum", " < ")})
    if (schema.contains(key)) text += (text.empty() ? "" : " and") + std::string(sign) + dump(schema[key]);
  return text;
}

std::string count_of(const Json& schema, const Json& items) {
  const auto at = [&](const char* key) { return schema.contains(key) ? schema[key].get<int>() : -1; };
  const int least = at("minItems"), most = at("maxItems");
  std::string text = "a list of ";
  if (least >= 0 && least == most)
    text += std::to_string(least);
  else if (least > 0)
    text += std::to_string(least) + " or more";
  else if (most >= 0)
    text += "at most " + std::to_string(most);
  else
    text += "any length";
  return text + ", each " + describe_schema(items);
}

std::string describe_object(const Json& schema) {
  std::string text = schema.contains("oneOf") ? "an object with exactly one of " : "an object with ";
  bool first = true;
  const auto append = [&](const std::string& key) {
    text += (first ? "" : ", ") + key;
    first = false;
  };
  if (schema.contains("oneOf"))
    for (const Json& branch : schema["oneOf"]) append(branch["required"][0].get<std::string>());
  else
    for (const auto& [key, unused] : schema["properties"].items()) append(key);
  return text;
}

}  // namespace

std::string shown(const Json& value) {
  constexpr size_t longest = 60;
  const std::string text = dump(value);
  return text.size() <= longest ? text : text.substr(0, longest) + "...";
}

std::string describe_schema(const Json& schema) {
  if (schema.contains("enum")) {
    std::string text = schema["enum"].size() > 1 ? "one of " : "";
    for (size_t i = 0; i < schema["enum"].size(); ++i) text += (i ? ", " : "") + dump(schema["enum"][i]);
    return text;
  }
  if (!schema.contains("type")) return "as its definition says";
  if (schema["type"].is_array()) return "the name of a shipped material or " + describe_object(schema);
  const std::string type = schema["type"];
  if (type == "number") return "a number" + bounds(schema);
  if (type == "integer") return "an integer" + bounds(schema);
  if (type == "boolean") return "true or false";
  if (type == "array") return count_of(schema, schema["items"]);
  if (type == "object") return describe_object(schema);
  return schema.contains("pattern") ? "a text that matches " + schema["pattern"].get<std::string>() : "a text";
}

std::string readable_json(const Json& value) {
  const auto plain = [](const Json& item) { return !item.is_structured(); };
  const auto flat = [&](const Json& item) { return std::all_of(item.begin(), item.end(), plain); };
  const auto write = [&](const auto& self, const Json& item, const std::string& indent) -> std::string {
    if (plain(item) || item.empty()) return dump(item);
    const bool one_line = item.is_array() && flat(item);
    const std::string inner = one_line ? "" : indent + "  ", line = one_line ? "" : "\n";
    std::string text = item.is_array() ? "[" : "{";
    bool first = true;
    for (const auto& [key, child] : item.items()) {
      text += (first ? "" : one_line ? ", " : ",") + line + inner;
      if (item.is_object()) text += dump(Json(key)) + ": ";
      text += self(self, child, inner);
      first = false;
    }
    return text + line + (one_line ? "" : indent) + (item.is_array() ? "]" : "}");
  };
  return write(write, value, "") + "\n";
}

}  // namespace crease
