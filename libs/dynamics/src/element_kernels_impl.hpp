// SPDX-License-Identifier: MIT
// Included by one source file a kind of processor, which sets `CREASE_LANES`, the doubles of a vector register.
#include "element_kernels.hpp"

#ifdef EIGEN_WORLD_VERSION
#error "No Eigen in kernels: what it inlines would be laid out, and shared, as on this one kind of processor."
#endif

namespace crease {
namespace {

typedef double Vector __attribute__((vector_size(8 * CREASE_LANES)));
typedef double InMemory __attribute__((vector_size(8 * CREASE_LANES), may_alias));

inline InMemory& at(Lanes& lanes, int first) {
  return *reinterpret_cast<InMemory*>(lanes + first);
}

inline Axes<Vector> axes(Lanes (&lanes)[3], int first) {
  return {{at(lanes[0], first), at(lanes[1], first), at(lanes[2], first)}};
}

inline void put(Lanes (&lanes)[3], int first, const Axes<Vector>& value) {
  for (int axis = 0; axis < 3; ++axis) at(lanes[axis], first) = value[axis];
}

/// Inertia, weight, energies and momenta of what the world velocities w_i of the material at the corners say.
inline void add_motion(const FaceConstants& constants, FaceBatch& batch, int first, Vector mass,
                       const Axes<Vector> (&x)[3], const Axes<Vector> (&w)[3], Axes<Vector> (&force)[3]) {
  const Vector zero{};
  const Axes<Vector> none{{zero, zero, zero}}, sum = w[0] + w[1] + w[2];
  const Axes<Vector> gravity{{zero + constants.gravity[0], zero + constants.gravity[1], zero + constants.gravity[2]}};
  const Vector twelfth = mass / 12, third = mass / 3;
  Vector squares = dot(sum, sum), height = zero;
  Axes<Vector> momentum = none, angular = none;
  for (int i = 0; i < 3; ++i) {
    const Axes<Vector> p = twelfth * (w[i] + sum);
    put(batch.impulse[i], first, p);
    momentum = momentum + p;
    angular = angular + cross(x[i], p);
    squares += dot(w[i], w[i]);
    height += dot(gravity, x[i]);
    force[i] = force[i] + third * gravity;
  }
  at(batch.kinetic, first) = mass / 24 * squares;
  at(batch.gravitational, first) = -third * height;
  put(batch.momentum, first, momentum);
  put(batch.angular_momentum, first, angular);
}

/// The blocks of vertices 1 and 2 decide those of vertex 0.
inline void put_matrix(const FaceConstants& constants, const MembraneTerms<Vector>& membrane, Vector mass, int first,
                       Lanes (&H)[6][9]) {
  const Vector twelfth = mass / 12, sixth = 2 * twelfth;
  for (int col = 0; col < 3; ++col) {
    for (int row = 0; row < 3; ++row) {
      const int k = 3 * col + row, mirror = 3 * row + col;
      const Vector K11 = constants.stiffness_scale * membrane.K11[k], K22 = constants.stiffness_scale * membrane.K22[k],
                   K12 = constants.stiffness_scale * membrane.K12[k],
                   K21 = constants.stiffness_scale * membrane.K12[mirror];
      const Vector off = row == col ? twelfth : Vector{}, on = row == col ? sixth : Vector{};
      at(H[0][k], first) = (K11 + K22) + (K12 + K21) + on;
      at(H[1][k], first) = off - (K11 + K21);
      at(H[2][k], first) = off - (K12 + K22);
      at(H[3][k], first) = K11 + on;
      at(H[4][k], first) = K12 + off;
      at(H[5][k], first) = K22 + on;
    }
  }
}

void face_lanes(const FaceConstants& constants, FaceBatch& batch, int first) {
  const Vector area = 0.5 * at(batch.double_area, first), mass = constants.density * area;
  Vector X[3][2];
  Axes<Vector> x[3], w[3];
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 2; ++axis) X[i][axis] = at(batch.X[i][axis], first);
    x[i] = axes(batch.x[i], first);
  }
  // Differences with respect to corner 0: a translation of the world then drops out before the division by the area.
  const Vector doubled = at(batch.double_area, first);
  const Vector g1[2] = {(X[2][1] - X[0][1]) / doubled, (X[0][0] - X[2][0]) / doubled};
  const Vector g2[2] = {(X[0][1] - X[1][1]) / doubled, (X[1][0] - X[0][0]) / doubled};
  const Axes<Vector> to_1 = x[1] - x[0], to_2 = x[2] - x[0];
  Axes<Vector> F[2];
  for (int axis = 0; axis < 2; ++axis) {
    F[axis] = g1[axis] * to_1 + g2[axis] * to_2;
    put(batch.F[axis], first, F[axis]);
  }
  for (int i = 0; i < 3; ++i)
    w[i] = axes(batch.v[i], first) - at(batch.V[i][0], first) * F[0] - at(batch.V[i][1], first) * F[1];
  MembraneTerms<Vector> membrane = membrane_terms(constants.moduli, area, singular_values(F[0], F[1]), g1, g2);
  at(batch.mass, first) = mass;
  at(batch.membrane, first) = area * membrane.density;
  put_matrix(constants, membrane, mass, first, batch.H);
  add_motion(constants, batch, first, mass, x, w, membrane.force);
  for (int i = 0; i < 3; ++i) put(batch.force[i], first, membrane.force[i]);
}

void faces(const FaceConstants& constants, FaceBatch& batch) {
  for (int first = 0; first < batch_lanes; first += CREASE_LANES) face_lanes(constants, batch, first);
}

void hinge_lanes(double scaled_bending, double stiffness_scale, HingeBatch& batch, int first) {
  Vector X[4][2];
  for (int i = 0; i < 4; ++i)
    for (int axis = 0; axis < 2; ++axis) X[i][axis] = at(batch.X[i][axis], first);
  const HingeTerms<Vector> hinge = hinge_terms(scaled_bending, X[0], X[1], X[2], X[3]);
  Axes<Vector> curvature = hinge.k[0] * axes(batch.x[0], first);
  for (int i = 1; i < 4; ++i) curvature = curvature + hinge.k[i] * axes(batch.x[i], first);
  at(batch.energy, first) = 0.5 * hinge.c * dot(curvature, curvature);
  int pair = 0;
  for (int j = 0; j < 4; ++j) {
    put(batch.force[j], first, (-hinge.c * hinge.k[j]) * curvature);
    for (int i = 0; i <= j; ++i)
      at(batch.weight[pair++], first) = (stiffness_scale * hinge.c) * (hinge.k[i] * hinge.k[j]);
  }
}

void hinges(double scaled_bending, double stiffness_scale, HingeBatch& batch) {
  for (int first = 0; first < batch_lanes; first += CREASE_LANES)
    hinge_lanes(scaled_bending, stiffness_scale, batch, first);
}

constexpr ElementKernels kernels{faces, hinges};

}  // namespace
}  // namespace crease
