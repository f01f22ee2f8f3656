"""The panels are drawn onto a layout that checks every call against this Blender's own UILayout."""

import importlib
import types

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.core.pose_options import METHODS, by_name, options_of
from bl_ext.user_default.lissom.core.quality import ORDERS
from bl_ext.user_default.lissom.core.work import Work
from bl_ext.user_default.lissom.properties.inbetween import SETTINGS
from test_transfer import monkeys

FUNCTIONS = bpy.types.UILayout.bl_rna.functions
ICONS = {item.identifier for item in FUNCTIONS["label"].parameters["icon"].enum_items}
LAYOUTS = {"row", "column", "box", "split", "grid_flow"}


class Operator:
    """The properties that a panel sets on a button."""

    def __init__(self, idname, drawn):
        module, name = idname.split(".")
        self.__dict__["kind"] = getattr(getattr(bpy.ops, module), name).get_rna_type()
        self.__dict__["set"] = drawn.setdefault(idname, [])
        self.set.append({})

    def __setattr__(self, name, value):
        assert name in self.kind.properties, f"{self.kind.identifier} has no {name}"
        self.set[-1][name] = value


class Layout:
    """Takes what UILayout takes, and remembers labels and buttons."""

    def __init__(self, drawn):
        self._drawn = drawn

    def context_pointer_set(self, name, data):
        self._drawn["pointers"][name] = data

    def __getattr__(self, name):
        function = FUNCTIONS[name]
        parameters = [p.identifier for p in function.parameters if not p.is_output]

        def call(*positional, **named):
            assert len(positional) <= len(parameters), name
            given = dict(zip(parameters, positional, strict=False)) | named
            required = {p.identifier for p in function.parameters if p.is_required and not p.is_output}
            assert set(given) <= set(parameters), f"{name} takes no {set(given) - set(parameters)}"
            assert required <= set(given), f"{name} needs {required - set(given)}"
            assert given.get("icon", "NONE") in ICONS, given["icon"]
            return self._answer(name, given)

        return call

    def _answer(self, name, given):
        if name in LAYOUTS:
            return Layout(self._drawn)
        if name == "panel":  # header and body, which is None while it is closed
            return Layout(self._drawn), None if self._drawn["closed"] else Layout(self._drawn)
        if name == "operator":
            return Operator(given["operator"], self._drawn["operators"])
        if name in ("prop", "prop_enum", "prop_search") and not given["property"].startswith("["):
            assert given["property"] in given["data"].bl_rna.properties, given["property"]
            self._drawn["settings"].append(given["property"])
        if name == "prop_search":
            assert given["search_property"] in given["search_data"].bl_rna.properties
        if name in ("menu", "template_list"):
            self._drawn["classes"].append(given.get("menu") or given["listtype_name"])
        self._drawn["icons"].append(given.get("icon", "NONE"))
        if given.get("text"):
            self._drawn["labels"].append(given["text"])
        return None


def nothing_drawn(closed=False):
    return {
        "labels": [],
        "icons": [],
        "operators": {},
        "classes": [],
        "pointers": {},
        "settings": [],
        "closed": closed,
    }


def draw(cls, *arguments, closed=False):
    """Draws a panel, a menu or a list's row; returns what was drawn. ``closed``: with subpanels closed."""
    drawn = nothing_drawn(closed)
    layout = Layout(drawn)
    own = [*(base for base in reversed(cls.__mro__[1:]) if base.__module__.startswith("bl_ext")), cls]
    members = {name: member for base in own for name, member in vars(base).items()}
    members = {name: one for name, one in members.items() if isinstance(one, types.FunctionType | str)}
    stub = type("Stub", (), members)()
    stub.layout = layout
    if arguments:
        stub.draw_item(bpy.context, layout, *arguments)
    else:
        stub.draw(bpy.context)
    for name in drawn["classes"]:
        assert hasattr(bpy.types, name), name
    return drawn


@pytest.fixture
def panels():
    return {name: getattr(bpy.types, f"LISSOM_PT_{name}") for name in ("pose", "transfer", "inbetween")}


def text(drawn):
    return " ".join(drawn["labels"])


def test_an_empty_scene_says_what_to_do(panels):
    assert "Select a mesh object" in text(draw(panels["pose"]))
    assert "Select a mesh object" in text(draw(panels["inbetween"]))
    offered = set(draw(panels["transfer"])["operators"])
    assert offered == {"lissom.face_keys", "lissom.transfer_parts", "lissom.transfer_sides"}


