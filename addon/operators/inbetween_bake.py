"""In-betweens as shape keys under one slider.

The baked keys are the path at the knots, each relative to the key the path starts from, and each driven by
its hat function h_i of the slider t. Blender then adds sum_i h_i(t) (P_i - P_0) to what the other keys show:
with the start key on, that is the path from P_0 to P_n, straight between the knots; P_0 needs no key. P_0
and P_n are what the artist sees with the start or the end key on, whatever key they are relative to.
"""

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ..bridge import checks, meshes, shape_keys, sliders
from ..core import hat, names, space
from ..core.inbetween import path_work
from ..core.refused import Refused, first
from ..properties.inbetween import ROTATION_ITEMS
from ..properties.transfer import exists_property
from .job import JobOperator, answering, writable_mesh
from .pose_handles import OBJECT


class LISSOM_OT_inbetween_bake(JobOperator, bpy.types.Operator):
    """Bake the arc between two shape keys as shape keys under one slider"""

    bl_idname = "lissom.inbetween_bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    start: StringProperty(
        name="From", description="Shape key that the arc starts at; empty: the Basis", options={"SKIP_SAVE"}
    )
    end: StringProperty(name="To", description="Shape key that the arc ends at", options={"SKIP_SAVE"})
    count: IntProperty(
        name="In-betweens", description="Shape keys between the two", default=5, min=1, max=100
    )
    rotation: EnumProperty(
        name="Rotation",
        description="How the turn of every face is chosen",
        items=ROTATION_ITEMS,
        default="consistent",
    )
    slider: StringProperty(
        name="Slider",
        description="Name of the slider and of the baked keys; empty: named after the key it leads to",
        options={"SKIP_SAVE"},
    )
    exists: exists_property("UPDATE")
    prepare_keys: BoolProperty(
        name="Prepare Keys",
        description="Set the start key to 1 and the end key to 0, so that the slider alone plays from one to "
        "the other. Driven or locked keys are left as they are",
        default=True,
    )

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context)

    def begin(self, context):
        obj = checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        if not self.end:
            raise Refused("Choose the shape key that the arc leads to first")
        end = shape_keys.find(obj, self.end)
        start = shape_keys.find(obj, self.start) if self.start else obj.data.shape_keys.reference_key
        for key in (start, end):
            shape_keys.refuse_preview(key)
        if start == end:
            raise Refused("From and To are the same shape key: choose two")
        self._start, self._end = start.name, end.name
        wanted = self.slider or names.shorten(end.name, " arc")
        sliders.check_name(obj, wanted)
        self._slider = names.resolve(wanted, set(obj.keys()), self.exists)
        if self._slider is None:
            raise Refused(f"Slider '{wanted}' exists, and If Exists is Skip: choose another name")
        if self._slider in obj and self._slider not in obj.lissom_inbetween.arcs:
            raise Refused(
                f"'{self._slider}' is a custom property of another kind: choose another name for the slider"
            )
        old = sliders.baked_keys(obj, self._slider)
        if {self._start, self._end} & set(old):
            raise Refused(
                f"From and To must not be keys of slider '{self._slider}' itself: choose another slider"
            )
        checks.require_unlocked([shape_keys.find(obj, name) for name in old])
        self._knots = hat.uniform_knots(self.count)[1:]
        linear = space.linear_part(obj.matrix_world, obj.name)
        self._mesh = mesh = meshes.Snapshot.of(obj, linear)
        first_shape, last_shape = shape_keys.seen(start), shape_keys.seen(end)
        if end.relative_key == start:  # then the end is seen on top of the start
            last_shape = first_shape + (shape_keys.shape(end) - shape_keys.shape(start))
        self._offset = shape_keys.shape(start) - first_shape
        return path_work(
            mesh.geometry(),
            space.into(linear, first_shape),
            space.into(linear, last_shape),
            self._knots,
            {"rotation": self.rotation},
        )

    def finish(self, context, result):
        shapes, warnings = result
        obj = self._mesh.find()
        checks.require_writable(obj)
        start = shape_keys.find(obj, self._start)
        end = shape_keys.find(obj, self._end)
        value = obj.get(self._slider)
        value = float(value) if isinstance(value, (int, float)) else 0.0
        remove_arc(obj, self._slider)
        description = f"Lissom: from '{self._start}' at 0 along an arc to '{self._end}' at 1"
        sliders.add(obj, self._slider, description, value)
        arc = obj.lissom_inbetween.arcs.add()
        arc.name, arc.start, arc.end = self._slider, self._start, self._end
        taken = set(obj.data.shape_keys.key_blocks.keys())
        knots = [0.0, *self._knots]
        for index, shape in enumerate(shapes, start=1):
            name = names.unused(names.shorten(self._slider, f" {100 * knots[index]:.0f}%"), taken)
            taken.add(name)
            settings = shape_keys.Settings(vertex_group=end.vertex_group)
            positions = space.back(self._mesh.linear, shape) + self._offset
            key = shape_keys.write(obj, name, positions, settings, start)
            sliders.drive(key, obj, self._slider, knots, index)
            arc.keys.add().name = key.name
        if self.prepare_keys:
            self._prepare(obj, start, end)
        for warning in filter(None, [*warnings, checks.shared_data(obj)]):
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, f"{len(shapes)} shape keys under the slider '{self._slider}'")

    def _prepare(self, obj, start, end):
        for key, value in ((start, 1.0), (end, 0.0)):
            if key == obj.data.shape_keys.reference_key:
                continue
            if key.lock_shape or shape_keys.is_driven(key):
                self.report(
                    {"WARNING"}, f"Shape key '{key.name}' is driven or locked: set it to {value:.0f} yourself"
                )
            else:
                key.value = value


class LISSOM_OT_inbetween_remove(bpy.types.Operator):
    """Remove a slider and the shape keys that were baked for it"""

    bl_idname = "lissom.inbetween_remove"
    bl_label = "Remove Arc"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    slider: StringProperty(name="Slider", description="Name of the slider", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context)

    @answering
    def execute(self, context):
        obj = checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        if self.slider not in obj.lissom_inbetween.arcs:
            raise Refused(f"'{obj.name}' has no arc with a slider named '{self.slider}'")
        checks.require_unlocked([shape_keys.find(obj, name) for name in sliders.baked_keys(obj, self.slider)])
        remove_arc(obj, self.slider)
        orphans = sliders.driven_keys(obj, self.slider)
        if orphans:
            listed = first(repr(name) for name in orphans)
            self.report({"WARNING"}, f"The driver of shape key {listed} has lost its slider '{self.slider}'")


def remove_arc(obj, slider):
    """Removes the slider with the keys that were baked for it, where there are any."""
    arcs = obj.lissom_inbetween.arcs
    if slider not in arcs:
        return
    for name in sliders.baked_keys(obj, slider):
        shape_keys.remove(obj, name)
    if slider in obj:
        del obj[slider]
    arcs.remove(arcs.find(slider))


classes = (LISSOM_OT_inbetween_bake, LISSOM_OT_inbetween_remove)
