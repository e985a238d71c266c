#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Runs the shipped scenes and writes docs/scenes.md: one row a scene, with a picture.

  tools/scenes.py                    every scene, runs in out/scenes
  tools/scenes.py --only edge,wire   these; the other rows stay as they are on the page
  tools/scenes.py --no-run           rows and pictures from the runs that are there; also with --only
"""
import argparse
import csv
import json
import pathlib
import re
import resource
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import sliding  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "scenes.md"
IMAGES = ROOT / "docs" / "images" / "scenes"

# Largest number of faces, largest share of EOL vertices [%], ms a step: Weidner et al. 2018, Table 1 (one core of an
# i7-7700, a commercial QP solver).
PAPER = {
    "edge_regular": (2116, None, 436.2), "edge_irregular": (2000, None, 589.2), "edge_adaptive": (2521, None, 638.9),
    "edge_conformal": (2622, None, 729.6), "edge": (2971, 2.4, 1101.0), "wire_regular": (1936, None, 827.2),
    "wire_irregular": (2055, None, 896.5), "wire_adaptive": (2048, None, 1028.7),
    "wire_conformal": (2022, None, 728.3), "wire": (2048, 2.4, 1058.7), "nails": (2012, 1.9, 804.2),
    "jaws": (3380, 0.3, 503.9), "push": (2110, 3.1, 454.9), "throw": (1913, 3.9, 568.4),
    "lo_res_regular": (256, None, 18.1), "lo_res": (133, 6.0, 16.3),
}  # fmt: skip

# What one sees in the frames, each looked at.
SEEN = {
    "drape_corner": "The sheet bends sharply at both edges and in their corner, the cone between them falls in one fold, and rests.",
    "edge": "A dead-sharp bend on the edge from end to end; the overhang shortens at the pull speed until the border is over.",
    "edge_regular": "Mesh lines do not lie on the edge: the sheet cuts it, and rises behind it as it is pulled.",
    "edge_irregular": "As edge_regular, with a crumpled bend.",
    "edge_adaptive": "Finer, and still lifted off the edge when pulled.",
    "edge_conformal": "Sharp at rest; pulled, the averaged normal lifts it off.",
    "edge_conformal_cone": "Sharp, and locked: the overhang stays, the sheet is drawn into wrinkles between edge and hands.",
    "wire": "Folds to 180 degrees on the wire and slides freely to both sides.",
    "wire_regular": "Folds along a mesh line, until that row of vertices passes the wire: the sheet falls off it.",
    "wire_irregular": "Rounds the wire, for want of a sharp bend, and does not slide: it bulges.",
    "wire_conformal": "A row of vertices on the wire passes it with the first sliding: the sheet falls off.",
    "wire_adaptive": "As wire_regular, sooner.",
    "nails": "Sixteen tents; the sheet is drawn over them without a snag, and swings free.",
    "jaws": "Three tents up and two down, then the sheet is drawn out between them.",
    "push": "A table with sharp edges and corners travels under the sheet; it lifts off when the box drops.",
    "throw": "Thrown up, in flight, and caught again by the edges and corners of the box.",
    "prism": "A sharp bend at each of the ridges of 20 to 150 degrees, none on the smooth ones.",
    "tablecloth": "Drapes over edges and corners, is pulled off by one side and swings free.",
    "lo_res": "The same bend with a nineteenth of the faces.",
    "lo_res_regular": "The bend is lost between the mesh lines.",
}  # fmt: skip

HEAD = """# Scenes

Every scene that ships, run to its end; made by `tools/scenes.py`. Faces and share of EOL vertices: the largest of the
run. The paper's: Table 1 of Weidner et al. 2018 [WEIDNER18] (i7-7700, a commercial QP solver). Deepest: of the cloth in
an obstacle, on a lattice inside the triangles too, as a share of the cloth's longer side. Inserted, released: EOL
vertices begun and let go in the run. Retried: parts of steps that were taken again, shorter. Gained: the most kinetic
energy that remeshing added in a step, as a share of what there was. Times are processor times of whole runs, output and
all, on a virtual core.

Over edge or wire: how high the sheet lifts off within 5 cm behind the edge while it is pulled (.8 to 2.4 s), and how much
of what is pulled comes over it; when the sheet falls off the wire, or else how wide its fold is 2 cm below while taut, how
far from the wire it is there, and how much of the way of the borders, one up and one down, it slides over.

| scene | ended | faces | EOL % | paper: faces, EOL % | ms a step | paper | solve, remesh, assemble % | deepest % | inserted | released | retried | gained | over edge or wire |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|
"""


def longest_side(scene):
    grid = scene["cloths"][0]["shape"].get("grid")
    return max(grid["size"]) if grid else 1.0


def run(program, name, directory):
    """Runs a scene and notes the processor time that it took, which other programs at work do not change much."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(program), "run", name, "-o", str(directory), "--force", "--quiet"])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    (directory / "processor_seconds").write_text(f"{seconds}\n")


