"""Sets the scene of docs/pictures/panel.png: the panels in a window, after expressions went to Suzanne.

    blender --command extension install-file -r user_default -e dist/lissom-<version>-<platform>.zip
    Xvfb :9 -screen 0 1600x1000x24 &
    DISPLAY=:9 blender --factory-startup -p 0 0 1600 1000 --python tools/panel_picture.py &
    DISPLAY=:9 xdotool mousemove 1283 500 click --repeat 16 --delay 150 5      once it prints "ready"
    DISPLAY=:9 import -window root -crop 800x840+515+62 +repage docs/pictures/panel.png

With ``-- pose`` after the script's name it sets the scene of docs/pictures/panel_pose.png, a bound head, and
with ``-- inbetween`` that of panel_inbetween.png, a bent tube; those are not scrolled, and cut out with
``-crop 985x840+330+62``. On the page a picture is 750 wide: a whole window could not be read.

ImageMagick's import takes the picture: Blender's own screenshot is black on a display without graphics card.
"""

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "demo")]

import addon_utils  # noqa: E402
import bpy  # noqa: E402
import face as ict  # noqa: E402
import numpy as np  # noqa: E402
import pose  # noqa: E402
import scene  # noqa: E402
import source  # noqa: E402
import suzanne  # noqa: E402
from mathutils import Euler, Matrix  # noqa: E402

MIX = source.MIXES["surprise"]
SETTLE = 2.0  # seconds for Blender to draw


def transferred():
    """The face and Suzanne side by side, both smiling, after Fit and Transfer with the shipped markers."""
    skin = scene.material("Given", (0.44, 0.38, 0.33), 0.55)
    made = scene.material("Made by Lissom", (0.07, 0.27, 0.31), 0.5)
    into = bpy.context.scene.collection
    given = source.make("ICT skin", ict.load().only(*source.SKIN), skin, into, (-1.25, 0, 0))
    monkey, eyes = suzanne.make(made, into, (1.25, 0, 0.1))
    eyes.vertex_groups.new(name=suzanne.EYES).add(list(range(len(eyes.data.vertices))), 1.0, "REPLACE")
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = given, monkey
    settings.target_parts.add().object = eyes
    for name, value in {**suzanne.FIT, **suzanne.KEYS}.items():
        setattr(settings, name, value)
    scene.run(bpy.ops.lissom.marker_load, filepath=str(suzanne.MARKERS))
    settings.show_markers = True
    scene.run(bpy.ops.lissom.transfer_fit, **suzanne.FIT)
    scene.run(bpy.ops.lissom.transfer_keys, **suzanne.FIT, **suzanne.KEYS)
    for obj in (given, monkey):
        for name, value in MIX.items():
            obj.data.shape_keys.key_blocks[name].value = value
    bpy.context.view_layer.objects.active = monkey


def posed():
    """The head turned by its Empty, the chest held."""
    face = ict.load()
    made = scene.material("Made by Lissom", (0.07, 0.27, 0.31), 0.5)
    bust = scene.face_object("Bust", face, face.neutral, made, bpy.context.scene.collection, (0, 0, 0))
    groups = pose.regions(face)
    for name in ("chest", "head"):
        bust.vertex_groups.new(name=name).add(groups[name].tolist(), 1.0, "REPLACE")
        scene.run(bpy.ops.lissom.pose_handle_add, object=bust.name, vertex_group=name)
    scene.run(bpy.ops.lissom.pose_bind, object=bust.name, method="poisson", border=1)
    head = bust.lissom_pose.handles["head"].empty
    pivot = Matrix.Translation(pose.SPINE)
    turn = Euler((0.1, 0.3, 0.7)).to_matrix().to_4x4()
    head.matrix_world = bust.matrix_world @ pivot @ turn @ pivot.inverted() @ head.matrix_local
    bpy.context.view_layer.objects.active = bust


def bent():
    """A tube with an arc baked to a bend, and its ghost on, with a shape on the way."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=48, y_subdivisions=60, size=1.0)
    tube = bpy.context.object
    around, along, _ = scene.vertices(tube).T
    rolled = [0.5 * np.cos(2 * np.pi * around), 0.5 * np.sin(2 * np.pi * around), 3.0 * along]
    tube.data.vertices.foreach_set("co", np.stack(rolled, axis=1).astype(np.float32).ravel())
    rest = scene.vertices(tube)
    x, y, z = rest.T
    turn, centre = z + 1.5, 1.0
    shape = [centre - (centre - x) * np.cos(turn), y, (centre - x) * np.sin(turn) - 1.5]
    scene.add_keys(tube, rest, {"bent": np.stack(shape, axis=1) - rest})
    scene.run(bpy.ops.lissom.inbetween_bake, object=tube.name, end="bent", sampling="TOLERANCE")
    tube.lissom_inbetween.end = "bent"
    tube.lissom_inbetween.ghost = True
    tube.lissom_inbetween.preview = 0.4


def arrange():
    """The sidebar on our tab, both heads from the front."""
    area = next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")
    space = area.spaces.active
    space.show_region_ui = True
    space.shading.color_type = "MATERIAL"
    space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False
    space.overlay.show_cursor = False
    view = space.region_3d
    view.view_rotation = Euler((1.45, 0, 0.2)).to_quaternion()
    two = bpy.context.window_manager.lissom_page == "TRANSFER"
    view.view_location = (-1.1 if two else 0.5, 0, -0.1)
    view.view_distance = 10.4 if two else 6.8
    yield SETTLE  # the tab is known once the sidebar was drawn
    sidebar = next(region for region in area.regions if region.type == "UI")
    sidebar.active_panel_category = "Lissom"
    area.tag_redraw()
    yield SETTLE


def stage():
    """All steps; yields the seconds to wait after each."""
    yield SETTLE
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    make, page = {"pose": (posed, "POSE"), "inbetween": (bent, "INBETWEEN")}.get(
        sys.argv[-1], (transferred, "TRANSFER")
    )
    make()
    bpy.context.window_manager.lissom_page = page
    yield from arrange()
    print("ready", flush=True)


def step():
    try:
        return next(steps)
    except StopIteration:
        return None


bpy.context.preferences.view.show_splash = False
addon_utils.enable("bl_ext.user_default.lissom", default_set=False)
steps = stage()
bpy.app.timers.register(step, first_interval=1.0)
