"""The face that comes with the project (data/ict, described in data/README.md), in Blender's axes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

PACKED = Path(__file__).resolve().parent.parent / "data" / "ict" / "face.npz"

# Stored in centimetres with y up and z forward; Blender has z up and looks along y. A tenth makes
# decimetres: the head is then about as large as Suzanne.
SCALE = 0.1


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
        kept = np.isin(self.vertex_part, parts)
        renumbered = np.where(kept, np.cumsum(kept) - 1, -1).astype(np.int32)
        polygons = np.isin(self.polygon_part, parts)
        return Face(
            self.neutral[kept],
            self.identity[kept],
            {name: offsets[kept] for name, offsets in self.expressions.items()},
            renumbered[self.loops[np.repeat(polygons, self.counts)]],
            self.counts[polygons],
            renumbered[self.landmarks],
            self.vertex_part[kept],
            self.polygon_part[polygons],
        )


def load(path=PACKED):
    """Reads the packed face."""
    packed = np.load(path)

    def positions(name):
        x, y, z = np.moveaxis(packed[name] * (float(packed["step"]) * SCALE), -1, 0)
        return np.stack([x, -z, y], axis=-1)

    names = packed["part_names"]
    return Face(
        neutral=positions("neutral"),
        identity=positions("identity"),
        expressions=dict(zip(packed["expression_names"].tolist(), positions("expressions"), strict=True)),
        loops=packed["loops"],
        counts=packed["counts"].astype(np.int32),
        landmarks=packed["landmarks"],
        vertex_part=np.repeat(names, np.diff(packed["part_vertex_starts"])),
        polygon_part=np.repeat(names, np.diff(packed["part_polygon_starts"])),
    )
