#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Pictures of a run, without a display: reads DIR/frames/*.vtp and DIR/obstacles.json, writes PNG files.

  tools/render.py DIR                                  every frame, DIR/png/000000.png ...
  tools/render.py DIR --strip 6                        six frames of the run in one picture, DIR/png/strip.png
  tools/render.py DIR --times 0.5,1.0 --view 15,-70    the frames nearest to these times, from elevation, azimuth
  tools/render.py DIR --zoom 0.2,0.5,0,1,-0.2,0.1      only what lies around this box (x, y, z from-to)
  tools/render.py DIR --section y=0.5                  a cut through cloth and obstacles: the bend at an edge
  tools/render.py DIR --mesh material                  the mesh in material space, EOL vertices marked
  tools/render.py DIR --color strain                   largest stretch instead of front (blue) and back (sand)

Orthographic, true hidden surfaces (depth buffer). Obstacles are translucent: what shows through is behind their surface.
EOL vertices are red dots, edges between two of them red lines; faint where hidden.
"""
import argparse
import json
import re
import sys
from pathlib import Path

import numpy as np
import matplotlib

matplotlib.use("Agg")
from matplotlib import cm  # noqa: E402
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402

SAMPLES = 2  # pixels are drawn this many times finer each way, then averaged
DPI = 100
FRONT, BACK = np.array([0.36, 0.55, 0.80]), np.array([0.87, 0.74, 0.50])
OBSTACLE, OBSTACLE_ALPHA = np.array([0.45, 0.47, 0.50]), 0.45
FEATURE, EOL = np.array([0.10, 0.10, 0.12]), np.array([0.85, 0.05, 0.10])
TYPES = {"Float64": "<f8", "Float32": "<f4", "Int64": "<i8", "Int32": "<i4", "UInt8": "u1", "Int8": "i1"}


# -- reading -------------------------------------------------------------------------------------------------------------
class Frame:
    """Points x, material coordinates X, triangles, eol flags and time of one .vtp file with raw appended arrays."""

    def __init__(self, path):
        raw = path.read_bytes()
        start = raw.index(b'<AppendedData encoding="raw">')
        head = raw[:start].decode()
        data = raw.index(b"_", start) + 1
        arrays = {}
        for tag in re.findall(r"<DataArray [^>]*offset=\"\d+\"[^>]*>", head):
            attribute = dict(re.findall(r'(\w+)="([^"]*)"', tag))
            at = data + int(attribute["offset"])
            size = int(np.frombuffer(raw, "<u8", 1, at)[0])
            kind = np.dtype(TYPES[attribute["type"]])
            values = np.frombuffer(raw, kind, size // kind.itemsize, at + 8)
            columns = int(attribute.get("NumberOfComponents", 1))
            arrays[attribute["Name"]] = values.reshape(-1, columns) if columns > 1 else values
        self.number = int(path.stem)
        self.time = float(re.search(r'Name="TimeValue"[^>]*>\s*([^<]+)<', head).group(1))
        self.x, self.X = arrays["Points"], arrays["uv"]
        self.triangles = arrays["connectivity"].reshape(-1, 3)
        self.eol = arrays["eol"].astype(bool)
        self.velocity = arrays["velocity"]

    def eol_edges(self):
        edges = np.sort(self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges = edges[self.eol[edges].all(axis=1)]
        return np.unique(edges, axis=0) if len(edges) else edges

    def strain(self):
        """Largest singular value of F, less one, of each triangle."""
        x, X = self.x[self.triangles], self.X[self.triangles]
        DX = np.stack([X[:, 1] - X[:, 0], X[:, 2] - X[:, 0]], axis=2)
        Dx = np.stack([x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]], axis=2)
        return np.linalg.svd(Dx @ np.linalg.inv(DX), compute_uv=False)[:, 0] - 1


class Obstacle:
    def __init__(self, entry):
        self.vertices = np.array(entry["vertices"], float).reshape(-1, 3)
        self.triangles = np.array(entry["triangles"], int).reshape(-1, 3)
        self.edges = np.array(entry["sharp_edges"], float).reshape(-1, 2, 3)
        self.corners = np.array(entry["sharp_corners"], float).reshape(-1, 3)
        self.poses = entry["poses"]

    def at(self, frame):
        """Function from local to world coordinates at a frame."""
        pose = self.poses[min(frame, len(self.poses) - 1)]
        R, p = np.array(pose["rotation"]), np.array(pose["position"])
        return lambda points: points @ R.T + p


def read_obstacles(run):
    path = run / "obstacles.json"
    return [Obstacle(entry) for entry in json.loads(path.read_text())["obstacles"]] if path.exists() else []


def chosen_frames(run, options):
    files = sorted((run / "frames").glob("[0-9]*.vtp"))
    if not files:
        sys.exit(f"{run}: no frames/*.vtp")
    if options.times:
        times = np.array([Frame(file).time for file in files])
        files = [files[int(np.abs(times - t).argmin())] for t in numbers(options.times)]
    elif options.frames:
        parts = [int(p) if p else None for p in options.frames.split(":")]
        files = files[slice(*parts)] if len(parts) > 1 else [files[parts[0]]]
    if options.strip and len(files) > options.strip:
        files = [files[round(i)] for i in np.linspace(0, len(files) - 1, options.strip)]
    return [Frame(file) for file in files]


def numbers(text):
    return [float(part) for part in text.split(",")]


# -- drawing in space ----------------------------------------------------------------------------------------------------
class Layer:
    """Colours and depths of one kind of thing; greater depth is nearer."""

    def __init__(self, width, height):
        self.depth = np.full((height, width), -np.inf)
        self.rgb = np.ones((height, width, 3))

    def triangle(self, p, z, rgb, line):
        """p: 3x2 pixel coordinates, z: depths; `line` is the half width of its outline in pixels (0: none)."""
        height, width = self.depth.shape
        x0, y0 = np.maximum(np.floor(p.min(axis=0)).astype(int), 0)
        x1, y1 = np.minimum(np.ceil(p.max(axis=0)).astype(int) + 1, [width, height])
        area = (p[1, 0] - p[0, 0]) * (p[2, 1] - p[0, 1]) - (p[1, 1] - p[0, 1]) * (p[2, 0] - p[0, 0])
        if x0 >= x1 or y0 >= y1 or abs(area) < 1e-9:
            return
        xs, ys = np.arange(x0, x1) + 0.5, (np.arange(y0, y1) + 0.5)[:, None]
        weights = []
        for a, b in ((p[1], p[2]), (p[2], p[0]), (p[0], p[1])):
            weights.append(((b[0] - a[0]) * (ys - a[1]) - (b[1] - a[1]) * (xs - a[0])) / area)
        depth = weights[0] * z[0] + weights[1] * z[1] + weights[2] * z[2]
        seen = (np.minimum(np.minimum(weights[0], weights[1]), weights[2]) >= -1e-9) & (depth > self.depth[y0:y1, x0:x1])
        if not seen.any():
            return
        self.depth[y0:y1, x0:x1][seen] = depth[seen]
        if line:
            sides = np.linalg.norm(p[[2, 0, 1]] - p[[1, 2, 0]], axis=1)
            heights = abs(area) / np.maximum(sides, 1e-9)
            rim = np.minimum(np.minimum(weights[0] * heights[0], weights[1] * heights[1]), weights[2] * heights[2]) < line
            self.rgb[y0:y1, x0:x1][seen & rim] = 0.55 * rgb
            seen &= ~rim
        self.rgb[y0:y1, x0:x1][seen] = rgb


class View:
    """Orthographic camera that fits a box of the world into a picture."""

    def __init__(self, elevation, azimuth, box, size):
        e, a = np.radians([elevation, azimuth])
        self.towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        self.right = np.array([-np.sin(a), np.cos(a), 0])
        self.up = np.cross(self.towards, self.right)
        self.size = np.array(size) * SAMPLES
        corners = np.array([[box[0][i], box[1][j], box[2][k]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        flat = np.stack([corners @ self.right, corners @ self.up], axis=1)
        extent = np.maximum(flat.max(axis=0) - flat.min(axis=0), 1e-9)
        self.scale = (self.size / extent).min() * 0.94
        self.centre = (flat.max(axis=0) + flat.min(axis=0)) / 2

    def project(self, points):
        flat = np.stack([points @ self.right, points @ self.up], axis=-1)
        pixels = (flat - self.centre) * self.scale * [1, -1] + self.size / 2
        return pixels, points @ self.towards


def shade(x, towards):
    """Light of each triangle, from above the left shoulder, and whether its front shows."""
    normals = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    light = towards + [0, 0, 0.8] + 0.5 * np.cross(towards, [0, 0, 1])
    return 0.5 + 0.5 * np.abs(normals @ (light / np.linalg.norm(light))), normals @ towards > 0


def stamp(picture, depth, points, depths, radius, rgb, bias, hidden):
    """Dots at pixel coordinates; opacity `hidden` where something nearer than their depth + bias is in front."""
    height, width = depth.shape
    r = int(np.ceil(radius))
    for (px, py), z in zip(points, depths):
        x0, x1, y0, y1 = max(int(px) - r, 0), min(int(px) + r + 1, width), max(int(py) - r, 0), min(int(py) + r + 1, height)
        if x0 >= x1 or y0 >= y1:
            continue
        inside = (np.arange(x0, x1) + 0.5 - px) ** 2 + (np.arange(y0, y1)[:, None] + 0.5 - py) ** 2 <= radius**2
        alpha = inside * np.where(depth[y0:y1, x0:x1] > z + bias, hidden, 1.0)
        part = picture[y0:y1, x0:x1]
        part += alpha[..., None] * (rgb - part)


def draw_lines(picture, depth, view, segments, radius, rgb, bias, hidden):
    """World segments as chains of dots. Hidden parts first share one mask, so that overlapping dots do not add up."""
    height, width = depth.shape
    best = np.zeros((height, width))
    for segment in segments:
        ends, z = view.project(np.asarray(segment))
        count = int(np.clip(np.abs(ends[1] - ends[0]).max() * 1.5, 2, 20000))
        t = np.linspace(0, 1, count)[:, None]
        at = ends[0] + t * (ends[1] - ends[0])
        zs = (z[0] + t * (z[1] - z[0]))[:, 0]
        r = int(np.ceil(radius))
        for dy in range(-r, r + 1):
            for dx in range(-r, r + 1):
                if dx * dx + dy * dy > radius * radius:
                    continue
                ix, iy = np.floor(at[:, 0] + dx).astype(int), np.floor(at[:, 1] + dy).astype(int)
                ok = (ix >= 0) & (ix < width) & (iy >= 0) & (iy < height)
                ix, iy = ix[ok], iy[ok]
                alpha = np.where(depth[iy, ix] > zs[ok] + bias, hidden, 1.0)
                np.maximum.at(best, (iy, ix), alpha)
    picture += best[..., None] * (rgb - picture)


def face_colours(frame, towards, mode, limits):
    light, front = shade(frame.x[frame.triangles], towards)
    if mode == "side":
        base = np.where(front[:, None], FRONT, BACK)
    else:
        base = cm.viridis(np.clip((face_values(frame, mode) - limits[0]) / max(limits[1] - limits[0], 1e-12), 0, 1))[:, :3]
    return base * light[:, None]


def face_values(frame, mode):
    if mode == "strain":
        return frame.strain()
    return np.linalg.norm(frame.velocity[frame.triangles].mean(axis=1), axis=1)


def draw_world(frame, obstacles, view, options, limits):
    width, height = view.size
    cloth, solid = Layer(width, height), Layer(width, height)
    pixels, depths = view.project(frame.x)
    colours = face_colours(frame, view.towards, options.color, limits)
    line = 0.0 if options.no_lines else 0.35 * SAMPLES
    for f, triangle in enumerate(frame.triangles):
        cloth.triangle(pixels[triangle], depths[triangle], colours[f], line)
    edges, corners = [], []
    for obstacle in obstacles:
        world = obstacle.at(frame.number)
        if len(obstacle.triangles):
            x = world(obstacle.vertices)
            light, _ = shade(x[obstacle.triangles], view.towards)
            p, z = view.project(x)
            for f, triangle in enumerate(obstacle.triangles):
                solid.triangle(p[triangle], z[triangle], OBSTACLE * (0.3 + 0.9 * light[f]), 0)
        edges += [world(edge) for edge in obstacle.edges]
        corners += [world(corner) for corner in (obstacle.corners if not len(obstacle.triangles) else [])]
    picture = cloth.rgb
    # Cloth at rest on a surface is on it to round-off: it must be behind by a fine pixel's worth to count as hidden.
    has_solid, solid_first = np.isfinite(solid.depth), solid.depth > cloth.depth + 1.0 / view.scale
    opacity = np.where(np.isfinite(cloth.depth), OBSTACLE_ALPHA, 0.8) * (has_solid & solid_first)
    picture += opacity[..., None] * (solid.rgb - picture)
    nearest = np.maximum(cloth.depth, solid.depth)
    bias = 3.0 / view.scale  # three fine pixels' worth of depth
    draw_lines(picture, nearest, view, edges, 0.9 * SAMPLES, FEATURE, bias, 0.25)
    draw_lines(picture, nearest, view, frame.x[frame.eol_edges()], 0.7 * SAMPLES, EOL, bias, 0.3)
    if corners:
        stamp(picture, nearest, *view.project(np.array(corners)), 3.5 * SAMPLES, FEATURE, bias, 0.3)
    if frame.eol.any():
        p, z = pixels[frame.eol], depths[frame.eol]
        stamp(picture, nearest, p, z, options.dot * SAMPLES, EOL, bias, 0.3)
    return picture.reshape(height // SAMPLES, SAMPLES, width // SAMPLES, SAMPLES, 3).mean(axis=(1, 3))


# -- drawing in the plane ------------------------------------------------------------------------------------------------
def cut(x, triangles, axis, value):
    """Segments in which a plane meets triangles."""
    d = x[:, axis] - value
    d = np.where(d == 0, 1e-12, d)
    segments = []
    for triangle in triangles[(d[triangles].max(axis=1) > 0) & (d[triangles].min(axis=1) < 0)]:
        ends = [x[a] + d[a] / (d[a] - d[b]) * (x[b] - x[a]) for a, b in zip(triangle, np.roll(triangle, -1)) if d[a] * d[b] < 0]
        segments.append(ends)
    return np.array(segments).reshape(-1, 2, 3)


def draw_section(axes, frame, obstacles, axis, value, box):
    across, up = [i for i in range(3) if i != axis]
    for obstacle in obstacles:
        world = obstacle.at(frame.number)
        if len(obstacle.triangles):
            lines = cut(world(obstacle.vertices), obstacle.triangles, axis, value)[:, :, [across, up]]
            axes.add_collection(LineCollection(lines, colors="0.45", linewidths=1.5))
        for edge in obstacle.edges:
            ends = world(edge)
            if (ends[0, axis] - value) * (ends[1, axis] - value) < 0:
                t = (value - ends[0, axis]) / (ends[1, axis] - ends[0, axis])
                axes.plot(*(ends[0] + t * (ends[1] - ends[0]))[[across, up]], "ks", markersize=4)
    lines = cut(frame.x, frame.triangles, axis, value)[:, :, [across, up]]
    axes.add_collection(LineCollection(lines, colors=[FRONT * 0.8], linewidths=1.2))
    axes.plot(*lines.reshape(-1, 2).T, ".", color=FRONT * 0.6, markersize=2.5)
    edges = frame.x[frame.eol_edges()]
    for a, b in edges[(edges[:, 0, axis] - value) * (edges[:, 1, axis] - value) <= 0] if len(edges) else []:
        t = (value - a[axis]) / (b[axis] - a[axis]) if b[axis] != a[axis] else 0
        axes.plot(*(a + t * (b - a))[[across, up]], "o", color=EOL, markersize=4)
    axes.set_xlim(*box[across])
    axes.set_ylim(*box[up])
    axes.set_aspect("equal", adjustable="datalim")


def draw_material(axes, frame):
    axes.triplot(*frame.X.T, frame.triangles, color="0.35", linewidth=0.4)
    axes.add_collection(LineCollection(frame.X[frame.eol_edges()], colors=[EOL], linewidths=1.2))
    axes.plot(*frame.X[frame.eol].T, "o", color=EOL, markersize=3)
    axes.set_aspect("equal")


# -- pictures ------------------------------------------------------------------------------------------------------------
def caption(frame):
    return f"t = {frame.time:.3f} s   {len(frame.triangles)} faces   {frame.eol.sum()} EOL   frame {frame.number}"


def world_box(frames, options):
    if options.zoom:
        return np.array(numbers(options.zoom)).reshape(3, 2)
    low = np.min([frame.x.min(axis=0) for frame in frames], axis=0)
    high = np.max([frame.x.max(axis=0) for frame in frames], axis=0)
    pad = 0.04 * (high - low).max()
    return np.stack([low - pad, high + pad], axis=1)


def colour_limits(frames, mode):
    if mode == "side":
        return 0, 1
    values = [face_values(frame, mode) for frame in frames]
    return min(v.min() for v in values), max(v.max() for v in values)


def compose(frames, obstacles, options, box, limits):
    """One picture with a tile a frame."""
    width, height = options.size
    columns = min(len(frames), options.columns or int(np.ceil(np.sqrt(len(frames)))))
    rows = -(-len(frames) // columns)
    figure = Figure(figsize=(columns * width / DPI, rows * height / DPI), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    for i, frame in enumerate(frames):
        left, bottom = (i % columns) / columns, 1 - (i // columns + 1) / rows
        if options.section or options.mesh == "material":
            axes = figure.add_axes([left + 0.09 / columns, bottom + 0.08 / rows, 0.88 / columns, 0.84 / rows])
            axes.tick_params(labelsize=7)
            if options.section:
                axis, value = options.section
                draw_section(axes, frame, obstacles, axis, value, box)
            else:
                draw_material(axes, frame)
        else:
            view = View(*options.view, box, options.size)
            axes = figure.add_axes([left, bottom, 1 / columns, 1 / rows])
            axes.imshow(draw_world(frame, obstacles, view, options, limits), interpolation="nearest", aspect="auto")
            axes.axis("off")
        figure.text(left + 0.01 / columns, bottom + 0.985 / rows, caption(frame), fontsize=8, va="top")
    if options.color != "side":
        figure.text(0.01, 0.01, f"{options.color} {limits[0]:.3g} (violet) to {limits[1]:.3g} (yellow)", fontsize=8)
    return figure


def parse_section(text, frames):
    name, _, value = text.partition("=")
    axis = "xyz".find(name) if len(name) == 1 else -1
    if axis < 0:
        sys.exit("--section: expected x, y or z, or for example y=0.5")
    return axis, float(value) if value else float(np.mean([frame.x[:, axis].mean() for frame in frames]))


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, metavar="DIR")
    parser.add_argument("-o", "--output", type=Path, help="directory of the pictures (DIR/png)")
    parser.add_argument("--frames", help="number, or from:to:step as in Python")
    parser.add_argument("--times", help="comma-separated [s]")
    parser.add_argument("--strip", type=int, metavar="N", help="N frames, evenly over the chosen ones, in one picture")
    parser.add_argument("--columns", type=int, help="of the strip")
    parser.add_argument("--view", type=numbers, default=[25.0, -60.0], metavar="ELEV,AZIM", help="degrees (25,-60)")
    parser.add_argument("--zoom", metavar="X0,X1,Y0,Y1,Z0,Z1", help="world box to fit into the picture")
    parser.add_argument("--mesh", choices=["world", "material"], default="world")
    parser.add_argument("--section", nargs="?", const="y", metavar="AXIS[=VALUE]", help="cut across an axis (y, in the middle)")
    parser.add_argument("--color", choices=["side", "strain", "speed"], default="side")
    parser.add_argument("--size", type=lambda text: [int(v) for v in text.split("x")], default=[800, 600], metavar="WxH")
    parser.add_argument("--dot", type=float, default=2.2, help="radius of an EOL vertex, pixels (2.2)")
    parser.add_argument("--no-lines", action="store_true", help="leave the mesh lines out")
    return parser.parse_args([a if not re.match(r"-[\d.]+,", a) else " " + a for a in sys.argv[1:]])


def main():
    options = parse_options()
    frames = chosen_frames(options.run, options)
    obstacles = read_obstacles(options.run)
    output = options.output or options.run / "png"
    output.mkdir(parents=True, exist_ok=True)
    if options.section:
        options.section = parse_section(options.section, frames)
    box, limits = world_box(frames, options), colour_limits(frames, options.color)
    groups = {"strip": frames} if options.strip else {f"{frame.number:06d}": [frame] for frame in frames}
    for name, group in groups.items():
        compose(group, obstacles, options, box, limits).savefig(output / f"{name}.png")
    print(output / f"{next(reversed(groups))}.png")


if __name__ == "__main__":
    main()
