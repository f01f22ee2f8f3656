"""Pack the part of the ICT FaceKit face that the demo uses into data/ict/face.npz (see data/README.md).

    LISSOM_DATA=/folder/with/ict_face.npz python tools/pack_ict_data.py

Needed only to change the selection: the packed file is kept in the repository.
"""

import os
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent

# Name, vertices, polygons: ranges of FaceKit's own mesh, from the tables of its README. Left out are the
# irises, the lacrimal fluid, the shells that blend and shade the eyes, and the lashes: its shaders need them.
PARTS = [
    ("face", (0, 9409), (0, 9230)),
    ("head_and_neck", (9409, 11248), (9230, 11144)),
    ("mouth_socket", (11248, 13294), (11144, 13226)),
    ("eye_sockets", (13294, 14062), (13226, 14034)),
    ("gums_and_tongue", (14062, 17039), (14034, 17006)),
    ("teeth", (17039, 21451), (17006, 21496)),
    ("eyeball_left", (21451, 22221), (21496, 22296)),
    ("eyeball_right", (23021, 23791), (23094, 23894)),
]

IDENTITY = "identity000"  # of the three at hand the one furthest from the neutral face

# The 53 that are ARKit's, tongue apart, where brows and cheeks have two sides; left out are these.
NOT_STANDARD = ("PupilDilate_L", "PupilDilate_R", "cheekRaiser_L", "cheekRaiser_R")

# One step of the stored integers in centimetres: a micrometre. Rounding moves a coordinate by half of it at
# most, about one part in a million of the head's diagonal.
STEP = 1e-4


def main():
    folder = Path(os.environ.get("LISSOM_DATA", ROOT.parent / "shared" / "data"))
    face = np.load(folder / "ict_face.npz")

    vertices = np.concatenate([np.arange(*span) for _, span, _ in PARTS])
    polygons = np.concatenate([np.arange(*span) for _, _, span in PARTS])
    renumbered = np.full(len(face["neutral"]), -1, dtype=np.int32)
    renumbered[vertices] = np.arange(len(vertices), dtype=np.int32)

    corners = np.concatenate([[0], np.cumsum(face["counts"])])
    loops = np.concatenate([renumbered[face["loops"][corners[p] : corners[p + 1]]] for p in polygons])
    assert loops.min() == 0, "a kept polygon uses a vertex that is left out"

    standard = ~np.isin(face["expression_names"], NOT_STANDARD)
    expression_names = face["expression_names"][standard]
    expressions = face["expressions"][standard][:, vertices]
    identity = face["identities"][list(face["identity_names"]).index(IDENTITY)][vertices]

    def in_steps(offsets):
        return np.rint(offsets.astype(np.float64) / STEP).astype(np.int32)

    def starts(spans):
        return np.cumsum([0] + [stop - start for start, stop in spans]).astype(np.int32)

    packed = ROOT / "data" / "ict" / "face.npz"
    packed.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(
        packed,
        step=np.float64(STEP),
        neutral=in_steps(face["neutral"][vertices]),
        identity=in_steps(identity),
        expressions=in_steps(expressions),
        expression_names=expression_names,
        loops=loops,
        counts=face["counts"][polygons],
        landmarks=renumbered[face["landmarks"]],
        part_names=np.array([name for name, _, _ in PARTS]),
        part_vertex_starts=starts([span for _, span, _ in PARTS]),
        part_polygon_starts=starts([span for _, _, span in PARTS]),
    )
    print(
        f"{packed.relative_to(ROOT)}: {len(vertices)} vertices, {len(polygons)} polygons, "
        f"{len(expression_names)} expressions, {packed.stat().st_size / 1e6:.2f} MB"
    )


if __name__ == "__main__":
    main()
