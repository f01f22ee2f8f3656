"""The gallery: the thesis's poses and those of the survey, by all methods, as pictures and tables.

    python demo/gallery.py --out build/gallery               # gallery.png, survey.png, gallery.md
    python demo/gallery.py --out build/gallery --publish     # and small copies in docs/pictures

The thesis bends a cylinder by 180 degrees, twists a box by two full turns and turns a head by 90 degrees. The
survey is M. Botsch, O. Sorkine, On Linear Variational Surface Deformation Methods, TVCG 2008; its four poses
are read from survey.npz in the folder LISSOM_DATA, and left out where that is not there.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.append(str(ROOT / "tests" / "native"))  # shapes and figures are those of the tests

import bpy  # noqa: E402
import face as ict  # noqa: E402
import lissom  # noqa: E402
import numpy as np  # noqa: E402
import pose as bust  # noqa: E402
import scene  # noqa: E402
from figures import closed_volume, dihedral_change, edge_error, smallest_dihedral  # noqa: E402
from measured import Missing, load  # noqa: E402
from shapes import bend, ends, prism, rigid  # noqa: E402
from studio import SAMPLES, Studio, Tile, publish  # noqa: E402

SHEET = 0.005  # of the diagonal's cube: what encloses less is a sheet
OPTIONS = {"poisson": {"border": 1}}
VARIANTS = {
    "laplacian_fitted, scale=False": ("laplacian_fitted", {"scale": False}),
    "poisson, border=0": ("poisson", {"border": 0}),
    "arap, solid=True": ("arap", {"solid": True}),
    "poisson, solid=True": ("poisson", {"solid": True}),
    "arap, rotation_smoothing=0": ("arap", {"rotation_smoothing": 0.0}),
    "arap, rotation_smoothing=0.01": ("arap", {"rotation_smoothing": 0.01}),
    'rotation_invariant, interpolation="matrix", project=False': (
        "rotation_invariant",
        {"interpolation": "matrix", "project": False},
    ),
    'rotation_invariant, frames="principal"': ("rotation_invariant", {"frames": "principal"}),
}
# The moved handle goes where it went and keeps the turn that it had at rest, or turns by itself.
MOVED_ONLY = {
    f"{method}, moved only{', by itself' if by_itself else ''}": (method, by_itself)
    for method in ("poisson", "arap")
    for by_itself in (False, True)
}
PICTURED = ("arap, solid=True", "arap, moved only, by itself")
LETTERS = 1.9  # their size, against the demo's larger tiles
COLOURS = {"Held": (0.03, 0.06, 0.16), "Handle": (0.55, 0.13, 0.015)}


@dataclass
class Task:
    """A mesh, what is held and what is moved, and how it is looked at."""

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    held: np.ndarray
    moved: np.ndarray
    transform: np.ndarray
    view: np.ndarray  # (3, 3): to the picture's x (right), y (away), z (up)
    turns: tuple = (0.0, 0.0, 0.0)

    def solve(self, method, options):
        """(n, 3) posed vertices."""
        mesh = lissom.Mesh(self.vertices, self.faces)
        pose = lissom.Pose(mesh, [self.held, self.moved], method=method, **options)
        transforms = [np.eye(4), self.transform]
        if any(self.turns):
            return pose.solve(transforms, turns=[(0, 0, 0), self.turns], max_iterations=500).vertices
        return pose.solve(transforms, max_iterations=500).vertices

    def solve_moved_only(self, method, by_itself):
        """The same where the moved handle is not turned, or turns by itself."""
        centre = self.vertices[self.moved].mean(axis=0)
        shift = np.eye(4)
        shift[:3, 3] = (self.transform[:3, :3] - np.eye(3)) @ centre + self.transform[:3, 3]
        mesh = lissom.Mesh(self.vertices, self.faces)
        pose = lissom.Pose(mesh, [self.held, self.moved], method=method, **OPTIONS.get(method, {}))
        posed = pose.solve([np.eye(4), shift], by_itself=[1] if by_itself else [], max_iterations=500)
        return posed.vertices

    def figures(self, posed):
        """Error of edges, volume ratio, change of dihedral angles and the smallest of them in degrees."""
        return (
            edge_error(self.vertices, posed, self.faces),
            self.enclosed(posed) / self.enclosed(self.vertices),
            dihedral_change(self.vertices, posed, self.faces),
            smallest_dihedral(posed, self.faces),
        )

    def enclosed(self, points):
        """The volume; none where nothing is enclosed at rest, as by a sheet with waves."""
        rest = closed_volume(self.vertices, self.faces)
        none = abs(rest) < SHEET * np.linalg.norm(np.ptp(self.vertices, axis=0)) ** 3
        return np.nan if none else closed_volume(points, self.faces)

    def seen(self, points):
        return points @ self.view.T


def thesis_tasks():
    """The thesis's three poses, on meshes of more than 2,000 vertices."""
    flat = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    vertices, faces = prism(rows=100, columns=32, length=6)
    held, moved = ends(vertices, 0.1)
    yield Task("cylinder bent by 180°", vertices, faces, held, moved, bend(vertices, np.pi), flat)
    vertices, faces = prism(rows=200, columns=24, length=12, square=True)
    held, moved = ends(vertices, 0.05)
    tilted = rotated_view(rigid((1, 0, 0), 0.5), flat)
    yield Task("box twisted by two turns", vertices, faces, held, moved, np.eye(4), tilted, (4 * np.pi, 0, 0))
    face = ict.load().only("face", "head_and_neck")
    faces = triangles(face)
    groups = bust.regions(face)
    turn = rigid((0, 0, 1), -np.pi / 2)
    turn[:3, 3] = np.array(bust.SPINE) - turn[:3, :3] @ np.array(bust.SPINE)
    view = rotated_view(rigid((0, 0, 1), 0.6), np.eye(3))
    yield Task("head turned by 90°", face.neutral, faces, groups["chest"], groups["head"], turn, view)


