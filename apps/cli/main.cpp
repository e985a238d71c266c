// SPDX-License-Identifier: MIT
#include <fcntl.h>

#include <variant>

#include "arguments.hpp"
#include "commands.hpp"

namespace {

/// A standard stream that the caller closed would lend its number to the next file opened, and messages would land in a
/// result. Opened for reading, it takes none: writing to it still fails, as it must.
void keep_standard_streams_apart() {
  int descriptor = 0;
  while (descriptor >= 0 && descriptor < 3) descriptor = open("/dev/null", O_RDONLY | O_CLOEXEC);
}

}  // namespace

int main(int argc, char** argv) {
  keep_standard_streams_apart();
  const auto parsed = crease::cli::parse_arguments(argc, argv);
  if (const int* status = std::get_if<int>(&parsed)) return *status;
  return crease::cli::execute(std::get<crease::cli::Arguments>(parsed));
}
