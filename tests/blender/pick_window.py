"""Markers picked with a real mouse, then Fit, Transfer and colours. Run with the extension installed:

    blender --command extension install-file -r user_default -e dist/lissom-<version>-<platform>.zip
    blender --python-exit-code 1 --python tests/blender/pick_window.py

The mouse is xdotool's. Where Blender cannot start it, LISSOM_MOUSE names a pipe, and beside Blender runs

    while read -r words && [ "$words" != end ]; do xdotool $words; done <> "$LISSOM_MOUSE"

Prints one line a step and leaves Blender open for a look; a failed step ends it with exit code 1.
"""

import os
import pathlib
import subprocess
import sys
import time
import traceback

import addon_utils
import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Quaternion, Vector

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import scene

PLACES = [  # on Suzanne, seen from the front
    ((0.0, -0.85, -0.98), "chin"),
    ((0.19, -0.8, 0.64), "left forehead"),
    ((0.47, -0.76, 0.24), "left eye"),
    ((0.0, -0.93, -0.3), "nose"),
    ((1.25, -0.1, 0.3), "left ear"),
    ((0.3, -0.75, -0.7), "left corner"),
]
SHIFT = 1.6
PAUSE = 0.4
PIPE = os.environ.get("LISSOM_MOUSE")


def view():
    for area in bpy.context.window_manager.windows[0].screen.areas:
        if area.type == "VIEW_3D":
            region = next(region for region in area.regions if region.type == "WINDOW")
            return area, region, area.spaces.active


def mouse(*words):
    words = [str(word) for word in words]
    if PIPE:
        pathlib.Path(PIPE).write_text(" ".join(words) + "\n", encoding="ascii")
    else:
        subprocess.run(["xdotool", *words], check=True)


def on_display(region, place):
    spot = view3d_utils.location_3d_to_region_2d(region, region.data, Vector(place))
    height = bpy.context.window_manager.windows[0].height
    return round(region.x + spot.x), round(height - 1 - (region.y + spot.y))


def point(region, place):
    """Blender takes a press to be where it last saw the mouse: it has to see it move before."""
    mouse("mousemove", *on_display(region, place))
    yield PAUSE
    yield PAUSE


def click(region, place, button=1, held=None):
    yield from point(region, place)
    for words in (("keydown", held), ("click", button), ("keyup", held)):
        if None not in words:
            mouse(*words)
            yield PAUSE
    yield PAUSE


def marked_place(obj, row, side):
    """Where a mark is, in the world."""
    return obj.matrix_world @ Vector(row.point(side).position(scene.points(obj.data.vertices)))