def measure(run):
    summary = json.loads((run / "summary.json").read_text())
    scene = json.loads((run / "scene.json").read_text())
    with open(run / "steps.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    column = lambda name: [float(row[name]) for row in rows]
    shares = [100 * e / v for e, v in zip(column("eol_vertices"), column("vertices"))]
    worst = summary.get("worst_penetration") or {"value": 0}
    return {
        "ended": "yes" if summary["finished"] else summary["why"],
        "faces": int(max(column("faces"))),
        "eol": max(shares),
        "ms": 1e3 * float((run / "processor_seconds").read_text()) / len(rows),
        "shares": [100 * summary["stages"].get(key, {"share": 0})["share"] for key in ("solve", "remesh", "assemble")],
        "deepest": 100 * (worst["value"] or 0) / longest_side(scene),
        "inserted": int(sum(column("inserted"))),
        "released": int(sum(column("released"))),
        "retries": summary["retries"],
        "gained": max((after - before) / max(before, 1e-9) for before, after in
                      zip(column("kinetic_energy_before_remesh"), column("kinetic_energy_after_remesh"))),
        "over": over_edge_or_wire(run, scene["name"]) if summary["finished"] else "-",
    }


def over_edge_or_wire(run, name):
    if is_over_edge(name):
        went = sliding.over_edge(run)
        return f"lifts {1e3 * went['lifted']:.1f} mm, slides {went['slid']:.2f}"
    if not name.startswith("wire"):
        return "-"
    went = sliding.over_wire(run)
    if went["left"] is not None:
        return f"falls off at {went['left']:.2f} s"
    return f"{1e3 * went['width']:.0f} mm wide, {1e3 * went['gap']:.0f} mm off, slides {went['slid']:.2f}"


def row(name, m):
    faces, eol, ms = PAPER.get(name, (None, None, None))
    shown = lambda value: "-" if value is None else f"{value:g}"
    return (f"| {name} | {m['ended']} | {m['faces']} | {m['eol']:.1f} | {shown(faces)}, {shown(eol)} | {m['ms']:.0f} | "
            f"{shown(ms)} | {', '.join(f'{share:.0f}' for share in m['shares'])} | {m['deepest']:.3f} | "
            f"{m['inserted']} | {m['released']} | {m['retries']} | {m['gained']:.0e} | {m['over']} |\n")  # fmt: skip


def description(name):
    """Of the scene's file, which may have comments."""
    return re.search(r'"description": "(.*)"', (ROOT / "scenes" / f"{name}.json").read_text())[1]


def rows_on_page():
    """The rows that the page has, by scene."""
    lines = PAGE.read_text().splitlines(keepends=True) if PAGE.exists() else []
    return {match[1]: line for line in lines if (match := re.match(r"\| (\w+) \| (?!ended)", line))}


def is_over_edge(name):
    return name.startswith(("edge", "lo_res"))


def render(run, image, *options):
    IMAGES.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, str(ROOT / "tools" / "render.py"), str(run), *options, "--strip", "4", "--columns", "4"]
    subprocess.run([*command, "-o", str(run / "png")], check=True, stdout=subprocess.DEVNULL)
    shutil.copyfile(run / "png" / "strip.png", IMAGES / image)


def picture(run, name):
    render(run, f"{name}.png", "--size", "320x260")
    if is_over_edge(name):
        beside_edge = ["--section", "y=0.5", "--zoom", "0.27,0.42,0,1,-0.1,-0.02", "--times", "0.3,1.2,2.1,3.0"]
        render(run, f"{name}_section.png", *beside_edge, "--size", "320x200")


def section(name):
    images = [f"![{name}](images/scenes/{name}.png)"]
    if is_over_edge(name):
        images.append(f"Cut at the middle, beside the edge:\n\n![{name}, cut](images/scenes/{name}_section.png)")
    return "\n\n".join([f"\n## {name}", f"{description(name)}. {SEEN.get(name, '')}".rstrip(), *images]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "scenes")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "crease")
    parser.add_argument("--only", default="")
    parser.add_argument("--no-run", action="store_true")
    options = parser.parse_args()
    names = sorted(path.stem for path in (ROOT / "scenes").glob("*.json"))
    chosen = options.only.split(",") if options.only else names
    for name in [] if options.no_run else chosen:
        print(name, flush=True)
        run(options.program, name, options.out / name)
    rows = rows_on_page()
    for name in (name for name in chosen if (options.out / name / "summary.json").exists()):
        rows[name] = row(name, measure(options.out / name))
        picture(options.out / name, name)
    page = HEAD + "".join(rows.get(name, f"| {name} | not run |\n") for name in names)
    PAGE.write_text(page + "".join(section(name) for name in names))


if __name__ == "__main__":
    main()
