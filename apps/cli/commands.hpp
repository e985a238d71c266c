// SPDX-License-Identifier: MIT
#pragma once

#include "arguments.hpp"

namespace crease::cli {

/// Does what the command line asks for; returns the exit status. What is wrong goes to standard error.
int execute(const Arguments& arguments);

}  // namespace crease::cli
