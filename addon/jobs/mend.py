"""A shape key mended by handles: posed on a mesh of its own, so that nothing else is touched."""

import bpy
import numpy as np

from ..bridge import checks, groups, poses, shape_keys, views
from ..core.refused import Refused
from . import bound
from .pose import Solve, SolveAsked, release

TOOL = "lissom.pose_tool"
FAINT = 0.01  # a mask that lets through less hides what is posed there


class ByHandles:
    """A key of an object as a mesh that one can pose; ``keep`` adds what was posed to the key.

    The copy has the key's shape for its rest shape, and the object's modifiers, parent and constraints, so
    that it stands where the object does. In a Local View it takes the object's place.
    """

    def __init__(self, context, obj, key, view=None):
        """``key`` of ``obj``; ``view`` is the address of the 3D view that shows the object alone, or None."""
        shape = shape_keys.seen(obj, key)
        made = obj.copy()
        made.data = obj.data.copy()
        made.lissom_shown.on, made.lissom_shown.mends = False, True
        made.name = f"Fix {key.name}"
        for collection in obj.users_collection:
            collection.objects.link(made)
        _bare(made)
        shape_keys.clear(made)
        shape_keys.ensure_basis(made)
        shape_keys.write_points(made.data.shape_keys.reference_key, shape)
        self._obj, self._key, self._made, self._view = obj.name, key.name, made.name, view
        self._tool = views.tool(context)
        views.swap(view, obj, made)
        views.take_tool(context, view, TOOL)
        for other in context.selected_objects:
            other.select_set(False)
        made.select_set(True)
        context.view_layer.objects.active = made
        context.view_layer.update()

    def find(self):
        """The mesh to pose, or None where it was deleted, or undone."""
        return bpy.data.objects.get(self._made)

    def keep(self, context):
        """Adds what was posed to the key, and takes the mesh to pose away."""
        made, obj = self.find(), bpy.data.objects.get(self._obj)
        if made is None:
            return
        try:
            if made.lissom_pose.bound and obj is not None:
                self._add(obj, shape_keys.find(obj, self._key), self._posed(context, made))
        finally:
            remove(made)
            self.give_back(context)

    def give_back(self, context):
        """The view shows the object again, with the tool that it had."""
        views.take_tool(context, self._view, self._tool)
        obj = bpy.data.objects.get(self._obj)
        if obj is not None:
            views.swap(self._view, None, obj)
            context.view_layer.objects.active = obj

    def _posed(self, context, made):
        """(n, 3): how far the handles have moved the vertices, solved to the end."""
        solve = Solve(context, SolveAsked(object=made.name))
        solve.write(context, solve.work.wait())
        keys = made.data.shape_keys
        return shape_keys.shape(poses.preview(made)) - shape_keys.shape(keys.reference_key)

    def _add(self, obj, key, moved):
        checks.require_unlocked([key])
        if len(moved) != len(key.points):
            raise Refused(f"'{obj.name}' was remodelled meanwhile: key '{key.name}' is as it was")
        if key.vertex_group in obj.vertex_groups:  # what is seen is so much of what the key has
            mask = groups.weights(obj, key.vertex_group)[:, None]
            moved = np.divide(moved, mask, out=np.zeros_like(moved), where=mask > FAINT)
        shape_keys.write(obj, key.name, shape_keys.shape(key) + moved, relative=key.relative_key)


def _bare(made):
    """Takes what the extension keeps with an object off a copy of it."""
    pose = made.lissom_pose
    for rows in (pose.handles, pose.company, pose.baked, made.lissom_inbetween.arcs, made.lissom_landmarks):
        rows.clear()
    for name in ("bound", "preview", "applied", "roi", "warnings", "baked_cache", "stands", "stood"):
        pose.property_unset(name)


def remove(made):
    """Takes a mesh to pose away, and its Empties."""
    if made.lissom_pose.bound:
        release(made)
    bound.forget(made)
    for empty in [obj for obj in bpy.data.objects if obj.lissom_handle_of == made]:
        bpy.data.objects.remove(empty)
    shape_keys.clear(made)  # these outlive a mesh that is removed
    bpy.data.meshes.remove(made.data)  # and the object with it