def test_pose_before_and_after_bind(panels):
    obj = scene.bound_tube()
    bound = draw(panels["pose"])
    assert bound["pointers"]["lissom_object"] == obj
    applied = {"object": "Tube", "name": "Pose"}
    assert bound["operators"]["lissom.pose_apply"] == [applied, applied | {"value": 0.0}]
    assert "lissom.pose_bind" not in bound["operators"]
    bpy.ops.lissom.pose_unbind(object="Tube")
    free = draw(panels["pose"])
    assert free["operators"]["lissom.pose_bind"] == [
        {
            "object": "Tube",
            "method": "arap",
            "use_weights": False,
            "weld": False,
            "stays": "FAR",
            "reach": 0.0,
            "symmetry": "OFF",
            "stands": True,
            "cells": "spokes_and_rims",
            "rotation_smoothing": 0.001,
            "smoothness": 0.0,
            "solid": False,
            "constraints": "hard",
            "weight": 1.0,
            "preserve_volume": False,
            "unheld": "follow",
        }
    ]
    assert "lissom.pose_apply" not in free["operators"]


BASES = [name for name, _, _ in METHODS if name != "multiresolution"]


@pytest.mark.parametrize(
    ("method", "base"), [(name, "poisson") for name in BASES] + [("multiresolution", base) for base in BASES]
)
def test_the_options_are_those_of_the_chosen_method_and_no_others(panels, method, base):
    settings = scene.tube().lissom_pose
    settings.method, settings.options.multiresolution.base = method, base
    drawn = draw(panels["pose"])
    wanted = options_of(method, base)
    shown = [name for (_, name), option in wanted.items() if not option.when]
    assert [name for name in drawn["settings"] if name in by_name()] == shown
    assert not any(name in by_name() for name in draw(panels["pose"], closed=True)["settings"])
    (given,) = drawn["operators"]["lissom.pose_bind"]
    own = {"use_weights": False, "weld": False, "stays": "FAR", "reach": 0.0, "symmetry": "OFF"}
    own["stands"] = True
    assert given == {"object": "Tube", "method": method} | own | {
        name: option.default for (_, name), option in wanted.items()
    } | ({"base": base} if method == "multiresolution" else {})
    (line,) = (line for name, _, line in METHODS if name == method)
    assert line in text(drawn)


def test_an_option_is_shown_when_the_one_it_needs_is_chosen(panels):
    settings = scene.tube().lissom_pose
    settings.method = "rotation_invariant"
    for group, needed, choice, name in (
        (settings.options.common, "constraints", "soft", "weight"),
        (settings.options.rotation_invariant, "interpolation", "matrix", "project"),
    ):
        assert name not in draw(panels["pose"])["settings"]
        setattr(group, needed, choice)
        assert name in draw(panels["pose"])["settings"]


def test_the_redo_panel_shows_the_options_of_the_method():
    operator = types.SimpleNamespace(
        bl_rna=bpy.ops.lissom.pose_bind.get_rna_type(),
        layout=Layout(drawn := nothing_drawn()),
        method="thin_shell",
        base="poisson",
        constraints="hard",
    )
    bpy.types.LISSOM_OT_pose_bind.draw(operator, bpy.context)
    shown = ["method", "k_s", "k_b", "border", "constraints", "preserve_volume", "unheld"]
    assert drawn["settings"] == [*shown, "use_weights", "weld", "stays", "reach", "symmetry", "stands"]


def test_one_handle_alone_is_asked_what_stays(panels):
    obj = scene.tube()
    settings = obj.lissom_pose
    for number, name in enumerate(("top", "bottom", "region")):
        scene.group(obj, name, lambda co, number=number: co.z > 2.5 - number)
        if name != "region":
            bpy.ops.lissom.pose_handle_add(object="Tube", vertex_group=name)
        assert ("What stays?" in text(draw(panels["pose"]))) == (number == 0)
    bpy.ops.lissom.pose_handle_remove(object="Tube", handle="bottom")
    drawn = draw(panels["pose"])
    assert "stays" in drawn["settings"] and "reach" in drawn["settings"]
    settings.stays = "NOTHING"
    assert "reach" not in draw(panels["pose"])["settings"]
    settings.roi = "region"
    assert "stays" not in draw(panels["pose"])["settings"]


def test_pose_of_an_active_handle_is_that_of_its_mesh(panels):
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_handle_select(object="Tube", handle="top")
    assert draw(panels["pose"])["pointers"]["lissom_object"] == obj


