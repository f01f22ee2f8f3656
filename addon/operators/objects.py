"""The mesh objects, and their keys, that operators are told by name."""

from bpy.props import StringProperty

from .job import writable_mesh

OBJECT = {
    "name": "Object",
    "description": "Name of the mesh object; empty: the active one",
    "options": {"SKIP_SAVE"},
}
KEYS = {
    "name": "Keys",
    "description": "Names of the shape keys, one a line; empty: the active one",
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
