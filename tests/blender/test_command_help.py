"""``--help`` of the commands: every argument says what it is, and what it is where it is not given."""

import argparse

import pytest
from bl_ext.user_default.lissom import commands


def arguments():
    """(command, argument) of all."""
    (made,) = (one for one in commands.parser()._actions if isinstance(one, argparse._SubParsersAction))
    for name, parser in made.choices.items():
        for action in parser._actions:
            yield name, action


@pytest.mark.parametrize(
    ("command", "action"), list(arguments()), ids=lambda one: str(getattr(one, "dest", one))
)
def test_every_argument_says_what_it_is_and_its_default(command, action):
    said = commands.Help("lissom")._get_help_string(action)
    assert len(said) > 5 and said[0].isupper(), f"{command}: {said!r}"
    assert said.count("(default: ") <= 1 and "%(" not in said
    is_there = action.default in (None, "", [], False, argparse.SUPPRESS)
    assert "(default: " in said or is_there, f"{command}: {said!r}"


def test_help_of_each_command_is_printed(capsys):
    for name in commands.COMMANDS:
        assert commands.main([name, "--help"]) == 0
        said = capsys.readouterr().out
        assert "--out OUT" in said and "--report REPORT" in said, name
    assert "EYE, UPPER, LOWER, RIDE" not in said
    assert commands.main(["face", "--help"]) == 0
    assert "EYE, UPPER, LOWER, RIDE" in " ".join(capsys.readouterr().out.split())
