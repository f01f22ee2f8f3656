"""The English texts of the extension: of its registered classes, and of the literals in its sources."""

import ast
import itertools
import pathlib
import re

import bpy

ADDON = pathlib.Path(__file__).parents[2] / "addon"
TEXT = re.compile(r"[A-Za-z]{2,}[^\w]*\s|^[A-Z][a-z]")  # words, or one as a label begins
# Files whose texts nobody sees in the window: the command line speaks English.
UNSEEN = ("commands", "bridge/sheet.py")
# Blender's own names, formats of files, and pieces that are never seen alone.
NO_TEXT = re.compile(
    r"^LISSOM_|^Lissom|^[ ,;.]|^of |^3D View$"
    r"|^(OutputMaterial|TexImage|MixShader|Emission)$|^ShaderNode|^Bsdf"
    r"|_places?\"|^'\{0\}' at |^at the$|^Operator$|^(obj|settings) = "
)
PIECES = "core/landmarks.py"  # names that are put together there; they are asked for as wholes
CORE = ADDON.parent / "rust" / "lissom" / "src"
# Strings of Rust, in the first group; comments, attributes and characters have none.
RUST = re.compile(
    r"//[^\n]*|#!?\[[^\]\"]*(?:\"(?:\\.|[^\"\\])*\"[^\]\"]*)*\]|'(?:\\.|[^'\\])'|\"((?:\\.|[^\"\\])*)\"",
    re.DOTALL,
)
RUST_TESTS = re.compile(r"#\[cfg\(test\)\]\s+(?:pub\(crate\) )?mod tests? \{")
RUST_ERROR = re.compile(r'#\[error\("((?:\\.|[^"\\])*)"')
FAULTY = re.compile(r'Fault::(?:new|at|out_of_range)\(\s*"([a-z]+)"')
LEAST = 5  # letters that a template is known by


def of_classes(classes):
    """{text: where it is from} of labels, descriptions, properties and items of registered classes."""
    found = {}
    for cls in classes:
        kind = cls.bl_rna
        if issubclass(cls, bpy.types.Operator):
            kind = getattr(bpy.ops.lissom, cls.bl_idname.split(".")[1]).get_rna_type()
        if issubclass(cls, (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu)):
            found[getattr(cls, "bl_label", "")] = cls.__name__
            found[kind.description] = cls.__name__
        for name in getattr(cls, "__annotations__", ()):
            prop = kind.properties.get(name)
            if prop is not None and not prop.is_hidden:
                found.update(dict.fromkeys(_of_property(prop), f"{cls.__name__}.{name}"))
        if issubclass(cls, bpy.types.Operator):  # annotations of mixins, too
            for prop in kind.properties:
                if prop.identifier != "rna_type" and not prop.is_hidden:
                    found.update(dict.fromkeys(_of_property(prop), f"{cls.__name__}.{prop.identifier}"))
    # Python takes the indentation from docstrings only since 3.13.
    found = {re.sub(r"\n {4}", "\n", text): place for text, place in found.items()}
    return {text: place for text, place in found.items() if TEXT.search(text)}


def _of_property(prop):
    if prop.name == prop.identifier:  # it has none: no panel shows it
        return
    yield prop.name
    if prop.description != bpy.types.PropertyGroup.bl_rna.properties["name"].description:  # Blender's own
        yield prop.description
    if prop.type == "ENUM":
        for item in prop.enum_items_static:
            yield item.name
            yield item.description


def of_sources():
    """{template: where it is from} of the literals that look like text, docstrings apart.

    The values of an f-string are ``{0}``, ``{1}`` and so on; a choice of two constants is written out.
    """
    found = {}
    for file in sorted(ADDON.rglob("*.py")):
        place = file.relative_to(ADDON).as_posix()
        if place.startswith(UNSEEN) or place == PIECES:
            continue
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for node in _literals(tree):
            for text in templates(node):
                text = re.sub(r"[.:]? $", "", text)  # another text follows
                letters = re.sub(r"\{\d*\}|[^A-Za-z]", "", text)
                if TEXT.search(text) and len(letters) >= LEAST and not NO_TEXT.search(text):
                    found.setdefault(text, f"{place}:{node.lineno}")
    return found


def of_core():
    """{template: where it is from} of the core's literals, and of the arguments that its faults are of.

    Its tests apart, and what stands behind a message of its own. Values are numbered as in ``of_sources``.
    """
    found = {}
    for file in sorted(CORE.rglob("*.rs")):
        text = re.split(
            r"#\[cfg\(test\)\]\s+(?:pub\(crate\) )?mod tests? \{", file.read_text(encoding="utf-8")
        )[0]
        place = file.relative_to(CORE).as_posix()
        if file.stem.endswith("tests"):
            continue
        literals = [_of_rust(literal[1] or "") for literal in RUST.finditer(text)]
        literals = [
            literal for literal in literals if " " in literal.strip() and not literal.startswith(" (")
        ]
        literals += map(_of_rust, RUST_ERROR.findall(text))
        for template in (*literals, *FAULTY.findall(text)):
            if len(re.sub(r"\{\d+\}|[^A-Za-z]", "", template)) >= LEAST or " " not in template:
                found.setdefault(template, place)
        found.pop("{0}", None)
    return found


def _of_rust(literal):
    text = re.sub(r"\\\n\s*", "", literal).replace('\\"', '"')
    count = itertools.count()
    return re.sub(
        r"\{\{|\}\}|\{[^}]*\}",
        lambda part: {"{{": "{", "}}": "}"}.get(part[0]) or f"{{{next(count)}}}",
        text,
    )


def _literals(tree):
    """Constants and f-strings, without docstrings and without the parts of f-strings."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.JoinedStr):
            yield node
            values = [value.value for value in node.values if isinstance(value, ast.FormattedValue)]
            waiting += [value for value in values if not _choice(value)]  # texts that a value is made of
            continue
        if isinstance(node, ast.Constant):
            if isinstance(node.value, str):
                yield node
            continue
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            continue
        waiting += ast.iter_child_nodes(node)


def _choice(node):
    """Whether this is one of two constants, as a plural's s."""
    return isinstance(node, ast.IfExp) and all(
        isinstance(side, ast.Constant) and isinstance(side.value, str) for side in (node.body, node.orelse)
    )


def templates(node):
    """All texts that a constant or an f-string can be, its values as numbered placeholders."""
    if isinstance(node, ast.Constant):
        count = itertools.count()
        return [re.sub(r"\{[a-z_]*(:[^}]*)?\}", lambda _: f"{{{next(count)}}}", node.value)]
    tests = {ast.dump(value.value.test): None for value in node.values if _chosen(value)}
    made = []
    for number in range(2 ** len(tests)):
        taken = {test: bool(number >> place & 1) for place, test in enumerate(tests)}
        text, count = "", 0
        for value in node.values:
            if isinstance(value, ast.Constant):
                text += value.value
            elif _chosen(value):
                chosen = value.value
                text += (chosen.body if taken[ast.dump(chosen.test)] else chosen.orelse).value
            else:
                text += f"{{{count}}}"
                count += 1
        made.append(text)
    return made


def _chosen(value):
    return isinstance(value, ast.FormattedValue) and _choice(value.value)
