# SPDX-License-Identifier: MIT
"""How a sheet went over the edge or the wire of a run, measured on the frames it wrote: for tools/scenes.py."""
import numpy as np

from render import Frame

# The scenes' own numbers. Their edge and the top of the box that it bounds [m]; the pull starts at .35 s; from .8 to
# 2.4 s the overhang is long, so the sag between edge and hands takes little of what is pulled.
EDGE_X, EDGE_Z, PULL_SPEED, PULLED_FROM, PULLED_TO = 0.3175, -0.049, 0.1, 0.8, 2.4
BEHIND_EDGE = 0.05  # where a sheet that lifts off does so [m]
# The wire lies along x at y, rises to its height at .5 s; at .65 s the borders are below it, and the sheet is taut and
# at rest; from .7 to 1.0 s one border goes up and the other down, by this much.
WIRE_Y, WIRE_Z, WIRE_RISE, WIRE_TOP_TIME = 0.51, -0.01, 1.0, 0.5
AT_REST, SLID_FROM, SLID_TO, SEESAW = 0.65, 0.7, 1.0, 0.15
BELOW_WIRE = 0.02  # where the width of the fold is taken [m]
TOUCHED = 0.05  # the wire has come to the sheet [s]
FALLEN = 0.01  # a wire farther from the sheet than this carries it no more [m]


def frames(run):
    return map(Frame, sorted((run / "frames").glob("[0-9]*.vtp")))


def cut(frame, axis, at):
    """Material and world points where mesh edges cross the plane x[axis] = at."""
    edges = np.unique(np.sort(frame.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    height = frame.x[:, axis] - at
    a, b = edges[height[edges].prod(axis=1) < 0].T
    t = (height[a] / (height[a] - height[b]))[:, None]
    return (1 - t) * frame.X[a] + t * frame.X[b], (1 - t) * frame.x[a] + t * frame.x[b]


def nearest(frame, point):
    """Distance of a point from the sheet, and the material coordinates there."""
    a, b, c = (frame.x[frame.triangles[:, k]] for k in range(3))
    dot = lambda u, v: np.einsum("ij,ij->i", u, v)

    def on_side(start, end):
        e = end - start
        t = np.clip(dot(point - start, e) / np.maximum(dot(e, e), 1e-300), 0, 1)
        return t, ((start + t[:, None] * e - point) ** 2).sum(axis=1)

    normal = np.cross(b - a, c - a)
    square = np.maximum(dot(normal, normal), 1e-300)
    weights = np.stack([dot(np.cross(c - b, point - b), normal), dot(np.cross(a - c, point - c), normal),
                        dot(np.cross(b - a, point - a), normal)], axis=1) / square[:, None]  # fmt: skip
    best = np.where(weights.min(axis=1) >= 0, dot(point - a, normal) ** 2 / square, np.inf)
    for i, j, (start, end) in ((0, 1, (a, b)), (1, 2, (b, c)), (2, 0, (c, a))):
        t, distance2 = on_side(start, end)
        nearer = distance2 < best
        best[nearer] = distance2[nearer]
        weights[nearer] = 0
        weights[nearer, i], weights[nearer, j] = 1 - t[nearer], t[nearer]
    k = int(best.argmin())
    return float(np.sqrt(best[k])), weights[k] @ frame.X[frame.triangles[k]]


def over_edge(run):
    """How high the sheet lifts behind the edge [m], and how much of what is pulled comes over it."""
    lifted, passes = 0.0, []
    for frame in frames(run):
        if not PULLED_FROM <= frame.time <= PULLED_TO:
            continue
        for share in (0.1, 0.2, 0.4, 0.6, 0.8, 1):
            _, x = cut(frame, 0, EDGE_X + share * BEHIND_EDGE)
            lifted = max(lifted, float(x[:, 2].max()) - EDGE_Z)
        X, _ = cut(frame, 0, EDGE_X + 1e-6)
        passes.append((frame.time, float(X[:, 0].mean())))
    (first, X_first), (last, X_last) = passes[0], passes[-1]
    return {"lifted": lifted, "slid": (X_first - X_last) / (PULL_SPEED * (last - first))}


def over_wire(run):
    """When the sheet has left the wire [s; None: never]; and, unless it has: the width of the fold just below the wire
    while taut [m], the largest gap between wire and sheet then [m], and how much of the seesaw's way it goes over."""
    place = {}
    for frame in frames(run):
        wire = [0, WIRE_Y, WIRE_Z + WIRE_RISE * min(frame.time, WIRE_TOP_TIME)]
        found = [nearest(frame, np.array([x, *wire[1:]])) for x in np.linspace(0.1, 0.9, 9)]
        gaps = [distance for distance, _ in found]
        if frame.time >= TOUCHED and min(gaps) > FALLEN:
            return {"left": frame.time, "width": None, "gap": None, "slid": None}
        if "width" not in place and frame.time >= AT_REST:
            _, x = cut(frame, 2, wire[2] - BELOW_WIRE)
            place |= {"width": float(np.ptp(x[:, 1])), "gap": max(gaps)}
        for name, time in (("from", SLID_FROM), ("to", SLID_TO)):
            if name not in place and frame.time >= time - 1e-9:
                place[name] = np.median([X[1] for _, X in found])
    slid = float(abs(place["from"] - place["to"]) / SEESAW)
    return {"left": None, "width": place["width"], "gap": place["gap"], "slid": slid}