def until(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        yield 0.2


def surface_place(obj, place):
    """The vertex of the front nearest to a place, in the world."""
    mesh = obj.data
    points = scene.points(mesh.vertices)
    normals = np.array([vertex.normal for vertex in mesh.vertices])
    away = np.linalg.norm(points - place, axis=1) + 10 * (normals[:, 1] > -0.5)
    return obj.matrix_world @ mesh.vertices[int(away.argmin())].co


def steps():
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    source, target = scene.monkey(2, "Source"), scene.monkey(2, "Target")
    target.modifiers.new("Triangles", "TRIANGULATE")
    bpy.ops.object.modifier_apply(modifier="Triangles")
    source.location.x, target.location.x = -SHIFT, SHIFT
    rest = scene.points(source.data.vertices)
    scene.add_key(source, "squash", rest * [1.1, 1, 0.8])
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = source, target
    area, region, space = view()
    space.show_region_ui = True
    space.region_3d.view_perspective = "ORTHO"
    space.region_3d.view_rotation = Quaternion((0.7071068, 0.7071068, 0, 0))
    space.region_3d.view_location, space.region_3d.view_distance = Vector((0.6, 0, 0)), 9.0
    yield 2.0
    for ui in area.regions:
        if ui.type == "UI":
            ui.active_panel_category = "Lissom"
    bpy.ops.ed.undo_push(message="scene")
    yield 1.0

    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area, region=region):
        assert bpy.ops.lissom.marker_pick("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield 0.5
    rows = settings.markers
    for place, _name in PLACES:
        for obj in (source, target) if len(rows) % 2 else (target, source):  # in either order
            yield from click(region, surface_place(obj, place))
    assert len(rows) == len(PLACES), len(rows)
    for row, (place, name) in zip(rows, PLACES, strict=True):
        for obj, side in ((source, "source"), (target, "target")):
            assert (marked_place(obj, row, side) - surface_place(obj, place)).length < 0.06, (
                name
            )  # rims draw the mouse
        row.name = name
    assert not all(point.is_vertex for row in rows for point in row.ends), "points, not vertices"
    print("PASS pairs are picked in either order")
    yield 0.5

    bpy.ops.ed.undo_push(message="names")
    yield from click(region, surface_place(target, (0.6, -0.6, -0.2)))
    assert len(rows) == len(PLACES), "half a pair is not in the list"
    yield from click(region, surface_place(target, (-0.6, -0.6, -0.2)))  # again on the same side: moves
    yield from click(region, surface_place(source, (-0.6, -0.6, -0.2)))
    assert len(rows) == len(PLACES) + 1
    begin = surface_place(target, (-0.6, -0.6, -0.2))
    goal = surface_place(target, (-0.75, -0.55, -0.05))
    before = rows[len(PLACES)].target
    yield from point(region, begin)
    mouse("mousedown", 1)
    yield PAUSE
    for share in (0.25, 0.5, 0.75, 1.0):
        yield from point(region, begin.lerp(goal, share))
    mouse("mouseup", 1)
    yield 0.5
    row = rows[len(PLACES)]
    assert row.target != before
    there = marked_place(target, row, "target")
    assert (there - goal).length < 0.02
    assert (target.matrix_world @ Vector(row.target_place) - there).length < 1e-5
    print("PASS a mark is dragged")

    from bl_ext.user_default.lissom import session

    yield from point(region, marked_place(source, row, "source"))
    assert session.picking.ring is not None, "the ring is around what would be taken"
    beside = marked_place(source, row, "source") + Vector((0.03, 0, 0))
    yield from click(region, beside, held="ctrl")
    assert session.picking.side == "source" and len(rows) == len(PLACES) + 1, "Ctrl: another beside it"
    yield from click(region, beside, button=3)
    assert session.picking.side is None
    yield from point(region, (0, 0, -1.9))
    assert session.picking.ring is None
    print("PASS Ctrl marks beside a mark")

    yield from click(region, marked_place(source, row, "source"), button=3)
    assert len(rows) == len(PLACES), "a right click removes the pair"
    print("PASS a pair is removed")
    mouse("key", "ctrl+z")
    yield 1.0
    settings = bpy.context.scene.lissom_transfer
    rows = settings.markers
    assert len(rows) == len(PLACES) + 1, "undo brings it back"
    source, target = settings.source, settings.target
    print("PASS undo while picking")

    yield from point(region, (SHIFT, 0, -1.6))
    mouse("key", "Return")
    yield PAUSE
    assert session.picking is None
    assert settings.show_markers, "the marks stay"
    assert bpy.ops.lissom.marker_mirror() == {"FINISHED"}
    assert len(rows) == len(PLACES) + 6, len(rows)
    print("PASS the other side is completed")

    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, area=area, region=region):
        assert bpy.ops.lissom.marker_views() == {"FINISHED"}
        assert bpy.ops.lissom.marker_pick("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield 2.0
    areas = sorted((a for a in window.screen.areas if a.type == "VIEW_3D"), key=lambda a: a.x)
    assert [bool(a.spaces.active.local_view) for a in areas] == [True, True]
    assert [[obj.visible_get(viewport=a.spaces.active) for obj in (source, target)] for a in areas] == [
        [True, False],
        [False, True],
    ]
    for half, obj in zip(areas, (source, target), strict=True):
        region = next(r for r in half.regions if r.type == "WINDOW")
        yield from click(region, surface_place(obj, (0.2, -0.8, -0.1)))
    assert len(rows) == len(PLACES) + 7
    yield 1.0
    if os.environ.get("LISSOM_STOP") == "views":
        return
    mouse("key", "Return")
    yield 0.6
    area, region, space = view()
    with bpy.context.temp_override(window=window, area=area, region=region):
        assert bpy.ops.lissom.marker_views() == {"FINISHED"}
    yield 1.0
    area, region, space = view()
    assert len([a for a in window.screen.areas if a.type == "VIEW_3D"]) == 1 and not space.local_view
    settings.markers.remove(len(rows) - 1)
    print("PASS two views at once")
    if os.environ.get("LISSOM_STOP") == "markers":
        return

    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area, region=region):
        bpy.ops.lissom.transfer_fit("INVOKE_DEFAULT")
        yield from until(lambda: session.work is None and session.fit is not None)
        bpy.ops.lissom.transfer_keys("INVOKE_DEFAULT")
        yield from until(lambda: session.work is None and target.data.shape_keys is not None)
    delta = scene.key_points(target, "squash") - scene.key_points(target, "Basis")
    known = scene.key_points(target, "Basis") * [0.1, 0, -0.2]
    off = np.sqrt(np.mean((delta - known) ** 2) / np.mean(known**2))
    assert off < 0.25, off
    print(f"PASS fit and transfer, {100 * off:.1f} % off")
    assert bpy.ops.lissom.fit_show() == {"FINISHED"}
    target.data.shape_keys.key_blocks["squash"].value = 0.0
    yield 1.0
    print("PASS colours")


def main():
    addon_utils.enable("bl_ext.user_default.lissom")
    run = steps()

    def tick():
        try:
            return next(run)
        except StopIteration:
            print("ALL PASS", flush=True)
            if PIPE:
                mouse("end")
        except Exception:
            sys.stdout.flush()
            traceback.print_exc()
            sys.stderr.flush()
            if PIPE:
                mouse("end")
            os._exit(1)
        return None

    bpy.app.timers.register(tick, first_interval=2.0)


main()
