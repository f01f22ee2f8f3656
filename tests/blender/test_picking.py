"""What is under the mouse: surfaces, rims and marks, and what hides them."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge import markers, picking
from bl_ext.user_default.lissom.core.picking import Picking, View
from bl_ext.user_default.lissom.core.refused import Refused
from bl_ext.user_default.lissom.core.surface import Point
from mathutils import Matrix, Vector

SIZE = 800


def view(eye, target=(0, 0, 0)):
    """A square view with perspective from ``eye``."""
    way = Vector(target) - Vector(eye)
    placing = way.to_track_quat("-Z", "Y").to_matrix().to_4x4()
    placing.translation = eye
    near, far, lens = 0.01, 1000.0, 2.0
    shape = [
        [lens, 0, 0, 0],
        [0, lens, 0, 0],
        [0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)],
        [0, 0, -1, 0],
    ]
    return View(np.array(Matrix(shape) @ placing.inverted()), (SIZE, SIZE))


def two(make, apart=50):
    """Source and target of a kind, the target far to the side."""
    source, target = make(name="Source"), make(name="Target")
    target.location.x = apart
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = source, target
    bpy.context.view_layer.update()
    return source, target


def stage(shown):
    graph = bpy.context.evaluated_depsgraph_get()
    return picking.Stage(bpy.context.scene, graph, shown, None, session.picking)


def world(obj, point):
    """Where a point of an object is as it is shown."""
    return np.array(obj.matrix_world @ Vector(point.position(scene.shown(obj))))


def pixel(shown, place):
    return tuple(shown.project([place])[0][0])


@pytest.mark.parametrize("modifier", [None, "SIMPLE_DEFORM", "TRIANGULATE"])
def test_the_point_under_the_mouse_is_shown_there(modifier):
    source, _ = two(scene.monkey)
    source.location, source.rotation_euler, source.scale = (1, 2, 3), (0.3, 0.2, 0.1), (2, 1, -0.5)
    scene.add_key(source, "up", scene.points(source.data.vertices) * [1, 1.2, 1], value=1.0)
    if modifier:
        source.modifiers.new("M", modifier)
    bpy.context.view_layer.update()
    shown = view((1, -9, 4), source.location)
    polygons = [set(face.vertices) for face in source.data.polygons]
    found = inside = 0
    for mouse in np.random.default_rng(0).uniform(330, 470, size=(150, 2)):
        try:
            here = stage(shown).point_at(tuple(mouse), 1.0, exact=True)
        except Refused:  # between her eyes, which are parts of their own, and their lids
            inside += 1
            continue
        if here is None:
            continue
        side, point, spot = here
        assert side == "source" and spot == tuple(mouse)
        (origin,), (way,) = shown.rays([mouse])
        place = world(source, point)
        away = np.linalg.norm(np.cross(place - origin, way))
        assert away < 2e-3, "on the ray"
        assert any(set(point.corners) <= face for face in polygons)
        found += 1
    assert found > 40 and inside < 8, (found, inside)


def test_under_a_subdivision_the_nearest_point_of_the_mesh_itself_is_found():
    source, _ = two(lambda name: scene.monkey(1, name))
    source.modifiers.new("Smooth", "SUBSURF").levels = 2
    bpy.context.view_layer.update()
    shown, found = view((0, -6, 0)), 0
    rest = scene.points(source.data.vertices)
    for mouse in np.random.default_rng(0).uniform(300, 500, size=(60, 2)):
        here = stage(shown).point_at(tuple(mouse), 1.0, exact=True)
        if here is not None:
            found += 1
            off = pixel(shown, here[1].position(rest)) - mouse
            assert np.linalg.norm(off) < 40 and max(here[1].corners) < len(rest)
    assert found > 20


def test_the_inside_is_refused_and_rims_draw_the_mouse():
    source, _ = two(scene.tube)
    shown = view((0, 0, 9))  # into its upper opening
    assert source.data.vertices[60 * 40].co.z == 3
    inner = pixel(shown, (0.0, 0.93, 2.0))
    with pytest.raises(Refused, match="the inside of 'Source', seen through an opening"):
        stage(shown).point_at(inner, 1.0)
    around = np.linspace(0, 2 * np.pi, 50)
    for turn, beside in zip(around, np.linspace(-7, 7, 50), strict=True):
        rim = np.array(pixel(shown, (np.cos(turn), np.sin(turn), 3.0)))
        outward = rim - SIZE / 2
        mouse = tuple(rim + beside * outward / np.linalg.norm(outward))
        for exact in (False, True):
            side, point, spot = stage(shown).point_at(mouse, 1.0, exact)
            place = world(source, point)
            assert side == "source" and place[2] == pytest.approx(3), "the other end's rim is inside"
            assert np.linalg.norm(np.subtract(spot, mouse)) < 8.2
            assert point.weights[2] == 0, "on an edge"
    away = tuple(rim + 12 * outward / np.linalg.norm(outward))
    assert stage(shown).point_at(away, 1.0) is None


def test_of_a_rim_on_the_far_side_nothing_is_taken():
    two(scene.tube)
    shown = view((0, -9, 0))
    back = pixel(shown, (0.0, 1.0, 3.0))
    assert stage(shown).rim_at(back, 1.0) is None
    front = pixel(shown, (0.0, -1.0, 3.0))
    assert stage(shown).rim_at(front, 1.0)[0] == "source"


def curtain():
    bpy.ops.mesh.primitive_plane_add(size=0.8, location=(0, -3, 0), rotation=(np.pi / 2, 0, 0))
    return bpy.context.object


def test_every_visible_object_hides_what_is_behind_it():
    two(scene.monkey)
    shown, middle = view((0, -9, 0)), (SIZE / 2, SIZE / 2 + 5)
    assert stage(shown).point_at(middle, 1.0)[0] == "source"
    cover = curtain()
    assert stage(shown).point_at(middle, 1.0) is None
    for change in (
        lambda: cover.hide_set(True),
        lambda: setattr(cover, "hide_viewport", True),
        lambda: setattr(cover, "display_type", "WIRE"),
        lambda: setattr(cover.location, "z", 5),
    ):
        change()
        bpy.context.view_layer.update()
        assert stage(shown).point_at(middle, 1.0)[0] == "source"
        cover.hide_viewport, cover.display_type, cover.location.z = False, "TEXTURED", 0
        cover.hide_set(False)
        bpy.context.view_layer.update()
        assert stage(shown).point_at(middle, 1.0) is None


def test_an_instance_of_the_source_hides_it_and_cannot_be_marked():
    source, _ = two(scene.monkey)
    collection = bpy.data.collections.new("Crowd")
    collection.objects.link(source)
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    instance.location.y = -3
    bpy.context.collection.objects.link(instance)
    bpy.context.view_layer.update()
    assert stage(view((0, -9, 0))).point_at((SIZE / 2, SIZE / 2 + 5), 1.0) is None


def marked():
    """Marks on the front and the back of the source; picking has begun a third."""
    source, target = two(scene.monkey)
    rest = scene.points(source.data.vertices)
    front = Point.of([source.data.polygons[0].vertices[i] for i in range(3)], [1, 1, 1])
    chin, back = (int(np.argmax(rest @ way)) for way in ([0, -1, -0.6], [0, 1, 0.5]))
    new = [markers.markers.Marker.between("", p, p) for p in (front, Point.at(chin), Point.at(back))]
    markers.append(bpy.context.scene, new, source, target)
    return source, chin, back


def test_marks_behind_are_hidden_and_seen_ones_are_taken_first():
    source, chin, _ = marked()
    eye = np.array([0, -9, -3.0])
    shown = view(tuple(eye))
    seen = {mark.index: hidden for mark, _, hidden in stage(shown).marks() if mark.side == "source"}
    assert seen[1] is False and seen[2] is True
    behind = view(tuple(-eye))
    seen = {mark.index: hidden for mark, _, hidden in stage(behind).marks() if mark.side == "source"}
    assert seen[1] is True and seen[2] is False
    mouse = pixel(shown, scene.shown(source)[chin])
    assert stage(shown).mark_at(mouse, 1.0)[0].index == 1
    assert stage(shown).mark_at((3, 3), 1.0) is None
    curtain().scale *= 9
    bpy.context.view_layer.update()
    assert all(hidden for _, _, hidden in stage(shown).marks())
    assert stage(shown).mark_at(mouse, 1.0)[0].index == 1, "hollow marks can be taken too"


def test_marks_go_with_the_surface_as_it_is_shown():
    source, *_ = marked()
    rest = scene.points(source.data.vertices)
    shown = view((0, -9, 0))
    point = markers.of_scene(bpy.context.scene)[0].point("source")
    scene.add_key(source, "up", rest * [1, 1, 1.3] + [0, 0, 0.4], value=1.0)
    bpy.context.view_layer.update()
    spot = next(spot for mark, spot, _ in stage(shown).marks() if mark.index == 0)
    assert spot == pytest.approx(pixel(shown, point.position(rest) * [1, 1, 1.3] + [0, 0, 0.4]), abs=0.1)


def test_numbers_and_names_never_change():
    marked()
    rows = bpy.context.scene.lissom_transfer.markers
    assert [(row.number, row.name) for row in rows] == [(1, "Marker 1"), (2, "Marker 2"), (3, "Marker 3")]
    session.picking = Picking()
    session.picking.take("source", Point.at(5))
    assert [m.number for m in markers.marks_of(bpy.context.scene, session.picking)] == [1, 1, 2, 2, 3, 3, 4]
    assert bpy.ops.lissom.marker_remove(index=1) == {"FINISHED"}
    assert [m.number for m in markers.marks_of(bpy.context.scene, session.picking)] == [1, 1, 3, 3, 4]
    session.picking = None
    bpy.ops.lissom.marker_add(source_vertex=7, target_vertex=8)
    assert [(row.number, row.name) for row in rows] == [(1, "Marker 1"), (3, "Marker 3"), (4, "Marker 4")]


def test_a_scene_from_before_points_and_numbers_has_both():
    """Its rows have vertices alone, and are numbered as they were shown: by their order."""
    two(scene.monkey)
    rows = bpy.context.scene.lissom_transfer.markers
    for vertex in (40, 50, 60):
        row = rows.add()
        row.name = str(vertex)
        row["source"], row["target"] = vertex, vertex + 1  # as a file has it, without what typing does
    pairs = markers.of_scene(bpy.context.scene)
    assert [pair.ends for pair in pairs] == [(Point.at(v), Point.at(v + 1)) for v in (40, 50, 60)]
    assert bpy.ops.lissom.marker_remove(index=0) == {"FINISHED"}
    assert [row.number for row in rows] == [2, 3]


def test_a_vertex_typed_in_is_where_the_mark_is():
    source, *_ = marked()
    row = bpy.context.scene.lissom_transfer.markers[0]
    assert not row.point("source").is_vertex
    row.source = 77
    assert row.point("source") == Point.at(77)
    assert row.place("source") == pytest.approx(tuple(source.data.vertices[77].co))
    markers.move(bpy.context.scene, 0, "source", Point.of([3, 4, 5], [1, 2, 3]))
    assert row.source == 5 and row.point("source") == Point.of([3, 4, 5], [1, 2, 3])
    rest = scene.points(source.data.vertices)
    assert row.place("source") == pytest.approx(tuple(rest[[3, 4, 5]].T @ [1 / 6, 2 / 6, 3 / 6]), abs=1e-5)
    taken = markers.of_scene(bpy.context.scene)[1].point("source")
    markers.move(bpy.context.scene, 0, "source", taken)
    assert row.point("source") != taken, "no two marks in one place"
