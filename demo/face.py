"""The face that comes along (`lissom.data`), as large as the demo has it."""

from dataclasses import dataclass

import lissom.data
import numpy as np

# From centimetres to decimetres: the head is then about as large as Suzanne.
SCALE = 0.1

PARTS = ("face", "head_and_neck", "mouth_socket", "eye_sockets")
PARTS += ("gums_and_tongue", "teeth", "eyeball_left", "eyeball_right")


@dataclass(frozen=True)
class Face:
    """Positions and offsets are (n, 3) in decimetres; neutral + identity + expression is a face."""

    neutral: np.ndarray
    identity: np.ndarray
    expressions: dict[str, np.ndarray]
    loops: np.ndarray
    counts: np.ndarray
    landmarks: np.ndarray
    vertex_part: np.ndarray  # (n,) and (polygons,): the name of the part each belongs to
    polygon_part: np.ndarray

    def only(self, *parts):
        """The face without its other parts; landmarks on those become -1."""
        return _of(lissom.data.face().only(*parts))


def load():
    """The whole face."""
    return _of(lissom.data.face())


def _of(face):
    part = np.empty(len(face.neutral), dtype="U16")
    for name in PARTS:
        part[face.regions.get(name, [])] = name
    names = face.expression_names
    return Face(
        neutral=SCALE * face.neutral,
        identity=SCALE * face.modes[0],
        expressions=dict(zip(names, SCALE * face.expressions, strict=True)),
        loops=face.loops,
        counts=face.counts,
        landmarks=face.landmarks,
        vertex_part=part,
        polygon_part=part[face.loops[np.cumsum(face.counts) - face.counts]],
    )
