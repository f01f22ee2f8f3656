"""core.wording: messages by their templates, and lines."""

from lissom_addon_core.wording import Catalogue, lines, singular

TABLE = {
    "There is no {0} named '{1}'": "没有名为“{1}”的{0}",
    "{0}: look there": "{0}：请查看",
    "Object": "物体",
    "object": "物体",
    "There is no {0}": "没有{0}",
    "{0} of the {1}": "{1}的{0}",
    "Torn": "撕裂",
}


def test_names_stay_and_other_values_are_spoken():
    said = Catalogue(TABLE).said
    assert said("There is no object named 'object'") == "没有名为“object”的物体"


def test_the_template_that_says_most_wins():
    assert Catalogue(TABLE).said("There is no object") == "没有物体"
    assert Catalogue(TABLE).said("There is no cube named 'a': look there") == "没有名为“a”的cube：请查看"


def test_what_is_unknown_stays_and_parts_are_found():
    said = Catalogue(TABLE).said
    assert said("Nothing of ours") == "Nothing of ours"
    assert said("Cube: Torn. Object: unknown") == "Cube: 撕裂. 物体: unknown"
    assert said("") == ""


def test_what_the_core_says_of_an_argument_is_known_by_what_says_most():
    table = {
        "{0} vertex {1}": "{0}顶点{1}",
        "vertex out of range, there are {0}": "顶点超出范围，有 {0} 个",
        "handles": "控制柄",
        "handles: only {0} of them": "控制柄：只有 {0} 个",
        "{0} (at {1}; {2} in all)": "{0}（{1}；{2}）",
    }
    said = Catalogue(table).said
    whole = said("handles: vertex out of range, there are 5 (at 9; 1 in all)")
    assert whole == "控制柄: 顶点超出范围，有 5 个（9；1）"
    assert said("handles: only 2 of them") == "控制柄：只有 2 个"
    assert said("no_word: vertex 3") == "no_word:顶点3"


def short(count):
    return lambda line: len(line) <= count


def test_lines_break_between_words():
    assert lines("one two  three", short(7)) == ["one two", "three"]
    assert lines("immeasurable", short(5)) == ["immeasurable"]
    assert lines("", short(5)) == [""]


def test_lines_break_between_signs_but_not_before_one_that_closes():
    text = "请先点击“绑定”，再点击。"
    made = lines(text, short(5))
    assert "".join(made) == text
    assert not any(line[0] in "，。”" for line in made)
    assert max(map(len, made)) <= 6
    assert lines("按 Esc 完成", short(6)) == ["按 Esc", "完成"]


def test_one_is_counted_as_one():
    said = {
        "1 shape keys on 'Head'": "1 shape key on 'Head'",
        "4 shape keys under 1 sliders": "4 shape keys under 1 slider",
        "No key can move 1 vertices, which": "No key can move 1 vertex, which",
        "12 marker pairs and 1 curves from '1 keys'": "12 marker pairs and 1 curve from '1 keys'",
        "0.1 keys, 21 faces, 1,001 faces": "0.1 keys, 21 faces, 1,001 faces",
        "1 faces are folded": "1 faces are folded",
    }
    assert {text: singular(text) for text in said} == said
