// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>

#include "block_pattern.hpp"
#include "crease/base/require.hpp"
#include "crease/dynamics/assemble.hpp"
#include "crease/dynamics/bending.hpp"
#include "crease/dynamics/membrane.hpp"
#include "crease/geometry/triangle.hpp"
#include "element.hpp"

namespace crease {

FaceState read_face(const Cloth& cloth, int face, double density) {
  FaceState out;
  out.vertex = cloth.mesh.face(face);
  for (int i = 0; i < 3; ++i) {
    const int v = out.vertex[i];
    out.state.X[i] = cloth.mesh.X[v];
    out.state.x[i] = cloth.mesh.x[v];
    out.state.V[i] = cloth.V[v];
    out.state.v[i] = cloth.v[v];
    out.eol = out.eol || cloth.is_eol(v);
  }
  out.mass = density * material_area(out.state.X);
  std::array<Vec3, 3> w = out.state.v;
  if (out.eol) {
    out.F = deformation_gradient(out.state.X, out.state.x);
    for (int i = 0; i < 3; ++i) w[i] -= out.F * out.state.V[i];
  }
  out.motion = triangle_motion(w, out.mass);
  return out;
}

Energies energies_of(const FaceState& face, const Vec3& gravity, double membrane) {
  Energies energies;
  energies.kinetic = face.motion.kinetic_energy;
  energies.membrane = membrane;
  for (int i = 0; i < 3; ++i) {
    const Vec3& x = face.state.x[i];
    energies.gravitational -= face.mass / 3 * gravity.dot(x);
    energies.momentum += face.motion.p[i];
    energies.angular_momentum += x.cross(face.motion.p[i]);
  }
  return energies;
}

Energies& Energies::operator+=(const Energies& part) {
  kinetic += part.kinetic;
  membrane += part.membrane;
  bending += part.bending;
  gravitational += part.gravitational;
  momentum += part.momentum;
  angular_momentum += part.angular_momentum;
  return *this;
}

Energies measure_energies(const Cloth& cloth, const Material& material, const Vec3& gravity) {
  require(cloth.mesh.is_compact(), "measure_energies: expected a compact mesh");
  require_valid(material);
  const Mesh& mesh = cloth.mesh;
  Energies energies;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const FaceState face = read_face(cloth, f, material.density);
    energies += energies_of(face, gravity, membrane_energy(face.state.X, face.state.x, material));
  }
  if (material.bending == 0) return energies;
  for (const Hinge& hinge : all_hinges(mesh)) {
    const BendingElement element = bending_element(flat_hinge(mesh, hinge), material.bending);
    Vec3 curvature = Vec3::Zero();
    for (int i = 0; i < 4; ++i) curvature += element.k[i] * mesh.x[hinge.vertex[i]];
    energies.bending += 0.5 * element.c * curvature.squaredNorm();
  }
  return energies;
}

}  // namespace crease
