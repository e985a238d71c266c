// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "schema_check.hpp"

namespace crease {

/// What a schema wants, in words: "a number > 0", "a list of 3, each a number". @pre $ref resolved, except in items
std::string describe_schema(const Json& schema);

/// A value as JSON text, cut when long.
std::string shown(const Json& value);

}  // namespace crease