def survey_tasks():
    """The survey's four poses."""
    archive = load("survey")
    side = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    views = {
        "plane": rotated_view(rigid((1, 0, 0), 0.35) @ rigid((0, 0, 1), 0.35), np.eye(3)),
        "cylinder": np.eye(3),
        "bar": rotated_view(rigid((1, 0, 0), 0.45), side),
        "cactus": np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
    }
    for name, view in views.items():
        status = archive[f"{name}_status"]
        yield Task(
            name,
            archive[f"{name}_vertices"].astype(float),
            archive[f"{name}_faces"].astype(np.int64),
            np.flatnonzero(status == 0),
            np.flatnonzero(status == 2),
            archive[f"{name}_transform"].astype(float),
            view,
        )


def decimals(volume):
    return "–" if np.isnan(volume) else f"{volume:.2f}"


def rotated_view(motion, view):
    return motion[:3, :3] @ view


def triangles(face):
    """(m, 3) of the face's polygons, by Blender's triangulation."""
    into = bpy.context.scene.collection
    skin = scene.material("Given", (0.44, 0.38, 0.33))
    made = scene.face_object("Triangles", face, face.neutral, skin, into, (0, 0, 0))
    found = scene.triangles(made)
    mesh = made.data
    bpy.data.objects.remove(made)
    bpy.data.meshes.remove(mesh)
    return found.astype(np.int64)


def mesh_of(task, points, made):
    """A Blender mesh in the picture's axes, handles in colours of their own."""
    mesh = bpy.data.meshes.new(task.name)
    mesh.from_pydata(task.seen(points).tolist(), [], task.faces.tolist())
    for material in (made, *(scene.material(name, colour) for name, colour in COLOURS.items())):
        mesh.materials.append(material)
    slot = np.zeros(len(points), dtype=np.int32)
    slot[task.held], slot[task.moved] = 1, 2
    slot = slot[task.faces]
    mesh.polygons.foreach_set("material_index", np.where(slot.min(1) == slot.max(1), slot[:, 0], 0))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(task.faces), dtype=bool))
    mesh.set_sharp_from_angle(angle=np.radians(50))
    return mesh


