"""Changed settings are told here: properties know nothing of who acts on them, nor he of who changed them."""


class Change(list):
    """Functions that are called, in their order, each time that such a change is told."""

    def tell(self, *about):
        """``about`` is what was changed."""
        for listener in self:
            listener(*about)


pose_options = Change()  # of a bound mesh object: how it is to be posed
handle_turn = Change()  # of a bound mesh object: whether a handle turns by itself
arc_choice = Change()  # of a mesh object: ends and options of the arc that is being chosen
arc_preview = Change()  # where on that arc one looks
quality_row = Change()  # of a scene: the active row of the table of transferred keys
learned_row = Change()  # of a scene: the active row of the list of what would be learned
