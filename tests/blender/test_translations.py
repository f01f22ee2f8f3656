"""Every text of the extension is there in Simplified Chinese, and finished messages are found again."""

import json
import re

import lissom
import numpy as np
import pytest
import strings
from bl_ext.user_default.lissom import translations
from bl_ext.user_default.lissom.core import landmarks
from bl_ext.user_default.lissom.core.wording import Catalogue

FILE = strings.ADDON / "locale" / "zh_HANS.json"
FIELD = re.compile(r"\{\d+\}|%[ds]")
# Names and units that are the same in every language.
SAME = {"ARKit", "ICT", "VRM", "Lissom", "Alpha", "Esc"}


@pytest.fixture(scope="module")
def table():
    return json.loads(FILE.read_text(encoding="utf-8"))


def test_every_text_is_translated(addon, table):
    wanted = {**strings.of_sources(), **strings.of_classes(addon._CLASSES)}
    wanted |= {mark.name: "core/landmarks.py" for marks in landmarks.SETS.values() for mark in marks}
    assert len(wanted) > 900
    missing = {text: place for text, place in wanted.items() if text not in table and text not in SAME}
    lines = [f"{json.dumps(text)}: {place}" for text, place in sorted(missing.items())]
    assert not missing, f"{len(missing)} texts are missing in {FILE.name}:\n" + "\n".join(lines)


def test_every_message_of_the_core_is_translated(table):
    wanted = strings.of_core()
    assert len(wanted) > 200 and {"empty handle", "handles", "cancelled"} <= set(wanted)
    missing = {text: place for text, place in wanted.items() if text not in table}
    lines = [f"{json.dumps(text)}: {place}" for text, place in sorted(missing.items())]
    assert not missing, f"{len(missing)} texts are missing in {FILE.name}:\n" + "\n".join(lines)


def test_plain_words_are_of_messages_that_the_core_has_and_are_translated(table):
    of_core = set(strings.of_core())
    for text, said in translations.PLAIN.items():
        problem = text.removesuffix(" (at {0}; {1} in all)").partition(": ")[2]
        assert problem in of_core, text
        assert said in table, said
        finished = text.format("3, 7, ...", 12)
        assert translations.translated(finished) == said.format("3, 7, ...", 12)
        assert not re.search(
            "[A-Za-z]{3,} [a-z]{3,} [a-z]", Catalogue(table).said(said.format("3, 7, ...", 12))
        )


def faults():
    """What the native module says of some input that is wrong or doubtful."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    mesh = lissom.Mesh(square, faces)
    yield from mesh.warnings
    yield from lissom.Mesh(square, [*faces, [0, 1, 2], [1, 1, 2]]).warnings
    for wrong in (
        lambda: lissom.Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=int)),
        lambda: lissom.Mesh(square, [[0, 1, 7]]),
        lambda: lissom.Mesh(square * [np.nan, 1, 1], faces),
        lambda: lissom.Pose(mesh, [[0], []]),
        lambda: lissom.Pose(mesh, [[0], [0]]),
        lambda: lissom.Pose(mesh, [[0], [9]]),
        lambda: lissom.Pose(mesh, [[0], [2]], method="arap", rotation_smoothing=-1.0),
        lambda: lissom.Inbetween(mesh, square, square[:3]),
        lambda: lissom.Inbetween(mesh, square, square).keyframes(-1.0),
        lambda: lissom.fit_correspondence(mesh, mesh, [[0, 0], [0, 1], [2, 2]]),
    ):
        with pytest.raises((lissom.Error, ValueError)) as error:
            wrong()
        yield str(error.value)


def test_what_the_core_says_of_real_input_is_chinese_to_the_last_word(table):
    said = {text: Catalogue(table).said(text) for text in faults()}
    assert len(said) > 10
    left = {text: told for text, told in said.items() if re.search("[a-z]{2,} [a-z]{2,}", told)}
    assert not left, left


def test_no_value_stands_right_behind_another(table):
    """Such two could not be told apart in a finished message; but for a word that is there or not."""
    adjacent = [text for text in table if "}{" in text]
    assert adjacent == ["be from {0}{1} to {2}{3}", "moves {0}{1} % as far as on the source"]


def test_placeholders_agree(table):
    wrong = [
        text for text, said in table.items() if sorted(FIELD.findall(text)) != sorted(FIELD.findall(said))
    ]
    assert not wrong, wrong


def test_it_is_chinese(table):
    plain = [
        text
        for text, said in table.items()
        if not re.search("[\u4e00-\u9fff]", said) and re.search("[a-z]{2}", text) and text not in SAME
    ]
    assert not [text for text in plain if len(FIELD.sub("", text).strip()) > 8], plain
    assert not [said for said in table.values() if said != said.strip()]


@pytest.mark.parametrize(
    ("english", "chinese"),
    [
        ("There is no object named 'Pose'", "没有名为“Pose”的物体"),
        ("'Head' is in edit mode: go to Object Mode first", "“Head”处于编辑模式：请先切换到物体模式"),
        ("Shape keys 'a', 'b' are locked: unlock them in the list of shape keys", "“a”, “b”"),
        ("12 marker pairs and 3 curves from a.json", "来自 a.json 的 12 个标记对和 3 条曲线"),
        ("2 shape keys on 'Other'", "'Other' 上有 2 个形态键"),
        ("1 shape keys on 3 objects; renamed: a.001", "3 个物体 上有 1 个形态键; 已重命名：a.001"),
        (
            "Fit: 0.03 % off on average, 0.0 % of the target unmatched; 99 % sure how the meshes lie",
            "适配：平均偏离 0.03 %，目标有 0.0 % 未匹配; 对网格的相对位置有 99 % 的把握",
        ),
        ("bent arc: Curve 3", "bent arc: 曲线 3"),
        ("Something else", "Something else"),
    ],
)
def test_finished_messages_are_found_again(table, english, chinese):
    said = Catalogue(table).said(english)
    if "are locked" in english:  # lists of names stay as they are
        assert said == "形态键 'a', 'b' 已锁定：请在形态键列表中解锁"
    else:
        assert said == chinese


def test_what_is_said_follows_blenders_language(monkeypatch):
    text = "Press Bind first"
    assert translations.translated(text) == text
    monkeypatch.setattr(translations, "language", lambda: "zh_HANS")  # Blender as a module has English alone
    assert translations.translated(text) == "请先点击“绑定”"
