// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "crease/geometry/cloth.hpp"
#include "crease/stepper/scene.hpp"

namespace crease {

struct SceneProblem {
  std::string pointer;  ///< JSON pointer, "" for the whole document
  std::string message;  ///< what is wrong and what would be right
};

/// All problems of a scene at once.
class SceneError : public std::runtime_error {
 public:
  SceneError(const std::filesystem::path& file, std::vector<SceneProblem> problems);
  const std::vector<SceneProblem>& problems() const { return problems_; }

 private:
  std::vector<SceneProblem> problems_;
};

/// A scene ready to run: parsed, defaults filled in, meshes read or made, pins resolved to vertices.
struct LoadedScene {
  Scene scene;
  std::vector<Cloth> cloths;  ///< at time 0, pins set
  std::string
      resolved_json;  ///< the scene with all defaults, enough to repeat the run (absolute mesh paths); one line end
  std::filesystem::path file = {};  ///< where it was read; a run that would overwrite it is refused
};

/// Reads, overrides, validates.
/// @param overrides  (dotted path, JSON text) from --set, applied in order before validation
/// Throws SceneError with every problem found; std::runtime_error if the file cannot be read.
LoadedScene load_scene(const std::filesystem::path& file,
                       const std::vector<std::pair<std::string, std::string>>& overrides = {});

/// The JSON Schema of the scene format.
std::string scene_schema();

}  // namespace crease
