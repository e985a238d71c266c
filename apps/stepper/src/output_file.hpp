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

/// Writes PATH.tmp, waits until it is on the disk and renames it: a reader finds the old file or the whole new one,
/// never a part, also after a loss of power. Which of the two is settled by sync_folder().
void write_whole(const std::filesystem::path& path, std::string_view bytes);

/// Waits until the names in a folder are on the disk.
void sync_folder(const std::filesystem::path& folder);

std::string read_whole(const std::filesystem::path& path);

/// A text file that grows line by line; each line reaches the file before append() returns, and the disk before sync()
/// does.
class LineFile {
 public:
  explicit LineFile(std::filesystem::path path);
  void append(std::string_view line);
  void sync();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace crease
