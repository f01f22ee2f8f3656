"""A function that draws over the 3D views while it is registered."""

import bpy


class Drawn:
    """``draw()`` is called for every 3D view: "POST_VIEW" draws in the world, "POST_PIXEL" in pixels."""

    def __init__(self, draw, when):
        self._draw, self._when, self._handle = draw, when, None

    def register(self):
        """Begins to draw."""
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", self._when)

    def unregister(self):
        """Draws no more."""
        bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
        self._handle = None
