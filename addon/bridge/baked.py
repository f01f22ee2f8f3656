"""Shape keys and caches that Bake Pose has made of an object, which would add to a live pose."""


def mute(obj, mute):
    """Silences what Bake made of the object, which would add to a live pose, or lets it play as before."""
    settings, keys = obj.lissom_pose, obj.data.shape_keys
    for baked in settings.baked:
        key = keys.key_blocks.get(baked.name) if keys else None
        if key is not None:
            if mute:
                baked.muted = key.mute
            key.mute = mute or baked.muted
    modifier = obj.modifiers.get(settings.baked_cache)
    if modifier is not None:
        if mute:
            settings.cache_hidden = not modifier.show_viewport, not modifier.show_render
        shown = [not (mute or hidden) for hidden in settings.cache_hidden]
        modifier.show_viewport, modifier.show_render = shown
