// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace crease {

/// The known name that `word` most likely was meant to be: at most a third of its letters away (insertions, deletions,
/// replacements, swapped neighbours), or nothing.
std::optional<std::string> nearest_name(std::string_view word, const std::vector<std::string>& known);

/// "; did you mean \"x\"?" or, with nothing near, "; known are a, b, c".
std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace crease
