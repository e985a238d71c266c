// SPDX-License-Identifier: MIT
#include "crease/constraints/lagrangian.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "crease/base/require.hpp"
#include "crease/geometry/feature_place.hpp"
#include "crease/geometry/normal_cone.hpp"

namespace crease {
namespace {

/// As shares of the contact threshold: how near to a feature a vertex stands on it, which is where conformal remeshing
/// begins to put vertices there; and the gap that is kept to a wire.
constexpr double standing_share = 0.25, wire_gap_share = 0.1;

struct Feature {
  FeatureId id;
  Vec3 point = Vec3::Zero();    ///< of it, nearest to the cloth [m]
  std::vector<Vec3> normals{};  ///< outward, of its faces; empty on a wire
};

Feature feature_at(const FeatureId& id, std::span<const PosedObstacle> obstacles, const Vec3& x) {
  const auto& [shape, pose] = obstacles[id.obstacle];
  Feature feature{id, nearest_on(id, obstacles, x)};
  if (id.kind == FeatureKind::Corner) {
    feature.normals = shape->corners[id.index].normals;
  } else {
    const SharpEdge& edge = shape->edges[id.index];
    if (!edge.free_cone) feature.normals.assign(edge.normals.begin(), edge.normals.end());
  }
  for (Vec3& n : feature.normals) n = pose.rotation * n;
  return feature;
}

// A corner before the edges that end in it.
std::optional<Feature> stands_on(int obstacle, std::span<const PosedObstacle> obstacles, const Vec3& x, double reach) {
  const ObstacleShape& shape = *obstacles[obstacle].shape;
  const auto near = [&](const FeatureId& id) -> std::optional<Feature> {
    Feature feature = feature_at(id, obstacles, x);
    if ((x - feature.point).norm() > reach) return std::nullopt;
    return feature;
  };
  for (int c = 0; c < static_cast<int>(shape.corners.size()); ++c)
    if (auto found = near({obstacle, FeatureKind::Corner, c})) return found;
  for (int e = 0; e < static_cast<int>(shape.edges.size()); ++e)
    if (auto found = near({obstacle, FeatureKind::Edge, e})) return found;
  return std::nullopt;
}

// Half-way between the outermost two, however many there are on either side; zero if they cancel.
Vec3 bisector(const std::vector<Vec3>& normals) {
  Vec3 sum = 2 * normals.front();
  for (std::size_t i = 0; i < normals.size(); ++i)
    for (std::size_t j = i + 1; j < normals.size(); ++j)
      if (const Vec3 pair = normals[i] + normals[j]; pair.norm() < sum.norm()) sum = pair;
  constexpr double lost = 1e-6;  // far above the round-off of unit vectors
  return sum.norm() > lost ? Vec3(sum.normalized()) : Vec3(Vec3::Zero());
}

class Converter {
 public:
  Converter(const Cloth& cloth, std::span<const PosedObstacle> obstacles, LagrangianNormals normals, double threshold)
      : cloth_(cloth), obstacles_(obstacles), normals_(normals), threshold_(threshold) {}

  void convert(const Contact& contact, std::vector<Contact>& out);
  /// One contact for every vertex that stands on a wire.
  void add_standing_on_wires(std::vector<Contact>& out) const;

 private:
  /// A vertex on a wire, and the normals of the cloth's edges and faces that meet the wire in it.
  struct OnWire {
    Feature feature;
    std::vector<Vec3> normals;
  };
  int standing_vertex(const Contact& contact) const;
  Vec3 point_of_cloth(const Contact& contact) const;
  void ask(Contact contact, const Feature& feature, std::vector<Contact>& out) const;

