// SPDX-License-Identifier: MIT
#include "shipped_scenes.hpp"

#include <algorithm>

#include "crease/stepper/suggest.hpp"

namespace crease::cli {
namespace fs = std::filesystem;
namespace {

fs::path scenes_folder() {
  std::error_code error;  // a place that cannot be looked at does not hold the scenes
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  for (const fs::path& folder : {program.parent_path() / CREASE_SCENES_FROM_BIN, fs::path(CREASE_SOURCE_SCENES)})
    if (fs::is_directory(folder, error)) return folder.lexically_normal();
  return {};
}

}  // namespace

std::vector<fs::path> shipped_scenes() {
  std::vector<fs::path> files;
  const fs::path folder = scenes_folder();
  if (folder.empty()) return files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

fs::path find_scene(const std::string& scene) {
  std::error_code error;
  // A directory is no scene: `crease run edge -o edge` leaves one behind that has a scene's name.
  if (fs::exists(scene, error) && !fs::is_directory(scene, error)) return scene;
  std::vector<std::string> names;
  for (const fs::path& file : shipped_scenes()) {
    if (scene == file.stem() || scene == file.filename()) return file;
    names.push_back(file.stem().string());
  }
  const bool bare_name = fs::path(scene).filename() == scene && fs::path(scene).extension().empty();
  if (bare_name && !fs::is_directory(scene, error))
    throw UsageError("no file and no shipped scene is named \"" + scene + "\"" + suggestion(scene, names));
  return scene;  // reading it will say why it cannot be read
}

}  // namespace crease::cli
