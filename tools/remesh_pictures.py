#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""The pictures of docs/remeshing.md: meshes in material space, from runs of shipped scenes.

  tools/remesh_pictures.py CREASE      runs the program CREASE, writes docs/images/remeshing.png

Of the scene edge at 500 faces: before and after the first contact, and where the fold comes near the border. Of the scene
push: the corner of a box. Chains of EOL vertices are red.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

sys.path.insert(0, str(Path(__file__).resolve().parent))
from render import Frame, draw_material  # noqa: E402

HOME = Path(__file__).resolve().parent.parent
COARSE = ["cloths.0.shape.grid.cells=[11,11]", "cloths.0.remeshing.size=[0.05,0.12]"]
# title, scene, changes, time [s], part of the material shown
PANELS = [
    ("before the first contact", "edge", COARSE, 0.084, (0, 1, 0, 1)),
    ("after it", "edge", COARSE, 0.120, (0, 1, 0, 1)),
    ("the fold has gone over 11 cm", "edge", COARSE, 1.500, (0, 1, 0, 1)),
    ("near the border", "edge", COARSE, 3.150, (0, 0.4, 0.6, 1)),
    ("beside the fold, at 2400 faces", "edge", [], 1.000, (0.1, 0.5, 0.6, 1)),
    ("a corner of a box", "push", [], 0.400, (0.15, 0.45, 0.15, 0.45)),
]


def run(crease, scene, changes, until, directory):
    """The frames of a run, made once."""
    if not directory.exists():
        settings = [part for change in changes for part in ("--set", change)]
        subprocess.run([crease, "run", str(HOME / "scenes" / f"{scene}.json"), "-o", str(directory), "--quiet",
                        "--until", str(until), *settings], check=True)
    return [Frame(file) for file in sorted((directory / "frames").glob("[0-9]*.vtp"))]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    figure = Figure(figsize=(13, 9), dpi=100)
    FigureCanvasAgg(figure)
    with tempfile.TemporaryDirectory() as scratch:
        for k, (title, scene, changes, time, (u0, u1, v0, v1)) in enumerate(PANELS):
            until = max(p[3] for p in PANELS if p[1:3] == (scene, changes)) + 0.02
            frames = run(sys.argv[1], scene, changes, until, Path(scratch) / f"{scene}{len(changes)}")
            frame = min(frames, key=lambda f: abs(f.time - time))
            axes = figure.add_subplot(2, 3, k + 1)
            draw_material(axes, frame)
            axes.set_xlim(u0, u1)
            axes.set_ylim(v0, v1)
            axes.set_title(f"{title}: {scene}, t = {frame.time:.3f} s, {len(frame.triangles)} faces", fontsize=9)
            axes.tick_params(labelsize=7)
    figure.tight_layout()
    figure.savefig(HOME / "docs" / "images" / "remeshing.png")


if __name__ == "__main__":
    main()