def picture(tasks, studio, made, path, aspect):
    """A row a method, a column a pose, the rest shapes first; returns {(task, method): figures}."""
    columns, found = [], {}
    for task in tasks:
        shapes = {"rest": task.vertices}
        for method in lissom.POSE_METHODS:
            shapes[method] = task.solve(method, OPTIONS.get(method, {}))
            found[task.name, method] = task.figures(shapes[method])
        variants = {name: task.solve(*variant) for name, variant in VARIANTS.items()}
        variants |= {name: task.solve_moved_only(*variant) for name, variant in MOVED_ONLY.items()}
        found |= {(task.name, name): task.figures(posed) for name, posed in variants.items()}
        shapes |= {name: variants[name] for name in PICTURED}
        columns.append(tiles(task, shapes, found, made, aspect))
    studio.sheet([list(row) for row in zip(*columns, strict=True)], path, aspect=aspect)
    return found


def tiles(task, shapes, found, made, aspect):
    """All shapes of one pose in the same frame."""
    around = np.concatenate([task.seen(shapes[name]) for name in ("rest", "arap", "poisson")])
    low, high = around.min(0), around.max(0)
    plate = 0.125 * LETTERS
    height = 1.08 * max((high[2] - low[2]) / (1 - plate), aspect * (high[0] - low[0]))
    centre = (0.5 * (low[0] + high[0]), 0.5 * (low[2] + high[2]) - 0.5 * plate * height)
    made_tiles = []
    for name, points in shapes.items():
        note = f"{len(points):,} vertices" if name == "rest" else ""
        if (task.name, name) in found:
            edges, volume, *_ = found[task.name, name]
            note = f"edges {100 * edges:.1f} %   volume {decimals(volume)}"
        label = task.name if name == "rest" else name
        made_tiles.append(Tile([mesh_of(task, points, made)], label, centre, height, note=note, text=LETTERS))
    return made_tiles


def table(tasks, found):
    """A Markdown table: a row a method, four figures a pose."""
    rows = ["| | " + " | ".join(task.name for task in tasks) + " |", "|---|" + "---|" * len(tasks)]
    for name in (*lissom.POSE_METHODS, *VARIANTS, *MOVED_ONLY):
        cells = []
        for task in tasks:
            edges, volume, change, smallest = found[task.name, name]
            cells.append(f"{100 * edges:.1f}, {decimals(volume)}, {change:.1f}, {smallest:.0f}")
        rows.append(f"| `{name}` | " + " | ".join(cells) + " |")
    return "\n".join(rows) + "\n"


def main(arguments):
    folder = arguments.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = scene.material("Made by Lissom", (0.07, 0.27, 0.31), 0.5)
    studio = Studio(arguments.samples)
    sheets = {"gallery": (thesis_tasks, 0.62), "survey": (survey_tasks, 0.7)}
    try:
        load("survey")
    except Missing as missing:
        print(f"LEFT OUT: the survey's poses, {missing}")
        del sheets["survey"]
    text = []
    for name, (make, aspect) in sheets.items():
        tasks = list(make())
        found = picture(tasks, studio, made, folder / f"{name}.png", aspect)
        text.append(table(tasks, found))
        print(text[-1], flush=True)
        if arguments.publish:
            publish(folder / f"{name}.png", ROOT / "docs" / "pictures" / f"{name}.jpg")
    (folder / "gallery.md").write_text("\n".join(text))


def parsed(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "gallery", help="folder for the results")
    parser.add_argument("--samples", type=int, default=SAMPLES, help="samples of a pixel in the pictures")
    parser.add_argument("--publish", action="store_true", help="copy the pictures into docs/pictures")
    return parser.parse_args(words)


if __name__ == "__main__":
    main(parsed(sys.argv[1:]))
