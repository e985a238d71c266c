// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "crease/geometry/cloth.hpp"
#include "guard.hpp"
#include "metric.hpp"
#include "slide.hpp"

// Edges come out too short where no collapse can help: it would make others too long. There a vertex that slides along
// the surface evens the lengths out. Only such vertices slide, and only where the surface is flat: a vertex that goes
// the distance d where facets meet at the angle a moves the surface by up to d sin a.
namespace crease {

/// The metric length that an edge should have at least.
inline constexpr double short_below = 0.5;
/// Squared, and by rounding less: the half of an edge of length 1 is long enough.
inline constexpr double squared_short = short_below * short_below * (1 - 1e-9);

/// Whether a vertex may slide at all: nothing holds it, and, if it is on the border, that is straight there.
bool is_free_to_slide(const Cloth& cloth, int vertex);

/// Whether the faces round a vertex are one plane piece, evenly stretched, to within the tolerance [m]: then no slide
/// among them moves the surface by much more, and on a curved sheet that is soon found out.
bool is_flat(const Cloth& cloth, int vertex, double tolerance);

/// The place where the worst of its edges fits best, min(L / short_below, 1 / L) over all edges being the fit; nothing
/// where the fit is `enough` as it is, or can neither become that nor rise by a twentieth.
/// @pre is_free_to_slide
std::optional<Slide> slide_to_even_lengths(const Cloth& cloth, int vertex, std::span<const Tensor> sizes, double enough,
                                           const GuardLimits& limits);

}  // namespace crease
