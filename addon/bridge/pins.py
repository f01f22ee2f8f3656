"""A shape key shown alone for a while, and what the object showed before.

What was before lies on the object, and so undo, redo and files know it too: whatever they bring back, it can
be given back. A key is shown by pinning it (Solo Active Shape Key): whatever its value, its drivers and those
of the others are, it alone is seen, at 1, and there is no value to give back. A muted key is heard meanwhile.
"""


def remember(obj):
    """Remembers what an object shows, unless it was told to already."""
    before = obj.lissom_shown
    if not before.on:
        before.on, before.place, before.pinned = True, obj.active_shape_key_index, obj.show_only_shape_key


def show(obj, place):
    """Shows the key at a place in the list of an object alone, at 0 the Basis."""
    before, keys = obj.lissom_shown, obj.data.shape_keys
    remember(obj)
    _mute(obj)
    obj.active_shape_key_index = place
    obj.show_only_shape_key = True
    if place > 0 and keys.key_blocks[place].mute:  # pinned, it would show the Basis
        keys.key_blocks[place].mute = False
        before.heard = keys.key_blocks[place].name


def lift(obj):
    """Shows what was before, until ``show`` is called again; what is being edited stays the active key."""
    before = obj.lissom_shown
    if before.on:
        _mute(obj)
        obj.show_only_shape_key = before.pinned
        if obj.mode == "OBJECT":
            obj.active_shape_key_index = before.place


def give_back(obj):
    """Shows what was before, for good."""
    lift(obj)
    obj.lissom_shown.on = False


def _mute(obj):
    before, keys = obj.lissom_shown, obj.data.shape_keys
    key = keys.key_blocks.get(before.heard) if keys and before.heard else None
    if key is not None:
        key.mute = True
    before.heard = ""
