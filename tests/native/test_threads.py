"""Results are the same to the last bit, however many threads there are."""

import os
import pathlib
import subprocess
import sys

SCRIPT = """
import hashlib, sys, warnings
import numpy as np
sys.path.insert(0, sys.argv[1])
import lissom
from shapes import ends, moved, rigid, tube

warnings.simplefilter("ignore")

def tell(name, values):
    print(name, hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest())

# Large enough for a factor in blocks, where columns that are solved together show in the last bits.
vertices, faces = tube(rows=120, columns=50)
mesh = lissom.Mesh(vertices, faces)
goal = [np.eye(4), rigid((0, 1, 0), 1.3, (0, 1, -2))]
for method in lissom.POSE_METHODS:
    pose = lissom.Pose(mesh, ends(vertices), method=method)
    tell(method, pose.solve(goal).vertices)
    targets = np.concatenate([moved(g, vertices[h]) for g, h in zip(goal, ends(vertices))])
    tell(method + " by points", pose.solve_points(targets).vertices)
for options in ({"solid": True}, {"preserve_volume": True}, {"rotation_smoothing": 0.1}):
    tell(options, lissom.Pose(mesh, ends(vertices), **options).solve(goal).vertices)

end = moved(rigid((1, 2, 0), 1.1), vertices) + 0.3 * np.sin(vertices[:, [1, 2, 0]])
path = lissom.Inbetween(mesh, vertices, end)
tell("inbetween", path.at(np.linspace(0, 1, 6)))
tell("keyframes", path.keyframes(count=5))

rest, triangles = tube(rows=60, columns=31, bumps=0.02)
target = lissom.Mesh(moved(rigid((0, 0, 1), 0.2), rest) * 1.1, triangles)
near = [[v, int(np.linalg.norm(rest - vertices[v], axis=1).argmin())] for v in (3, 2500, 5960, 1313)]
fit = lissom.fit_correspondence(mesh, target, near)
tell("fit", fit.fitted_vertices)
tell("pairs", fit.pairs)
keys = np.stack([vertices + 0.1 * k * np.sin(k * vertices[:, [2, 0, 1]]) for k in range(1, 6)])
for count in (1, 2, 5):
    tell(f"{count} keys", lissom.Transfer(mesh, target, fit).apply(keys[:count]).vertices)
"""


def test_the_number_of_threads_shows_nowhere():
    here = str(pathlib.Path(__file__).parent)

    def told(threads):
        environment = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT, here], env=environment, capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()

    alone = told(1)
    assert len(alone) > 20
    for threads in (2, 5):
        assert told(threads) == alone
