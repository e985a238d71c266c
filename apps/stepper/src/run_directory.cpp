// SPDX-License-Identifier: MIT
#include "run_directory.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <variant>
#include <vector>

#include "frames.hpp"
#include "output_file.hpp"

namespace crease {
namespace {

namespace fs = std::filesystem;

constexpr const char* run_files[] = {"checkpoint.bin", "summary.json",   "steps.csv",
                                     "cloth.pvd",      "obstacles.json", "scene.json"};

/// Number of a frame file of ours, or nothing.
std::optional<int> frame_number(const fs::path& file) {
  const std::string stem = file.stem().string(), extension = file.extension().string();
  if (extension != ".vtp" && extension != ".obj") return std::nullopt;
  int number = 0;
  const auto parsed = std::from_chars(stem.data(), stem.data() + stem.size(), number);
  const bool ours =
      stem.size() >= 6 && parsed.ec == std::errc() && parsed.ptr == stem.data() + stem.size() && number >= 0;
  return ours ? std::optional(number) : std::nullopt;
}

std::vector<fs::path> entries(const fs::path& directory) {
  std::vector<fs::path> files;
  if (fs::is_directory(directory))
    for (const auto& entry : fs::directory_iterator(directory)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// A run killed before its first checkpoint leaves no more than that checkpoint's beginnings.
bool holds_nothing_yet(const RunDirectory& directory) {
  fs::path part = directory.checkpoint();
  part += ".tmp";
  const std::vector<fs::path> files = entries(directory.root);
  return std::all_of(files.begin(), files.end(), [&](const fs::path& file) { return file == part; });
}

/// Does a run in this directory put another file in this one's place, or remove it? Looks through links.
bool is_replaced(const RunDirectory& directory, const fs::path& file) {
  std::error_code missing;  // a file that is not there cannot be lost
  for (const char* name : run_files)
    if (fs::equivalent(file, directory.root / name, missing)) return true;
  return frame_number(file) && fs::equivalent(file, directory.root / "frames" / file.filename(), missing);
}

/// What the scene was read from and a run in this directory would destroy, or nothing.
std::optional<fs::path> endangered_input(const RunDirectory& directory, const LoadedScene& loaded) {
  if (is_replaced(directory, loaded.file) && read_whole(loaded.file) != loaded.resolved_json) return loaded.file;
  for (const ClothSpec& cloth : loaded.scene.cloths)
    if (const auto* mesh = std::get_if<fs::path>(&cloth.shape); mesh && is_replaced(directory, *mesh)) return *mesh;
  return std::nullopt;
}

}  // namespace

std::optional<std::string> refusal(const RunDirectory& directory, const RunOptions& options,
                                   const LoadedScene& loaded) {
  const std::string name = directory.root.string();
  if (name.empty()) return "the name of the directory to write is empty";
  if (fs::exists(directory.root) && !fs::is_directory(directory.root))
    throw FileError(directory.root, "is not a directory");
  if (const std::optional<fs::path> input = endangered_input(directory, loaded))
    return input->string() + ": is read by the scene and would be replaced by the run; write to another directory";
  if (options.resume) {
    if (!fs::exists(directory.root)) return name + ": nothing to resume, the directory does not exist";
    if (!fs::exists(directory.checkpoint()) && !holds_nothing_yet(directory))
      return name + ": nothing to resume, the directory holds no checkpoint.bin; start anew with --force";
    return std::nullopt;
  }
  if (!options.force && fs::exists(directory.root) && !fs::is_empty(directory.root))
    return name + ": directory is not empty; continue the run in it with --resume or overwrite it with --force";
  return std::nullopt;
}

DirectoryLock::DirectoryLock(const RunDirectory& directory)
    : descriptor_(open(directory.root.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  // A file system that knows no locks, or a directory that may be written but not read, goes without.
  taken_by_another_ = descriptor_ >= 0 && flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

DirectoryLock::~DirectoryLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::optional<std::string> missing_frames(const RunDirectory& directory, std::span<const FrameFormat> formats,
                                          int n_frames) {
  std::optional<fs::path> first;
  int n = 0;
  for (int frame = 0; frame < n_frames; ++frame)
    for (const FrameFormat format : formats) {
      const fs::path file = frame_path(frame, format == FrameFormat::Vtp ? "vtp" : "obj");
      if (fs::exists(directory.root / file)) continue;
      if (n++ == 0) first = file;
    }
  if (n == 0) return std::nullopt;
  return first->string() + (n == 1 ? " is" : " and " + std::to_string(n - 1) + " more are") +
         " missing: gone when the run was resumed, which cannot make them again";
}

void remove_frames(const RunDirectory& directory, int first_frame) {
  for (const fs::path& file : entries(directory.root / "frames")) {
    const std::optional<int> number =
        frame_number(file.extension() == ".tmp" ? fs::path(file).replace_extension() : file);
    if (number && (*number >= first_frame || file.extension() == ".tmp")) fs::remove(file);
  }
}

void remove_earlier_run(const RunDirectory& directory) {
  for (const char* name : run_files) {
    if (directory.root / name != directory.checkpoint()) fs::remove(directory.root / name);
    fs::remove(directory.root / (std::string(name) + ".tmp"));
  }
  remove_frames(directory, 0);
}

}  // namespace crease
