// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <string>

namespace crease {

/// A number as a message tells it.
inline std::string digits(double value, int significant) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, significant).ptr};
}

}  // namespace crease
