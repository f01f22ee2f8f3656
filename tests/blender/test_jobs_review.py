"""Review without a window: each key is shown on both meshes, and nothing is left changed."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge import shape_keys
from bl_ext.user_default.lissom.core.refused import Refused
from bl_ext.user_default.lissom.jobs import learn_shown
from bl_ext.user_default.lissom.jobs.review import Review, order
from numpy.testing import assert_allclose
from test_panels import draw, text
from test_transfer import monkeys


@pytest.fixture
def reviewed():
    """A review of two keys, one of them driven; source, target and what was before."""
    source, target = monkeys()
    bpy.ops.lissom.transfer_keys()
    target.data.shape_keys.key_blocks["ears"].driver_add("value").driver.expression = "0.25"
    target.data.shape_keys.key_blocks["squash"].value = 0.5
    target.active_shape_key_index, source.active_shape_key_index = 0, 2
    source.show_only_shape_key = True
    bpy.context.view_layer.objects.active = source
    bpy.context.view_layer.update()
    before = state()
    review = Review(bpy.context, ([source], [target]))
    session.review = review
    yield review, source, target, before
    session.review = None


def state():
    objects = [obj for obj in bpy.data.objects if obj.type == "MESH"]
    return {
        obj.name: (
            obj.active_shape_key_index,
            obj.show_only_shape_key,
            obj.mode,
            obj.select_get(),
            [(key.value, key.mute) for key in obj.data.shape_keys.key_blocks],
        )
        for obj in objects
    } | {"": (bpy.context.view_layer.objects.active.name, settings().active_quality)}


def alone(obj, name):
    """What a key shows at 1, by itself and where its vertex group lets it."""
    return shape_keys.seen(obj, obj.data.shape_keys.key_blocks[name])


def settings():
    return bpy.context.scene.lissom_transfer


def test_the_worst_key_is_shown_first_and_alone_on_both(reviewed):
    review, source, target, _ = reviewed
    rows = [settings().quality[place].name for place in order(settings())]
    assert review.key == rows[0]
    for step, name in ((0, rows[0]), (1, rows[1]), (1, rows[1]), (-1, rows[0])):
        review.step(settings(), step)
        assert review.key == name
        for obj in (source, target):
            assert_allclose(scene.shown(obj), alone(obj, name), atol=1e-6)


def test_space_shows_what_is_at_rest_and_a_click_any_key(reviewed):
    review, source, target, _ = reviewed
    review.toggle(settings())
    for obj in (source, target):
        assert_allclose(scene.shown(obj), scene.key_points(obj, "Basis"), atol=1e-6)
    review.toggle(settings())
    for place, row in enumerate(settings().quality):
        settings().active_quality = place  # as a click in the list
        assert review.key == row.name
        assert_allclose(scene.shown(target), alone(target, row.name), atol=1e-6)


def test_a_key_of_another_name_is_shown_beside_its_source():
    source, target = monkeys()
    bpy.ops.lissom.transfer_keys()
    bpy.ops.lissom.transfer_keys(exists="RENAME")
    review = Review(bpy.context, ([source], [target]))
    assert review.key.endswith(".001")
    assert_allclose(scene.shown(source), alone(source, review.key[:-4]), atol=1e-6)
    review.leave(bpy.context)


def test_nothing_is_left_changed(reviewed):
    review, _, _, before = reviewed
    review.step(settings(), 1)
    review.toggle(settings())
    session.review = None
    review.leave(bpy.context)
    assert state() == before


def test_a_key_is_opened_for_sculpting_and_what_is_mended_stays(reviewed):
    review, _, target, before = reviewed
    review.mend(bpy.context)
    assert review.mending == target and target.mode == "SCULPT"
    assert target.active_shape_key.name == review.key and target.show_only_shape_key
    review.rest(bpy.context)
    assert review.mending is None
    key = target.data.shape_keys.key_blocks[review.key]
    key.data[5].co.x += 0.25
    mended = np.array(key.data[5].co)
    session.review = None
    review.leave(bpy.context)
    assert state() == before
    assert_allclose(key.data[5].co, mended)


def whole_state():
    """All that there is in the file, and where it is shown."""
    kinds = (bpy.data.objects, bpy.data.meshes, bpy.data.shape_keys, bpy.data.actions, bpy.data.collections)
    return scene.snapshot(), [sorted(kind.keys()) for kind in kinds]


@pytest.mark.parametrize("leave", [False, True])
def test_a_key_is_mended_by_handles_and_nothing_else_is_touched(reviewed, leave):
    review, _, target, before = reviewed
    key = target.data.shape_keys.key_blocks[review.key]
    group = target.vertex_groups.new(name="mask")
    group.add(list(range(len(target.data.vertices))), 0.5, "REPLACE")
    key.vertex_group = "mask"
    target.location.z = 3
    bpy.context.view_layer.update()
    others, shape = whole_state(), scene.key_points(target, key.name)
    seen = alone(target, key.name)
    review.mend(bpy.context, "HANDLES")
    posed = review.mending
    assert posed not in (None, target) and bpy.context.active_object == posed
    assert_allclose(scene.shown(posed), seen, atol=1e-6)  # the mesh as the key shows it
    assert posed.matrix_world == target.matrix_world
    top = int(seen[:, 2].argmax())
    held = np.flatnonzero(seen[:, 2] < seen[:, 2].mean())
    for name, vertices in (("top", [top]), ("held", held.tolist())):
        posed.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")
        bpy.ops.lissom.pose_handle_add(object=posed.name, vertex_group=name)
    bpy.ops.lissom.pose_bind(object=posed.name)
    scene.empty(posed, "top").location.z += 0.25
    session.review = None
    review.leave(bpy.context) if leave else review.rest(bpy.context)
    assert review.mending is None
    after = whole_state()
    assert after[1] == others[1]
    moved = alone(target, key.name) - seen
    assert_allclose(moved[top], [0, 0, 0.25], atol=1e-4)
    assert_allclose(moved[held], 0, atol=1e-4)
    assert_allclose(scene.key_points(target, key.name) - shape, 2 * moved, atol=1e-4)
    key.vertex_group = ""
    shape_keys.write_points(key, shape)
    key.vertex_group = "mask"
    assert {**whole_state()[0], "": 0} == {**others[0], "": 0}
    if leave:
        assert state() == before


def test_a_file_saved_while_a_key_is_posed_has_the_key_and_not_the_mesh_to_pose(reviewed, tmp_path):
    review, _, target, _ = reviewed
    review.mend(bpy.context, "HANDLES")
    posed = review.mending.name
    path = tmp_path / "posing.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    with bpy.data.libraries.load(str(path)) as (there, _):
        assert posed not in there.objects and target.name in there.objects
    assert review.mending is None
    review.leave(bpy.context)


def test_leaving_while_a_key_is_open_closes_it(reviewed):
    review, _, target, before = reviewed
    review.mend(bpy.context)
    session.review = None
    review.leave(bpy.context)
    assert target.mode == "OBJECT" and state() == before


def test_a_locked_key_is_not_opened(reviewed):
    review, _, target, _ = reviewed
    target.data.shape_keys.key_blocks[review.key].lock_shape = True
    with pytest.raises(Refused, match="is locked"):
        review.mend(bpy.context)
    assert target.mode == "OBJECT"


def test_objects_in_edit_mode_and_an_empty_table_are_refused():
    source, target = monkeys()
    with pytest.raises(Refused, match="Transfer with Check Quality first"):
        Review(bpy.context, ([source], [target]))
    bpy.ops.lissom.transfer_keys()
    bpy.context.view_layer.objects.active = target
    bpy.ops.object.mode_set(mode="EDIT")
    before = state()
    with pytest.raises(Refused, match="'Target' is in edit mode"):
        Review(bpy.context, ([source], [target]))
    assert state() == before
    bpy.ops.object.mode_set(mode="OBJECT")


def test_the_tab_has_nothing_else_while_keys_are_reviewed(reviewed):
    drawn = draw(bpy.types.LISSOM_PT_transfer)
    assert set(drawn["operators"]) <= {"lissom.review", "lissom.review_mend", "lissom.quality_select"}
    assert "LISSOM_UL_quality" in drawn["classes"] and "Esc: done" in text(drawn)


def saved(path):
    """{name: (pinned, active key, mutes)} of the objects in a file."""
    with bpy.data.libraries.load(str(path), link=True) as (there, here):
        here.objects = list(there.objects)
    return {
        obj.name: (
            obj.show_only_shape_key,
            obj.active_shape_key_index,
            [key.mute for key in obj.data.shape_keys.key_blocks],
        )
        for obj in here.objects
        if obj.type == "MESH"
    }


@pytest.mark.parametrize("mending", [False, True])
def test_a_file_saved_meanwhile_keeps_no_pins(reviewed, tmp_path, mending):
    review, source, target, before = reviewed
    target.data.shape_keys.key_blocks[review.key].mute = True
    review.show(settings())
    if mending:
        review.mend(bpy.context)
    shown = (target.active_shape_key_index, target.show_only_shape_key, target.mode)
    path = tmp_path / "meanwhile.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    assert (target.active_shape_key_index, target.show_only_shape_key, target.mode) == shown
    assert not target.data.shape_keys.key_blocks[review.key].mute
    found = saved(path)
    assert found[source.name][:2] == (before[source.name][1], before[source.name][0])
    pinned, active, mutes = found[target.name]
    assert not pinned and mutes[target.data.shape_keys.key_blocks.find(review.key)]
    assert mending or active == before[target.name][0]
    review.leave(bpy.context)


def meshes():
    return sorted(obj.name for obj in bpy.data.objects if obj.type == "MESH")


def test_undo_and_redo_while_a_key_is_mended_by_handles_leave_the_review_as_it_was(reviewed):
    review, _, _, before = reviewed
    bpy.ops.ed.undo_push(message="Review")
    review.mend(bpy.context, "HANDLES")
    bpy.ops.ed.undo_push(message="Fix Key")
    bpy.ops.ed.undo()
    assert review.mending is None and meshes() == ["Source", "Target"]
    assert bpy.data.objects["Target"].active_shape_key.name == review.key
    assert settings().quality[settings().active_quality].name == review.key
    bpy.ops.ed.redo()
    assert meshes() == ["Source", "Target"], "a mesh to mend on is of the review that made it"
    session.review = None
    review.leave(bpy.context)
    assert state() == before


def test_undo_and_redo_bring_nothing_back_of_a_review_that_is_over(reviewed):
    review, _, target, _ = reviewed
    target.data.shape_keys.key_blocks[review.key].mute = True
    review.show(settings())
    bpy.ops.ed.undo_push(message="Review")
    review.mend(bpy.context, "HANDLES")
    bpy.ops.ed.undo_push(message="Fix Key")
    review.rest(bpy.context)
    bpy.ops.ed.undo_push(message="Fixed")
    session.review = None
    review.leave(bpy.context)
    for step in (bpy.ops.ed.undo, bpy.ops.ed.undo, bpy.ops.ed.redo, bpy.ops.ed.redo):
        step()
        assert meshes() == ["Source", "Target"]
        for name, pinned, place in (("Source", True, 2), ("Target", False, 0)):
            obj = bpy.data.objects[name]
            assert (obj.show_only_shape_key, obj.active_shape_key_index) == (pinned, place)
        assert bpy.data.objects["Target"].data.shape_keys.key_blocks[review.key].mute


def test_a_preview_of_what_would_be_learned_goes_with_the_undo_that_brings_it_back():
    _, target = monkeys()
    shape_keys.ensure_basis(target)
    learn_shown.start(target, {"a": scene.key_points(target, "Basis")}, settings())
    bpy.ops.ed.undo_push(message="Preview")
    learn_shown.stop()
    bpy.ops.ed.undo_push(message="Done")
    bpy.ops.ed.undo()
    target = bpy.data.objects["Target"]
    assert learn_shown.PREVIEW not in target.data.shape_keys.key_blocks
    assert not target.show_only_shape_key
