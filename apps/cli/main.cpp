// SPDX-License-Identifier: MIT
#include <variant>

#include "arguments.hpp"
#include "commands.hpp"

int main(int argc, char** argv) {
  const auto parsed = crease::cli::parse_arguments(argc, argv);
  if (const int* status = std::get_if<int>(&parsed)) return *status;
  return crease::cli::execute(std::get<crease::cli::Arguments>(parsed));
}
