// SPDX-License-Identifier: MIT
#include "output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace crease {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw FileError(path, error ? std::strerror(error) : "not written whole");
}

void put(std::FILE* file, std::string_view bytes, const std::filesystem::path& path) {
  errno = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size() || std::fflush(file) != 0) fail(path, errno);
}

/// A special file (/dev/null, a pipe) has no disk to reach.
int to_disk(int descriptor) {
  return fsync(descriptor) == 0 || errno == EINVAL ? 0 : errno;
}

}  // namespace

FileError::FileError(const std::filesystem::path& path, const std::string& reason)
    : std::runtime_error(path.string() + ": " + reason) {}

void write_whole(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::path part = path;
  part += ".tmp";
  errno = 0;
  std::FILE* file = std::fopen(part.c_str(), "wb");
  if (!file) fail(path, errno);
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  int error = written ? 0 : errno ? errno : EIO;
  errno = 0;
  if (!error && std::fflush(file) != 0) error = errno ? errno : EIO;  // a full disk may show only now
  if (!error) error = to_disk(fileno(file));
  errno = 0;
  if (std::fclose(file) != 0 && !error) error = errno ? errno : EIO;
  std::error_code trouble(error, std::generic_category());
  if (!trouble) std::filesystem::rename(part, path, trouble);
  if (!trouble) return;
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  throw FileError(path, trouble.message());
}

void sync_folder(const std::filesystem::path& folder) {
  // A folder that may be written but not read goes without.
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  const int error = to_disk(descriptor);
  close(descriptor);
  if (error) fail(folder, error);
}

std::string read_whole(const std::filesystem::path& path) {
  errno = 0;
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (!file) fail(path, errno);
  std::string bytes;
  char block[1 << 16];
  for (std::size_t n; (n = std::fread(block, 1, sizeof block, file)) > 0;) bytes.append(block, n);
  const bool broken = std::ferror(file) != 0;
  const int error = errno;
  std::fclose(file);
  if (broken) fail(path, error);
  return bytes;
}

LineFile::LineFile(std::filesystem::path path) : path_(std::move(path)) {
  errno = 0;
  file_.reset(std::fopen(path_.c_str(), "ab"));
  if (!file_) fail(path_, errno);
}

void LineFile::append(std::string_view line) {
  put(file_.get(), line, path_);
}

void LineFile::sync() {
  if (const int error = to_disk(fileno(file_.get()))) fail(path_, error);
}

}  // namespace crease
