"""Source and target from the selection, and swapped."""

import bpy
import pytest
import scene


def select(*objects):
    for obj in bpy.data.objects:
        obj.select_set(obj in objects)
    bpy.context.view_layer.objects.active = objects[-1] if objects else None


def test_the_last_selected_is_the_target():
    one, other = scene.tube(name="One"), scene.tube(name="Other")
    settings = bpy.context.scene.lissom_transfer
    for source, target in ((one, other), (other, one)):
        select(source, target)
        bpy.ops.lissom.transfer_sides()
        assert (settings.source, settings.target) == (source, target)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_any_other_selection_is_refused(count):
    select(*[scene.tube(name=f"T{i}") for i in range(count)])
    with scene.refused("Select the mesh that has the shape keys"):
        bpy.ops.lissom.transfer_sides()
    assert bpy.context.scene.lissom_transfer.source is None


def test_a_swap_takes_everything_along_and_swapped_twice_is_as_before():
    objects = [scene.tube(name=name) for name in ("Face", "Head", "Eyes", "Teeth")]
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = objects[:2]
    settings.source_parts.add().object = objects[2]
    settings.source_mask, settings.target_mask = "inside", ""
    bpy.ops.lissom.marker_add(source_vertex=3, target_vertex=8)
    bpy.ops.lissom.marker_add(source_vertex=5, target_vertex=21)

    def state():
        return (
            settings.source,
            settings.target,
            [row.object for row in settings.source_parts],
            [row.object for row in settings.target_parts],
            [row.ends for row in settings.markers],
            [(row.place("source"), row.place("target")) for row in settings.markers],
            (settings.source_mask, settings.target_mask),
            (settings.source_edges, settings.target_edges),
        )

    before = state()
    bpy.ops.lissom.transfer_sides(swap=True)
    assert state() == tuple(
        entry
        for pair in (
            (before[1], before[0]),
            (before[3], before[2]),
            ([ends[::-1] for ends in before[4]], [places[::-1] for places in before[5]]),
            (before[6][::-1], before[7][::-1]),
        )
        for entry in pair
    )
    bpy.ops.lissom.transfer_sides(swap=True)
    assert state() == before
