// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace crease {

/// A file that cannot be read or written: "PATH: reason".
class FileError : public std::runtime_error {
 public:
  FileError(const std::filesystem::path& path, const std::string& reason);
};

/// Writes PATH.tmp and renames it: a reader finds the old file or the whole new one, never a part.
void write_whole(const std::filesystem::path& path, std::string_view bytes);

std::string read_whole(const std::filesystem::path& path);

/// A text file that grows line by line; each line reaches the file before append() returns.
class LineFile {
 public:
  explicit LineFile(std::filesystem::path path);
  void append(std::string_view line);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace crease
