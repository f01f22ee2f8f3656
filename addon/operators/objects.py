"""The mesh objects that operators are told by name."""

from bpy.props import StringProperty

from ..bridge import checks
from ..core.refused import Refused
from .job import writable_mesh

OBJECT = {
    "name": "Object",
    "description": "Name of the mesh object; empty: the active one",
    "options": {"SKIP_SAVE"},
}
SOURCE = {
    "name": "Source",
    "description": "Name of the source object, with further ones, one a line; empty: the scene's",
    "options": {"SKIP_SAVE"},
}
TARGET = {
    "name": "Target",
    "description": "Name of the target object, with further ones, one a line; empty: the scene's",
    "options": {"SKIP_SAVE"},
}


class BoundObject:
    """Mixin: an operator on a mesh object that is bound."""

    object: StringProperty(**OBJECT)

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context, bound=True)


def unbound_object(name, context):
    """The mesh object of that name, or the active one; Refused where it is bound or not to be written to."""
    obj = checks.mesh_object(name, context)
    if obj.mode != "EDIT":
        checks.require_writable(obj)
    if obj.lissom_pose.bound:
        raise Refused(f"'{obj.name}' is bound: press Unbind first, then change its handles")
    return obj
