// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "crease/stepper/scene_io.hpp"

namespace crease {

using Json = nlohmann::ordered_json;

/// Everything found wrong so far, in the order it was found.
class ProblemList {
 public:
  void add(std::string pointer, std::string message) { problems_.push_back({std::move(pointer), std::move(message)}); }
  bool empty() const { return problems_.empty(); }
  /// A problem stands at `pointer` itself.
  bool at(std::string_view pointer) const;
  /// A problem stands at `pointer` or below it: whatever else is said about it might only be a consequence.
  bool under(std::string_view pointer) const;
  std::vector<SceneProblem> take() { return std::move(problems_); }

 private:
  std::vector<SceneProblem> problems_;
};

/// `pointer` + "/" + key with JSON pointer escapes.
std::string child_pointer(const std::string& pointer, std::string_view key);

/// Checks `value` against a JSON Schema and fills in the defaults.
///
/// The subset of draft-07 that the scene schema uses: type, enum, bounds, lengths, pattern, uniqueItems, properties,
/// required, additionalProperties false, oneOf of required keys, items, $ref, default; and "x-available", the values
/// that can be run where the format knows more.
/// @return  the value in the key order of the schema, numbers as double where the schema says number, all defaults
///          filled in, and null wherever a problem was reported
Json check_and_fill(const Json& value, const Json& schema, ProblemList& problems);

/// JSON text for people: lists of plain values on one line, everything else indented by two.
std::string readable_json(const Json& value);

}  // namespace crease
