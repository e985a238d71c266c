// SPDX-License-Identifier: MIT
#include <algorithm>
#include <stdexcept>

#include "crease/base/require.hpp"
#include "crease/geometry/grid.hpp"
#include "crease/geometry/obj_io.hpp"
#include "scene_io_parts.hpp"

namespace crease {
namespace {

constexpr double border_tolerance = 1e-9;  // share of the extent by which a vertex may miss the edge it belongs to

int nearest_vertex(const Mesh& mesh, const Vec2& X) {
  int nearest = 0;
  for (int i = 1; i < mesh.n_vertices(); ++i)
    if ((mesh.X[i] - X).squaredNorm() < (mesh.X[nearest] - X).squaredNorm()) nearest = i;
  return nearest;
}

double longest_edge(const Mesh& mesh, int vertex) {
  double longest = 0;
  for (const int neighbour : mesh.neighbours(vertex))
    longest = std::max(longest, (mesh.X[neighbour] - mesh.X[vertex]).norm());
  return longest;
}

struct Extent {
  Vec2 low, high;
};

Extent material_extent(const Mesh& mesh) {
  Extent extent{mesh.X[0], mesh.X[0]};
  for (const Vec2& X : mesh.X) {
    extent.low = extent.low.cwiseMin(X);
    extent.high = extent.high.cwiseMax(X);
  }
  return extent;
}

std::vector<int> vertices_on_edge(const std::string& name, const Mesh& mesh) {
  const auto [low, high] = material_extent(mesh);
  const int axis = name[0] == 'u' ? 0 : 1;
  const double end = name[1] == '0' ? low[axis] : high[axis];
  const double tolerance = border_tolerance * (high[axis] - low[axis]);
  std::vector<int> vertices;
  for (int i = 0; i < mesh.n_vertices(); ++i)
    if (std::abs(mesh.X[i][axis] - end) <= tolerance) vertices.push_back(i);
  return vertices;
}

Mesh make_mesh(const ClothSpec& spec) {
  if (const auto* grid = std::get_if<GridOptions>(&spec.shape)) return make_grid(*grid);
  return read_obj(std::get<std::filesystem::path>(spec.shape));
}

// A triangle crushed to a line or a point in the world has no deformation gradient of full rank to start from.
void require_world_areas(const Mesh& mesh) {
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const auto& [a, b, c] = mesh.face(f);
    const Vec3 ab = mesh.x[b] - mesh.x[a], ac = mesh.x[c] - mesh.x[a];
    const double longest = std::max(ab.squaredNorm(), ac.squaredNorm());
    constexpr double zero_area = 1e-12;  // rounding of three points on a line
    require(ab.cross(ac).norm() > zero_area * longest,
            "triangle " + std::to_string(f + 1) + " has zero area in the world: move its corners (v) apart");
  }
}

// Vertices that two pins hold along one axis are fine as long as both move alike.
std::optional<std::string> conflict(const std::vector<PinSpec>& pins, size_t k, const Cloth& cloth) {
  const auto same = [](const MotionKey& a, const MotionKey& b) { return a.time == b.time && a.velocity == b.velocity; };
  for (size_t other = 0; other < k; ++other) {
    const PinSpec &a = pins[other], &b = pins[k];
    bool shared_axis = false;
    for (int axis = 0; axis < 3; ++axis) shared_axis = shared_axis || (a.axes[axis] && b.axes[axis]);
    const bool alike =
        a.ramp == b.ramp && std::equal(a.motion.begin(), a.motion.end(), b.motion.begin(), b.motion.end(), same);
    if (!shared_axis || alike) continue;
    for (size_t i = 0; i < cloth.pins.size(); ++i)
      if ((cloth.pins[i] >> other & 1) && (cloth.pins[i] >> k & 1))
        return "holds vertex " + std::to_string(i) + " along an axis that pin " + std::to_string(other) +
               " moves differently; give them different axes or vertices";
  }
  return std::nullopt;
}

// What is sewn to a pinned vertex is pinned with it.
void hold(int vertex, std::uint64_t bit, Cloth& cloth) {
  for (int v = vertex; (cloth.pins[v] & bit) == 0; v = cloth.mesh.tied(v)) cloth.pins[v] |= bit;
}

void set_pins(const ClothSpec& spec, const std::string& pointer, Cloth& cloth, ProblemList& problems) {
  for (size_t k = 0; k < spec.pins.size(); ++k) {
    const std::string pin = pointer + "/pins/" + std::to_string(k);
    if (problems.under(pin + "/where")) continue;
    try {
      for (const int i : pinned_vertices(spec.pins[k].where, cloth.mesh)) hold(i, std::uint64_t{1} << k, cloth);
    } catch (const std::invalid_argument& error) {
      problems.add(pin + "/where", error.what());
      continue;
    }
    if (const auto message = conflict(spec.pins, k, cloth)) problems.add(pin, *message);
  }
}

}  // namespace

std::vector<int> pinned_vertices(const PinWhere& where, const Mesh& mesh) {
  switch (where.kind) {
    case PinWhere::Kind::Corner: {
      const auto [low, high] = material_extent(mesh);
      const Vec2 corner(where.name[0] == '0' ? low[0] : high[0], where.name[1] == '0' ? low[1] : high[1]);
      return {nearest_vertex(mesh, corner)};
    }
    case PinWhere::Kind::Edge:
      return vertices_on_edge(where.name, mesh);
    case PinWhere::Kind::Material: {
      const int vertex = nearest_vertex(mesh, where.material);
      const double distance = (mesh.X[vertex] - where.material).norm();
      require(
          distance <= longest_edge(mesh, vertex),
          "holds no vertex: the nearest one is " + std::to_string(distance) + " m away, farther than its own edges");
      return {vertex};
    }
    case PinWhere::Kind::Vertices: {
      std::vector<int> vertices = where.vertices;
      std::sort(vertices.begin(), vertices.end());
      vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
      require(!vertices.empty() && vertices.front() >= 0 && vertices.back() < mesh.n_vertices(),
              "holds no vertex: the cloth has vertices 0 to " + std::to_string(mesh.n_vertices() - 1));
      return vertices;
    }
  }
  return {};
}

std::vector<Cloth> make_cloths(const Scene& scene, ProblemList& problems) {
  std::vector<Cloth> cloths;
  for (size_t i = 0; i < scene.cloths.size(); ++i) {
    const std::string pointer = "/cloths/" + std::to_string(i);
    const ClothSpec& spec = scene.cloths[i];
    if (problems.at(pointer) || problems.under(pointer + "/shape") || problems.under(pointer + "/placement")) continue;
    const bool is_grid = std::holds_alternative<GridOptions>(spec.shape);
    try {
      Cloth cloth = make_cloth(make_mesh(spec));
      require_world_areas(cloth.mesh);
      std::fill(cloth.v.begin(), cloth.v.end(), spec.velocity);
      set_pins(spec, pointer, cloth, problems);
      cloths.push_back(std::move(cloth));
    } catch (const std::exception& error) {
      problems.add(pointer + (is_grid ? "/shape/grid" : "/shape/mesh"), error.what());
    }
  }
  return cloths;
}

}  // namespace crease
