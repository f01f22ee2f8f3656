"""Source objects brought in from another file, and sent back when all is carried over."""

import bpy

from ..bridge import checks
from ..core.refused import Refused


def mesh_objects(context, names):
    """The mesh objects of these names."""
    return [checks.mesh_object(name, context) for name in names]


class Brought:
    """``objects``: mesh objects of another file, with all that comes along; without a path of this one."""

    def __init__(self, context, names, path=""):
        self._blocks = set()
        if not path:
            self.objects = mesh_objects(context, names)
            return
        before = set(bpy.data.user_map())
        with bpy.data.libraries.load(path, link=False) as (there, here):
            missing = [name for name in names if name not in there.objects]
            if missing:
                raise Refused(f"There is no object named '{missing[0]}' in '{path}'")
            here.objects = list(dict.fromkeys(names))
        found, self._blocks = list(here.objects), set(bpy.data.user_map()) - before
        for block in self._blocks:
            if isinstance(block, bpy.types.Object):  # parents and rigs say where a source is
                block.hide_viewport = False
                if block.name not in context.scene.collection.all_objects:
                    context.scene.collection.objects.link(block)
        context.view_layer.update()
        self.objects = [checks.require_mesh(obj) for obj in found]

    def send_back(self, targets):
        """Removes what was brought in; returns errors for drivers of targets that would go on reading it."""
        errors = []
        for keys in filter(None, (target.data.shape_keys for target in targets)) if self._blocks else ():
            for curve in list(keys.animation_data.drivers) if keys.animation_data else ():
                read = [goal.id for variable in curve.driver.variables for goal in variable.targets]
                lost = [block for block in read if block in self._blocks]
                if lost:
                    errors.append(
                        f"The driver of {curve.data_path} reads '{lost[0].name}' of the source's file: "
                        "left out"
                    )
                    keys.animation_data.drivers.remove(curve)
        bpy.data.batch_remove(self._blocks)
        return errors
