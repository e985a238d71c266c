// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "crease/geometry/cloth.hpp"
#include "crease/stepper/scene.hpp"
#include "schema_check.hpp"

// The stages of load_scene(), in order. Each adds what it finds wrong to the list and carries on with what is right, so
// that one reading reports everything.
namespace crease {

/// JSON with // comments. A number that no double holds (1e999, NaN, Infinity) and a key given twice are problems at
/// their pointer; any other syntax error is a problem of the whole document and ends the reading (nothing returned).
std::optional<Json> parse_scene_text(const std::string& text, ProblemList& problems);

/// Sets what a dotted path names, making objects (and, for a number, lists) on the way; the text is JSON, or else taken
/// as a string.
void apply_override(Json& document, const std::string& path, const std::string& text, ProblemList& problems);

/// Puts the numbers of shipped materials in place of their names.
void expand_materials(Json& document, ProblemList& problems);

/// Gives unnamed cloths and obstacles a name, and grids a placement: the defaults that depend on something else.
void fill_dependent_defaults(Json& document);

/// Scene from a document that check_and_fill() returned; what is null there keeps the default of scene.hpp.
Scene read_scene(const Json& filled);

/// Reads the files of mesh obstacles and makes their shapes; every problem of a mesh is one of its file.
void read_obstacle_meshes(const Json& filled, Scene& scene, ProblemList& problems);

/// Whether two points can be joined by a segment of a wire: finite, unlike each other.
bool is_segment(const Vec3& a, const Vec3& b);

/// What a schema cannot say: orders, relations between keys, names given twice.
void check_scene(const Scene& scene, const Json& filled, ProblemList& problems);

/// Meshes read or made, velocities and pins set.
std::vector<Cloth> make_cloths(const Scene& scene, ProblemList& problems);

/// Vertices that a pin holds at time 0, ascending. Throws std::invalid_argument if there are none.
std::vector<int> pinned_vertices(const PinWhere& where, const Mesh& mesh);

}  // namespace crease