def test_rows_of_handles_tell_what_is_lost():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_handle_select(object="Tube", handle="top")
    bpy.ops.object.delete()
    obj.vertex_groups["bottom"].name = "feet"
    handles = obj.lissom_pose.handles
    rows = [draw(bpy.types.LISSOM_UL_handles, None, item, 0, None, "") for item in handles]
    assert [text(row) for row in rows] == ["bottom (no such group)", "top (Empty deleted)"]


def test_the_menu_offers_groups_that_are_no_handles_yet():
    obj = scene.bound_tube()
    scene.group(obj, "middle", lambda co: abs(co.z) < 0.5)
    offered = draw(bpy.types.LISSOM_MT_handle_add)["operators"]["lissom.pose_handle_add"]
    assert offered == [{"object": "Tube"}, {"object": "Tube", "vertex_group": "middle"}]


def test_a_reason_against_writing_is_shown(panels):
    obj = scene.tube()
    scene.add_key(obj, "K", scene.points(obj.data.vertices))
    obj.data.shape_keys.use_relative = False
    for name in ("pose", "inbetween"):
        assert "turn on Relative" in text(draw(panels[name]))


def test_transfer_passes_its_settings_on(panels):
    source, target = scene.tube(name="Source"), scene.tube(name="Target")
    scene.add_key(source, "K", scene.points(source.data.vertices))
    settings = bpy.context.scene.lissom_transfer
    drawn = text(draw(panels["transfer"]))
    assert "Choose the mesh that has shape keys" in drawn and "Press Pick" not in drawn
    settings.source, settings.target = source, target
    assert "no markers are needed" in text(draw(panels["transfer"]))
    bpy.ops.lissom.transfer_fit()
    drawn = draw(panels["transfer"])
    assert "Fit: " in text(drawn) and "% sure" not in text(drawn)
    settings.target = target = scene.tube(name="Finer", rings=61)
    drawn = draw(panels["transfer"])
    assert "Press Pick" in text(drawn) and "No markers: found by shape" in text(drawn)
    assert "marker_tolerance" not in drawn["settings"]
    for vertex in range(3):
        bpy.ops.lissom.marker_add(source_vertex=vertex, target_vertex=vertex)
    settings.which, settings.exists = "SELECTED", "SKIP"
    bpy.ops.lissom.transfer_choose(action="ALL")
    drawn = draw(panels["transfer"])
    (given,) = drawn["operators"]["lissom.transfer_keys"]
    assert (given["keys"], given["exists"]) == ("K", "SKIP")
    assert "Press Pick" not in text(drawn) and "found by shape" not in text(drawn)
    assert "marker_tolerance" in drawn["settings"] and "source_points" not in drawn["settings"]
    assert "LISSOM_UL_keys" in drawn["classes"]
    bpy.ops.lissom.transfer_fit()
    assert "Fit: " in text(draw(panels["transfer"]))
    bpy.ops.lissom.marker_add(source_vertex=99, target_vertex=99)
    assert "changed since the last fit" in text(draw(panels["transfer"]))


def test_one_button_transfers_what_is_chosen(panels):
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = scene.tube(name="Source"), scene.tube(name="Target")
    settings.pose_name, settings.exists, settings.contact = "Open", "RENAME", True
    settings.bake_step, settings.bake_path, settings.match_distance = 3, "/a.pc2", 0.03
    shared = {"match_distance": settings.match_distance, "closest": settings.closest}
    shared |= {"marker_tolerance": settings.marker_tolerance, "overlap": False}
    shared |= {"source_mask": "", "target_mask": ""}
    dressed = {"vertex_groups": True, "uv_maps": False, "colours": True, "exists": "RENAME"}
    settings.uv_maps = False
    attributes = ("attributes", shared | dressed)
    shared |= {"unmatched": "follow", "scale": "target", "contact": True, "stretch": 3.0, "name": "Open"}
    wanted = {
        "POSE": ("pose", shared | {"exists": "RENAME", "edited": "KEEP"}),
        "ANIMATION": ("animation", shared | {"step": 3, "output": "KEYS", "cache_path": "/a.pc2"}),
        "ATTRIBUTES": attributes,
    }
    for what, (operator, properties) in wanted.items():
        settings.what = what
        drawn = draw(panels["transfer"])
        assert drawn["operators"][f"lissom.transfer_{operator}"] == [properties]
        assert (
            sum(name.startswith("lissom.transfer_") for name in drawn["operators"]) == 4
        )  # fit, parts and sides too
        assert "drivers" not in drawn["settings"]
    settings.what = "ANIMATION"
    drawn = draw(panels["transfer"])
    assert "bake_path" not in drawn["settings"] and "frame_start" in drawn["settings"]
    settings.bake_output = "CACHE"
    assert "bake_path" in draw(panels["transfer"])["settings"]


