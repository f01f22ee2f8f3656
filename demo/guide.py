"""Words in demo.blend: a label below each group of objects, and a page that says what to try."""

import bpy
import numpy as np
import scene

# Of each collection: what it shows, and what to try there.
WORDS = {
    "1 Pose": (
        "Pose by two handles",
        "Each pose is a shape key: move its value. Press Bind on the Pose page to pose by its handles.",
    ),
    "2 ICT face": (
        "The source of the expressions",
        "Its shape keys are those that the other heads were given.",
    ),
    "3 Remeshed identity": (
        "Another person, another mesh",
        "Its keys came from the ICT face: move their values, and compare.",
    ),
    "4 Suzanne": (
        "Suzanne, by pairs of markers",
        "Her keys came from the ICT face by pairs of markers and curves: move their values.",
    ),
    "5 In-between": (
        "Arcs between two keys",
        "Select a head and move its slider on the In-between page.",
    ),
    "6 Arcs": (
        "Arcs about known axes",
        "Move the sliders: a lid about its ball, a jaw about its hinge, bars that twist.",
    ),
    "7 Elbow": (
        "A bone drives a corrective",
        "Rotate the forearm in Pose Mode: the shape key follows the bone.",
    ),
    "7 Drawing": (
        "Two drawings, one slider",
        "Move the slider of the worm: shape and picture go from one drawing to the other.",
    ),
}
HEIGHT, BELOW = 0.16, 0.25  # of a label, and from it to what it is about
TITLE = "Read Me"


def write():
    """Adds the labels and the page; returns the page. Each window opens with the page and the sidebar."""
    into = scene.collection("0 Labels")
    material = scene.material("Label", (0.9, 0.9, 0.9), 0.6)
    page = bpy.data.texts.new(TITLE)
    page.write("Lissom: the demo\n\nThe Lissom tab is in the sidebar of the 3D view (press N).\n")
    for name, (title, line) in WORDS.items():
        shown = bpy.data.collections.get(name)
        corners = _corners(shown) if shown is not None else None
        if corners is not None:
            _label(title, material, into, corners)
        page.write(f"\n{name.partition(' ')[2]}: {title}\n    {line}\n")
    page.cursor_set(0)
    for screen in bpy.data.screens:
        _open(screen, page)
    return page


def _corners(collection):
    """(n, 3): the boxes of the mesh objects of a collection; None where it has none."""
    boxes = [
        np.array(obj.bound_box) @ np.array(obj.matrix_world)[:3, :3].T + np.array(obj.location)
        for obj in collection.all_objects
        if obj.type == "MESH" and obj.parent is None
    ]
    return np.concatenate(boxes) if boxes else None


def _label(title, material, into, corners):
    """The title, upright, below the middle of what it is about."""
    text = bpy.data.curves.new(f"Label: {title}", "FONT")
    text.body, text.size, text.align_x = title, HEIGHT, "CENTER"
    text.materials.append(material)
    obj = bpy.data.objects.new(text.name, text)
    low, high = corners.min(axis=0), corners.max(axis=0)
    obj.location = ((low[0] + high[0]) / 2, low[1], low[2] - BELOW)
    obj.rotation_euler.x = np.pi / 2
    obj.hide_render = obj.hide_select = True
    into.objects.link(obj)


def _open(screen, page):
    areas = {area.type: area for area in screen.areas}
    if "VIEW_3D" not in areas:
        return
    areas["VIEW_3D"].spaces.active.show_region_ui = True
    below = areas.get("DOPESHEET_EDITOR")
    if screen.name == "Layout" and below is not None:
        below.type = "TEXT_EDITOR"
        below.spaces.active.text = page
        below.spaces.active.show_word_wrap = True
