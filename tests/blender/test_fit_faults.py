"""The headline of a fit is what one sees, red until it is mended, with a button that shows the place."""

import bpy
import numpy as np
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge.meshes import selected_vertices
from test_panels import draw, text
from test_transfer import monkeys


def panel():
    return draw(bpy.types.LISSOM_PT_transfer)


def swapped():
    """Suzanne fitted to Suzanne with two pairs swapped, and followed all the same."""
    source, target = monkeys(every=10)
    rows = bpy.context.scene.lissom_transfer.markers
    rows[2].target, rows[30].target = rows[30].target, rows[2].target
    bpy.ops.lissom.transfer_fit(marker_tolerance=0)
    return source, target


def test_a_good_fit_has_a_check_mark_and_no_fault():
    monkeys()
    bpy.ops.lissom.transfer_fit()
    assert [fault for fault in session.fit.faults if fault.grave] == []
    drawn = panel()
    assert "CHECKMARK" in drawn["icons"] and "lissom.fit_place" not in drawn["operators"]


def test_what_is_folded_is_the_headline_and_its_place_is_shown(capfd):
    source, _ = swapped()
    fault = session.fit.faults[0]
    assert fault.kind == "folded" and fault.grave
    assert capfd.readouterr().out.rstrip().splitlines()[-1] == f"Warning: {fault.line}"
    drawn = panel()
    assert "faces are folded" in text(drawn) and "CHECKMARK" not in drawn["icons"]
    assert len(drawn["operators"]["lissom.fit_place"]) == len(session.fit.faults)
    assert bpy.ops.lissom.fit_place(place=0) == {"FINISHED"}
    assert set(selected_vertices(source)) == set(fault.vertices)
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    view = area.spaces.active.region_3d
    middle = np.mean([source.matrix_world @ source.data.vertices[v].co for v in fault.vertices], axis=0)
    assert np.linalg.norm(np.array(view.view_location) - middle) < 1.0
    bpy.ops.lissom.fit_show(show=False)


def test_a_fault_stays_until_the_next_fit_and_goes_with_it():
    swapped()
    settings = bpy.context.scene.lissom_transfer
    rows = settings.markers
    rows[2].target, rows[30].target = rows[30].target, rows[2].target
    drawn = panel()
    assert "faces are folded" in text(drawn) and "lissom.fit_place" not in drawn["operators"]
    bpy.ops.lissom.transfer_fit(marker_tolerance=0)
    assert "folded" not in text(panel())


def test_a_place_that_is_not_there_is_refused():
    swapped()
    with scene.refused("There is no fault 99"):
        bpy.ops.lissom.fit_place(place=99)
