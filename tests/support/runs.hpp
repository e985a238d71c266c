// SPDX-License-Identifier: MIT
#pragma once

// Small scenes made in code, and the files that a run of them leaves.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "crease/geometry/grid.hpp"
#include "crease/stepper/run.hpp"

namespace crease::testing {

namespace fs = std::filesystem;

inline void add_sheet(LoadedScene& loaded, ClothSpec spec) {
  Cloth cloth = make_cloth(make_grid(std::get<GridOptions>(spec.shape)));
  for (std::size_t k = 0; k < spec.pins.size(); ++k)
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
      if (cloth.mesh.X[v] == spec.pins[k].where.material) cloth.pins[v] |= std::uint64_t{1} << k;
  loaded.scene.cloths.push_back(std::move(spec));
  loaded.cloths.push_back(std::move(cloth));
}

/// A sheet of 1 x 1 m held at two corners, one of them moving at 0.2 m/s along y.
inline ClothSpec hanging_sheet() {
  ClothSpec spec;
  spec.shape = GridOptions{.cells = {3, 3}};
  PinSpec still, moving;
  moving.where.material = {1, 0};
  moving.motion = {{.time = 0, .velocity = {0, 0.2, 0}}};
  spec.pins = {still, moving};
  return spec;
}

/// 45 steps of 5 ms, both frame formats.
inline LoadedScene hanging_scene() {
  LoadedScene loaded;
  loaded.scene.name = "hanging";
  loaded.scene.duration = 0.225;
  loaded.scene.formats = {FrameFormat::Vtp, FrameFormat::Obj};
  loaded.resolved_json = R"({"name": "hanging"})";
  add_sheet(loaded, hanging_sheet());
  return loaded;
}

/// A free sheet that lies over the edge of a table and bends down there, remeshed as it goes.
inline LoadedScene table_scene() {
  LoadedScene loaded;
  loaded.scene.name = "table";
  loaded.scene.duration = 0.225;
  loaded.resolved_json = R"({"name": "table"})";
  Obstacle table;
  table.name = "table";
  table.shape = make_box({1, 2, 1});
  table.start.position = {0.9, 0.5, -0.5005};
  loaded.scene.obstacles = {table};
  ClothSpec spec;
  spec.shape = GridOptions{.cells = {4, 4}};
  spec.remeshing = RemeshMethod::Conformal;
  spec.adapt.size = {0.1, 0.3};
  add_sheet(loaded, spec);
  return loaded;
}

inline std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// steps.csv by column name.
inline std::map<std::string, std::vector<double>> read_steps(const fs::path& directory) {
  std::ifstream in(directory / "steps.csv");
  std::string line, cell;
  std::vector<std::string> names;
  std::getline(in, line);
  for (std::istringstream cells(line); std::getline(cells, cell, ',');) names.push_back(cell);
  std::map<std::string, std::vector<double>> table;
  for (const std::string& name : names) table[name];
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    for (const std::string& name : names) {
      std::getline(cells, cell, ',');
      table[name].push_back(std::stod(cell));
    }
  }
  return table;
}

/// Everything a run wrote that does not measure wall time: files by name, columns of steps.csv.
inline std::map<std::string, std::string> repeatable_bytes(const fs::path& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    const std::string name = fs::relative(entry.path(), directory).generic_string();
    if (!entry.is_regular_file() || name == "summary.json" || name == "steps.csv") continue;
    files[name] = bytes_of(entry.path());
  }
  for (const auto& [name, values] : read_steps(directory))
    if (!name.starts_with("t_"))
      files["steps.csv:" + name].assign(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  return files;
}

/// Names of the entries that differ, so that a failure shows them and not megabytes.
inline std::vector<std::string> differences(const std::map<std::string, std::string>& a,
                                            const std::map<std::string, std::string>& b) {
  std::vector<std::string> names;
  for (const auto& [name, bytes] : a)
    if (!b.contains(name) || b.at(name) != bytes) names.push_back(name);
  for (const auto& [name, bytes] : b)
    if (!a.contains(name)) names.push_back(name);
  return names;
}

}  // namespace crease::testing
