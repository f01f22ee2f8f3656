"""Curves: edges of a mesh in the order in which they form a path or a loop."""

from .refused import Refused, first


def ordered(edges, name):
    """The vertices along ``edges``, (k, 2) of the mesh ``name``, in order; a loop ends with its first.

    Refused where they do not form one path or one loop.
    """
    beside = {}
    for a, b in edges:
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    if not beside:
        raise Refused(f"No edges of '{name}' are selected: Alt-click one on a rim to select all of it")
    branches = [vertex for vertex, others in beside.items() if len(others) > 2]
    if branches:
        raise Refused(
            f"The selected edges of '{name}' branch at {len(branches)} vertices: "
            f"{first(map(str, branches))}. Select those of one rim alone"
        )
    ends = sorted(vertex for vertex, others in beside.items() if len(others) == 1)
    start = ends[0] if ends else min(beside)
    path, before = [start], None
    while True:
        onward = [vertex for vertex in beside[path[-1]] if vertex != before]
        if not onward:
            break
        before = path[-1]
        path.append(onward[0])
        if path[-1] == start:
            break
    reached = len(set(path))
    if reached < len(beside):
        raise Refused(
            f"The selected edges of '{name}' are in several pieces, the first of {reached} vertices of "
            f"{len(beside)}: select those of one rim alone"
        )
    return path
