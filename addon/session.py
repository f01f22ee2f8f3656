"""What lives only in memory: native objects, the running job, and lines of text for the panels.

Nothing here refers to Blender's data: objects are known by name or session_uid, so that undo, deletion and
loading a file leave no dangling reference. All of it can be lost and made again.
"""

import contextlib

poses = {}  # session_uid of a mesh object -> core.pose.BoundPose
worlds = {}  # session_uid of a bound mesh object -> its matrix (4, 4) when it was last looked at
skins = {}  # session_uid of a bound mesh object -> core.skin.Skin that it was bound with, where it has one
stances = {}  # session_uid of a bound mesh object -> bridge.standing.stance at Bind
rebinding = {}  # name of a mesh object -> core.work.Work that binds it anew, None before it starts
status = {}  # name of a mesh object -> (icon, text) about its live pose
fit = None  # jobs.fit.Memory: the last fit
work = None  # core.work.Work that a modal operator runs now; there is at most one
edited = {}  # session_uid of a mesh object -> {name of a shape key: whether it was edited by hand}
colours = {}  # session_uid of a mesh object -> its active colour attribute before the colours of a fit
shadings = {}  # (screen, place of the area) -> shading of a 3D view before the colours of a fit
picking = None  # core.picking.Picking while markers are picked
stale = {}  # session_uid of a mesh object -> names of its arcs whose ends were changed since they were baked
review = None  # jobs.review.Review while transferred keys are looked at
views = None  # (the area that was split, the new one), by their addresses, while there are two for picking
learned = None  # jobs.learn_shown.Shown: what would be learned, while it is looked at
other_build = False  # whether the native part is of another build than the extension
history = 0  # counts undo, redo and file loading
following = True  # whether meshes follow their handles


def clear():
    """Forgets everything that belongs to a file."""
    global fit, picking, review, views, learned
    poses.clear()
    worlds.clear()
    skins.clear()
    stances.clear()
    rebinding.clear()
    status.clear()
    edited.clear()
    shadings.clear()
    colours.clear()
    stale.clear()
    fit = picking = review = views = learned = None


@contextlib.contextmanager
def paused():
    """Empties may be moved meanwhile, and no mesh follows."""
    global following
    before, following = following, False
    try:
        yield
    finally:
        following = before