def test_rows_of_markers_and_keys():
    source = scene.tube(name="Source")
    key = scene.add_key(source, "K", scene.points(source.data.vertices))
    settings = bpy.context.scene.lissom_transfer
    settings.markers.add().name = "nose"
    row = draw(bpy.types.LISSOM_UL_markers, settings, settings.markers[0], 0, settings, "active_marker", 0)
    assert row["settings"] == ["name"]
    row = draw(bpy.types.LISSOM_UL_keys, source.data.shape_keys, key, 0, source, "active_shape_key_index")
    assert row["operators"]["lissom.transfer_choose"] == [{"action": "TOGGLE", "key": "K"}]
    assert "lissom.marker_load" in draw(bpy.types.LISSOM_MT_markers)["operators"]


def marked_rows():
    """The rows of the list of markers that bear a sign."""
    settings = bpy.context.scene.lissom_transfer
    kind = bpy.types.LISSOM_UL_markers
    rows = [draw(kind, settings, row, 0, settings, "", place) for place, row in enumerate(settings.markers)]
    return [place for place, row in enumerate(rows) if "ERROR" in row["icons"]]


def test_a_marker_out_of_place_is_marked_until_it_is_corrected(panels, capfd):
    _, target = monkeys()
    settings = bpy.context.scene.lissom_transfer
    wrong = settings.markers[5]
    right, taken = wrong.target, {row.target for row in settings.markers}
    points = scene.points(target.data.vertices)
    away = np.argsort(-np.linalg.norm(points - points[right], axis=1)).tolist()
    wrong.name, wrong.target = "nose", next(vertex for vertex in away if vertex not in taken)
    assert marked_rows() == []
    bpy.ops.lissom.transfer_fit()
    assert session.fit.fit.doubtful_markers.tolist() == marked_rows() == [5]
    assert "marker 6, 'nose', is" in capfd.readouterr().out
    settings.active_marker = 5
    assert "This pair is" in text(draw(panels["transfer"]))
    settings.active_marker = 4
    assert "This pair is" not in text(draw(panels["transfer"]))
    bpy.ops.lissom.marker_remove(index=0)
    assert marked_rows() == [4]
    settings.markers[4].target = right
    assert marked_rows() == []
    bpy.ops.lissom.transfer_fit()
    assert marked_rows() == []


def test_the_region_that_is_off_is_named(panels):
    source, _ = monkeys()
    bpy.ops.lissom.transfer_fit()
    assert "Least sure" not in text(draw(panels["transfer"]))
    lump = scene.points(source.data.vertices)
    lump[lump[:, 2] > 0.6, 2] += 1.0
    source.data.shape_keys.reference_key.points.foreach_set("co", lump.astype(np.float32).ravel())
    bpy.ops.lissom.transfer_fit(overlap=True, match_distance=1.0)
    bpy.context.scene.lissom_transfer.overlap = True
    assert "Least sure at the top" in text(draw(panels["transfer"]))


def test_how_sure_a_fit_without_markers_is(panels):
    monkeys()
    bpy.ops.lissom.transfer_fit()
    assert "% sure" not in text(draw(panels["transfer"]))
    bpy.ops.lissom.marker_clear()
    bpy.ops.lissom.transfer_fit()
    sure = min(99, round(100 * session.fit.fit.report["certainty"]))
    assert f"{sure} % sure how the meshes lie" in text(draw(panels["transfer"]))


ARC = ("start", "end", "slider", *SETTINGS)