  const Cloth& cloth_;
  std::span<const PosedObstacle> obstacles_;
  LagrangianNormals normals_;
  double threshold_;
  std::map<std::pair<int, int>, OnWire> on_wires_;  // by obstacle and vertex
};

// The first of its vertices that stands on its feature, and so answers for the cloth there; none if there is none.
int Converter::standing_vertex(const Contact& contact) const {
  const auto end = contact.vertices.begin() + contact.n_vertices;
  const auto found = std::find_if(contact.vertices.begin(), end, [&](int v) {
    const Vec3& x = cloth_.mesh.x[v];
    return (x - feature_at(contact.feature, obstacles_, x).point).norm() <= standing_share * threshold_;
  });
  return found == end ? Mesh::none : *found;
}

Vec3 Converter::point_of_cloth(const Contact& contact) const {
  Vec3 x = Vec3::Zero();
  for (int k = 0; k < contact.n_vertices; ++k) x += contact.weights[k] * cloth_.mesh.x[contact.vertices[k]];
  return x;
}

void Converter::ask(Contact contact, const Feature& feature, std::vector<Contact>& out) const {
  const Vec3 away = point_of_cloth(contact) - feature.point;
  contact.feature = feature.id;
  contact.point = feature.point;
  contact.velocity = obstacles_[feature.id.obstacle].pose.velocity_at(feature.point);
  std::vector<Vec3> asked = feature.normals;
  if (normals_ == LagrangianNormals::Averaged) asked = {mean_normal(feature.normals)};
  for (const Vec3& n : asked) {
    contact.normal = n;
    contact.distance = n.dot(away);
    out.push_back(contact);
  }
}

void Converter::convert(const Contact& contact, std::vector<Contact>& out) {
  if (contact.type == ContactType::VertexFace) {
    const Vec3& x = cloth_.mesh.x[contact.vertices[0]];
    const auto feature = stands_on(contact.obstacle, obstacles_, x, standing_share * threshold_);
    if (!feature) {
      out.push_back(contact);
    } else if (out.empty() || out.back().vertices != contact.vertices ||
               out.back().feature.obstacle != contact.obstacle) {
      ask(contact, *feature, out);  // once, however many faces it touches there
    }
    return;
  }
  if (contact.feature.kind == FeatureKind::None) {  // a blunt edge is surface
    out.push_back(contact);
    return;
  }
  const Feature feature = feature_at(contact.feature, obstacles_, contact.point);
  const int vertex = standing_vertex(contact);
  if (!feature.normals.empty()) {
    if (vertex == Mesh::none) ask(contact, feature, out);
  } else if (vertex == Mesh::none) {
    out.push_back(contact);
    out.back().distance -= wire_gap_share * threshold_;
  } else {
    OnWire& on_wire = on_wires_[{contact.obstacle, vertex}];
    on_wire.feature = feature_at(contact.feature, obstacles_, cloth_.mesh.x[vertex]);
    on_wire.normals.push_back(contact.normal);
  }
}

void Converter::add_standing_on_wires(std::vector<Contact>& out) const {
  for (const auto& [key, on_wire] : on_wires_) {
    const auto& [obstacle, vertex] = key;
    Contact contact;
    contact.obstacle = obstacle;
    contact.feature = on_wire.feature.id;
    contact.n_vertices = 1;
    contact.vertices[0] = vertex;
    contact.weights[0] = 1;
    contact.point = on_wire.feature.point;
    contact.velocity = obstacles_[obstacle].pose.velocity_at(contact.point);
    contact.normal = bisector(on_wire.normals);
    if (contact.normal.isZero(0)) continue;  // the sheet hangs double, and nothing tells its side
    contact.distance = contact.normal.dot(cloth_.mesh.x[vertex] - contact.point) - wire_gap_share * threshold_;
    out.push_back(contact);
  }
}

// An edge of the obstacle on which both vertices are; 0 = none.
int common_tag(const FeatureId& a, const FeatureId& b, std::span<const PosedObstacle> obstacles) {
  for (const FeatureId& edge : {a, b})
    if (edge.kind == FeatureKind::Edge && lies_on(a, edge, obstacles) && lies_on(b, edge, obstacles))
      return edge_tag(edge.obstacle, edge.index);
  return 0;
}

// With its third corner on the edge too, a face would have no area beside the chain.
bool closes_a_line(const Cloth& cloth, int vertex, const FeatureId& id, std::span<const PosedObstacle> obstacles) {
  const Mesh& mesh = cloth.mesh;
  const auto outgoing = mesh.outgoing(vertex);
  return std::any_of(outgoing.begin(), outgoing.end(), [&](int h) {
    const FeatureId &p = cloth.feature[mesh.to(h)], &q = cloth.feature[mesh.opposite(h)];
    const int tag = common_tag(id, p, obstacles);
    return tag != 0 && tag == common_tag(id, q, obstacles) && tag == common_tag(p, q, obstacles);
  });
}

}  // namespace

void mark_standing(Cloth& cloth, std::span<const PosedObstacle> obstacles, double threshold) {
  Mesh& mesh = cloth.mesh;
  for (int v = 0; v < mesh.vertex_slots(); ++v) {
    if (!mesh.vertex_live(v) || cloth.pins[v] != 0 || cloth.is_eol(v) || mesh.is_material_corner(v) || mesh.on_seam(v))
      continue;
    for (int o = 0; o < static_cast<int>(obstacles.size()) && !cloth.is_eol(v); ++o) {
      const auto feature = stands_on(o, obstacles, mesh.x[v], standing_share * threshold);
      if (feature && !closes_a_line(cloth, v, feature->id, obstacles)) cloth.feature[v] = feature->id;
    }
  }
  for (const int h : mesh.edges())
    if (const FeatureId& a = cloth.feature[mesh.from(h)], &b = cloth.feature[mesh.to(h)];
        a.kind != FeatureKind::None && b.kind != FeatureKind::None && mesh.tag(h) == 0)
      mesh.set_tag(h, common_tag(a, b, obstacles));
}

std::vector<Contact> lagrangian_contacts(const Cloth& cloth, std::span<const Contact> contacts,
                                         std::span<const PosedObstacle> obstacles, LagrangianNormals normals,
                                         double threshold) {
  require(threshold >= 0, "lagrangian_contacts: expected a threshold >= 0");
  std::vector<Contact> out;
  out.reserve(contacts.size());
  Converter converter(cloth, obstacles, normals, threshold);
  for (const Contact& contact : contacts) {
    require(contact.obstacle >= 0 && contact.obstacle < static_cast<int>(obstacles.size()),
            "lagrangian_contacts: expected contacts with the given obstacles");
    converter.convert(contact, out);
  }
  converter.add_standing_on_wires(out);
  return out;
}

}  // namespace crease
