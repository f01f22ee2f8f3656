"""The table of options of fits and transfers against those of lissom."""

import lissom
from lissom_addon_core.transfer_options import FLAGS, MASKS, OPTIONS

# What is made of markers and curves, and what no artist has to choose.
MADE = {"points", "source_points", "curves", "modes"}
LEFT = {
    "fit": {*MADE, *MASKS, "smoothness", "identity", "steps", "rounds", "most_turn"},
    "transfer": {"weighting", "frames", "anchor"},
}


def test_every_option_is_in_the_table_or_left_out_on_purpose():
    for owner, options in OPTIONS.items():
        known = {one.name for one in lissom.options(owner)}
        assert set(options) == known - LEFT[owner], f"{owner}: a label, or LEFT here"


def test_no_two_have_one_label_or_one_flag():
    every = {name: one for options in OPTIONS.values() for name, one in options.items()}
    assert len({one.label for one in every.values()}) == len(every)
    assert len({FLAGS.get(name, name) for name in every}) == len(every) and set(FLAGS) <= set(every)
