"""In-between: an object that the arc keeps out of."""

import bpy
import numpy as np
import pytest
import scene
from test_inbetween import slide

RADIUS, OFF = 1.0, 0.06  # of the ball, and how far its centre lies towards the middle of the arc
TURN = np.radians(90.0)
MIDDLE = np.radians(65.0)  # where the middle of the sheet is half way


def around_x(vertices, angle):
    x, y, z = vertices.T
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([x, c * y - s * z, s * y + c * z], axis=1)


def sheet_and_ball(location=(0, 0, 0), scale=(1, 1, 1)):
    """A sheet on a cylinder about x that turns by 90 degrees, and a ball that its middle would enter."""
    across, along = np.linspace(-0.25, 0.25, 41), np.radians(np.linspace(0, 40, 51))
    rest = np.array([(x, RADIUS * np.cos(a), RADIUS * np.sin(a)) for a in along for x in across])
    faces = [
        (r * 41 + i, r * 41 + i + 1, (r + 1) * 41 + i + 1, (r + 1) * 41 + i)
        for r in range(50)
        for i in range(40)
    ]
    mesh = bpy.data.meshes.new("Lid")
    mesh.from_pydata((rest / scale).tolist(), [], faces)
    obj = bpy.data.objects.new("Lid", mesh)
    bpy.context.collection.objects.link(obj)
    obj.location, obj.scale = location, scale
    assert len(rest) > 2000
    scene.add_key(obj, "closed", around_x(rest, TURN) / scale)
    centre = OFF * np.array([0, np.cos(MIDDLE), np.sin(MIDDLE)])
    bpy.ops.mesh.primitive_uv_sphere_add(
        segments=96, ring_count=48, radius=RADIUS, location=centre + location
    )
    ball = bpy.context.object
    ball.name = "Ball"
    bpy.context.view_layer.update()
    return obj, ball, centre


def depths(obj, slider, centre, scale=(1, 1, 1)):
    """(t,): how deep the sheet is in the ball along the slider."""
    found = []
    for time in np.linspace(0, 1, 21):
        slide(obj, slider, time)
        found.append(RADIUS - np.linalg.norm(scene.shown(obj) * scale - centre, axis=1).min())
    return np.array(found)


@pytest.mark.parametrize(("location", "scale"), [((0, 0, 0), (1, 1, 1)), ((3, -2, 1), (0.5, 2, 1))])
def test_the_arc_enters_no_deeper_than_its_ends(location, scale):
    obj, _, centre = sheet_and_ball(location, scale)
    bake = bpy.ops.lissom.inbetween_bake
    bake(object="Lid", end="closed", count=15, slider="plain")
    bake(object="Lid", end="closed", count=15, slider="clear", clearance="Ball")
    plain = depths(obj, "plain", centre, scale)
    slide(obj, "plain", 0.0)
    clear = depths(obj, "clear", centre, scale)
    ends = max(clear[0], clear[-1])
    print(f"ends {ends:.4f}, plain {plain.max():.4f}, clear {clear.max():.4f}")
    assert plain.max() > ends + 0.005
    # The ball's facets and the straight lines between keys cut as much.
    assert clear.max() < ends + 0.0025
    assert obj.lissom_inbetween.arcs["clear"].clearance == "Ball"


def test_its_own_keys_of_the_ends_names_move_the_obstacle():
    obj, ball, centre = sheet_and_ball()
    rest = scene.points(ball.data.vertices)
    scene.add_key(ball, "closed", rest - centre)  # the ball is out of the way at the end
    bake = bpy.ops.lissom.inbetween_bake
    bake(object="Lid", end="closed", count=5, slider="still", clearance="Ball")
    still = depths(obj, "still", centre)
    slide(obj, "still", 0.0)
    ball.data.shape_keys.key_blocks["closed"].name = "other"
    bake(object="Lid", end="closed", count=5, slider="moved", clearance="Ball")
    assert np.abs(depths(obj, "moved", centre) - still).max() > 1e-3


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("none", "no object named 'none'"),
        ("Lid", "names the mesh itself"),
        ("Empty", "is no mesh"),
        ("Plane", "not closed"),
    ],
)
def test_what_is_no_obstacle(name, message):
    sheet_and_ball()
    bpy.ops.mesh.primitive_plane_add()
    bpy.context.collection.objects.link(bpy.data.objects.new("Empty", None))
    with scene.refused(message):
        bpy.ops.lissom.inbetween_bake(object="Lid", end="closed", clearance=name)
