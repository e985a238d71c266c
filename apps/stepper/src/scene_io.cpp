// SPDX-License-Identifier: MIT
#include "crease/stepper/scene_io.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include <nlohmann/json.hpp>

#include "scene_io_parts.hpp"

namespace crease {
namespace {

std::string read_file(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) throw std::runtime_error(file.string() + ": is a directory, not a scene");
  if (std::filesystem::is_character_file(file) || std::filesystem::is_block_file(file))
    throw std::runtime_error(file.string() + ": is a device, not a scene");  // which may have no end
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read: " + std::strerror(errno));
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) throw std::runtime_error(file.string() + ": reading failed");
  return text;
}

std::string join(const std::filesystem::path& file, const std::vector<SceneProblem>& problems) {
  std::string text;
  for (const auto& [pointer, message] : problems) {
    if (!text.empty()) text += '\n';
    text.append(file.string()).append(": ");
    if (!pointer.empty()) text.append(pointer).append(": ");
    text += message;
  }
  return text;
}

void make_mesh_paths_absolute(Json& filled, const std::filesystem::path& scene_file) {
  const std::filesystem::path folder = std::filesystem::absolute(scene_file).parent_path();
  const auto make_absolute = [&](Json& object, const char* key) {
    if (object.is_object() && object.contains(key) && object[key].is_string())
      object[key] = (folder / object[key].get<std::string>()).lexically_normal().string();
  };
  if (!filled.is_object()) return;
  if (filled["cloths"].is_array())
    for (Json& cloth : filled["cloths"])
      if (cloth.is_object()) make_absolute(cloth["shape"], "mesh");
  if (filled["obstacles"].is_array())
    for (Json& obstacle : filled["obstacles"])
      if (obstacle.is_object() && obstacle.contains("mesh")) make_absolute(obstacle["mesh"], "file");
}

}  // namespace

SceneError::SceneError(const std::filesystem::path& file, std::vector<SceneProblem> problems)
    : std::runtime_error(join(file, problems)), problems_(std::move(problems)) {}

LoadedScene load_scene(const std::filesystem::path& file,
                       const std::vector<std::pair<std::string, std::string>>& overrides) {
  ProblemList problems;
  std::optional<Json> document = parse_scene_text(read_file(file), problems);
  if (!document) throw SceneError(file, problems.take());
  ProblemList unknown_for_now;  // a material's name may still be overridden
  expand_materials(*document, unknown_for_now);
  for (const auto& [path, text] : overrides) apply_override(*document, path, text, problems);
  expand_materials(*document, problems);
  fill_dependent_defaults(*document);

  static const Json schema = Json::parse(scene_schema());
  Json filled = check_and_fill(*document, schema, problems);
  if (filled.is_null()) throw SceneError(file, problems.take());
  make_mesh_paths_absolute(filled, file);
  LoadedScene loaded;
  loaded.file = file;
  loaded.scene = read_scene(filled);
  read_obstacle_meshes(filled, loaded.scene, problems);
  check_scene(loaded.scene, filled, problems);
  loaded.cloths = make_cloths(loaded.scene, problems);
  if (!problems.empty()) throw SceneError(file, problems.take());
  loaded.resolved_json = readable_json(filled);
  return loaded;
}

}  // namespace crease