def test_the_table_of_quality_tells_verdicts_and_reasons(panels, monkeypatch):
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = scene.tube(name="Source"), scene.tube(name="Target")
    for name, verdict, reasons in (
        ("a", "good", ""),
        ("b", "bad", "closes only 60 % of the way\n1 triangle torn"),
    ):
        row = settings.quality.add()
        row.name, row.verdict, row.reasons = name, verdict, reasons
    row.faces = '{"Target": [3]}'
    drawn = draw(panels["transfer"])
    assert "LISSOM_UL_quality" in drawn["classes"] and "lissom.quality_select" not in drawn["operators"]
    settings.active_quality = 1
    drawn = draw(panels["transfer"])
    assert drawn["operators"]["lissom.quality_select"] == [{"key": "b"}]
    assert "Closes only 60 % of the way" in text(drawn) and "1 triangle torn" in text(drawn)
    kind = bpy.types.LISSOM_UL_quality
    for order in ORDERS:
        settings.quality_order = order
        for row in settings.quality:
            assert draw(kind, settings, row, 0, None, "")["labels"][0] == row.name
    settings.quality_order = "amplitude"
    common = importlib.import_module("bl_ext.user_default.lissom.panels.common")
    monkeypatch.setattr(common, "_width", lambda text: 7 * len(text))  # Blender as a module has no font
    monkeypatch.setattr(common, "_scale", lambda: 1.0)
    assert draw(kind, settings, row, 0, None, "")["labels"][1].endswith("as far")
    row.name = 20 * "long"  # beside it there is no room: below the table, for the active row
    assert draw(kind, settings, row, 0, None, "")["labels"] == [row.name]
    assert "0 % as far" in text(draw(panels["transfer"]))


def test_inbetween_passes_its_settings_on_and_shows_sliders(panels):
    obj = scene.tube()
    assert "no shape keys yet" in text(draw(panels["inbetween"]))
    scene.add_key(obj, "K", scene.points(obj.data.vertices) * [1, 1, 2])
    obj.lissom_inbetween.end = "K"
    (given,) = draw(panels["inbetween"])["operators"]["lissom.inbetween_bake"]
    settings = obj.lissom_inbetween
    assert given == {"object": "Tube"} | {name: getattr(settings, name) for name in ARC}
    bpy.ops.lissom.inbetween_bake(**given)
    drawn = draw(panels["inbetween"])
    assert "K arc" in drawn["labels"]
    for action in ("rebake", "rename", "remove"):
        given = drawn["operators"][f"lissom.inbetween_{action}"]
        assert given == [{"object": "Tube", "slider": "K arc"}]


def test_names_have_the_room_that_they_need(monkeypatch):
    common = importlib.import_module("bl_ext.user_default.lissom.panels.common")
    monkeypatch.setattr(common, "_width", lambda text: 7 * len(text))  # Blender as a module has no font
    monkeypatch.setattr(common, "_scale", lambda: 1.0)
    name, room = "mouthSmileLeft", common._room(0)
    row = common._room(30)
    assert 7 * len(name) + 34 <= common.name_part(name, 34, 30) * row < row
    assert common.name_part(5 * name, 34, 30) == 0.85  # what is measured stays in sight
    layout = types.SimpleNamespace(row=lambda **_: "row", column=lambda **_: "column")
    assert common.side_by_side(layout, "Apply", "And Next") == "row"
    assert common.side_by_side(layout, "Show Fit", "Suggest Marker") == "column"
    parts = [part for _, part in common.shares(["Pose", "Transfer", "In-between"])]
    assert parts[0] < 1 / 3 < parts[1] < 1 / 2 and parts[2] == 1.0
    assert common.fits(name, 0) and not common.fits(5 * name, 0) and not common.fits(name, room - 50)


def test_several_arcs_are_ticked_and_baked_by_one_button(panels):
    obj = scene.tube()
    for name in ("half", "full"):
        scene.add_key(obj, name, scene.points(obj.data.vertices))
    obj.lissom_inbetween.several = True
    bpy.ops.lissom.inbetween_choose(object="Tube", action="TOGGLE", key="full")
    drawn = draw(panels["inbetween"])
    assert "LISSOM_UL_arc_keys" in drawn["classes"] and "lissom.inbetween_bake" not in drawn["operators"]
    assert drawn["operators"]["lissom.inbetween_bake_all"][0]["keys"] == "full"
    bpy.ops.lissom.inbetween_bake_all(object="Tube", keys="full", count=1)
    session.stale[obj.session_uid] = ["full arc"]
    drawn = draw(panels["inbetween"])
    assert "Out of date" in text(drawn) and "lissom.inbetween_update_all" in drawn["operators"]


def test_work_is_shown_on_top_in_place_of_the_pages(monkeypatch):
    scene.bound_tube()

    def steps():
        yield scene.Pause(0.5, "halfway")

    main = bpy.types.LISSOM_PT_main
    assert draw(main)["settings"] == 3 * ["lissom_page"]
    monkeypatch.setattr(session, "work", Work(steps()))
    drawn = draw(main)
    assert "halfway (ESC cancels)" in text(drawn) and not drawn["settings"]
    with scene.refused("Lissom is at work"):
        bpy.ops.lissom.pose_unbind(object="Tube")
