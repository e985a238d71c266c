// SPDX-License-Identifier: MIT
#include <algorithm>

#include "crease/base/require.hpp"
#include "crease/dynamics/bending.hpp"
#include "crease/geometry/triangle.hpp"
#include "element.hpp"

namespace crease {

FaceConstants face_constants(const Material& material, const Vec3& gravity, double stiffness_scale) {
  return {moduli_of(material), material.density, stiffness_scale, {gravity.x(), gravity.y(), gravity.z()}};
}

void read_face(const Cloth& cloth, int face, FaceBatch& batch, int lane) {
  const std::array<int, 3>& v = cloth.mesh.face(face);
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      batch.X[i][axis][lane] = cloth.mesh.X[v[i]][axis];
      batch.V[i][axis][lane] = cloth.V[v[i]][axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
      batch.x[i][axis][lane] = cloth.mesh.x[v[i]][axis];
      batch.v[i][axis][lane] = cloth.v[v[i]][axis];
    }
  }
  batch.double_area[lane] = orient2d(cloth.mesh.X[v[0]], cloth.mesh.X[v[1]], cloth.mesh.X[v[2]]);
}

void read_hinge(const Mesh& mesh, const Hinge& hinge, HingeBatch& batch, int lane) {
  const std::array<Vec2, 4> X = flat_hinge(mesh, hinge);
  for (int i = 0; i < 4; ++i) {
    for (int axis = 0; axis < 2; ++axis) batch.X[i][axis][lane] = X[i][axis];
    for (int axis = 0; axis < 3; ++axis) batch.x[i][axis][lane] = mesh.x[hinge.vertex[i]][axis];
  }
}

Energies energies_of(const FaceBatch& batch, int lane) {
  Energies energies;
  energies.kinetic = batch.kinetic[lane];
  energies.membrane = batch.membrane[lane];
  energies.gravitational = batch.gravitational[lane];
  for (int axis = 0; axis < 3; ++axis) {
    energies.momentum[axis] = batch.momentum[axis][lane];
    energies.angular_momentum[axis] = batch.angular_momentum[axis][lane];
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
  const FaceConstants constants = face_constants(material, gravity, 0);
  const ElementKernels& kernels = find_element_kernels(ElementKernelSet::Best);
  FaceBatch batch;
  for (int first = 0; first < mesh.n_faces(); first += batch_lanes) {
    for (int lane = 0; lane < batch_lanes; ++lane)
      read_face(cloth, std::min(first + lane, mesh.n_faces() - 1), batch, lane);
    kernels.faces(constants, batch);
    for (int lane = 0; lane < std::min(batch_lanes, mesh.n_faces() - first); ++lane)
      energies += energies_of(batch, lane);
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
