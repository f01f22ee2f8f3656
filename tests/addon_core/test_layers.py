"""The layers of the extension in docs/layers.md, held against the sources: what imports what."""

import ast
import sys
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[2]
BEGIN, END = "<!-- imports of the extension -->", "<!-- end of the imports of the extension -->"

# From the ground up; addon/__init__.py is the door. Nothing imports what stands beside it.
LAYERS = (
    ("core", "session", "changes"),
    ("bridge", "layouts", "translations", "manual"),
    ("preferences",),
    ("jobs",),
    ("live", "watch", "rows", "saving", "drawing", "properties"),
    ("rebind",),
    ("panels", "operators", "commands"),
)


@pytest.fixture(scope="module")
def graph():
    sys.path.insert(0, str(ROOT))
    try:
        return grimp.build_graph("addon", include_external_packages=True, cache_dir=None)
    finally:
        sys.path.remove(str(ROOT))


def own(graph):
    """(importer, imported) of all modules of the extension but its door."""
    inside = [module for module in graph.modules if module.startswith("addon.")]
    for module in sorted(inside):
        for imported in sorted(graph.find_modules_directly_imported_by(module)):
            if imported.startswith("addon"):
                yield module, imported


def part(module):
    return module.split(".")[1] if "." in module else "__init__"


def height(name):
    """The number of a part's layer; a part that has none is an error."""
    return next(number for number, names in enumerate(LAYERS) if name in names)


def test_no_arrow_points_up_or_to_the_side(graph):
    wrong = [
        f"{module} takes {imported}"
        for module, imported in own(graph)
        if part(module) != part(imported)
        and (imported == "addon" or height(part(imported)) >= height(part(module)))
    ]
    assert not wrong, "\n".join(wrong)


def test_no_modules_import_each_other(graph):
    rings = [
        f"{module} takes {imported}, which leads back"
        for module, imported in own(graph)
        if graph.chain_exists(importer=imported, imported=module)
    ]
    assert not rings, "\n".join(rings)


def test_bridge_and_properties_know_nothing_that_lives_only_in_memory(graph):
    memory = {"session", "live", "rebind", "watch"}
    wrong = [
        f"{module} takes {imported}"
        for module, imported in own(graph)
        if part(module) in ("bridge", "properties") and part(imported) in memory
    ]
    assert not wrong, "\n".join(wrong)


def test_commands_run_jobs_alone(graph):
    taken = {part(imported) for module, imported in own(graph) if part(module) == "commands"}
    assert taken <= {"jobs", "core", "commands"}, taken


def test_operators_take_from_no_operator(graph):
    """What several share is in modules that register nothing."""
    wrong = [
        f"{module} takes {imported}"
        for module, imported in own(graph)
        if part(module) == part(imported) == "operators" and registers(imported)
    ]
    assert not wrong, "\n".join(wrong)
    assert registers("addon.operators.pose_bind") and not registers("addon.operators.job")


def registers(module):
    """Whether a module of the extension has classes for Blender."""
    tree = ast.parse((ROOT / module.replace(".", "/")).with_suffix(".py").read_text())
    names = [goal.id for node in tree.body if isinstance(node, ast.Assign) for goal in node.targets]
    return "classes" in names


def test_core_knows_numpy_and_lissom_only(graph):
    """So that its tests run anywhere; what lives in the session is plain Python."""
    allowed = {"numpy", "lissom", *sys.stdlib_module_names}
    taken = {
        (module, imported)
        for module in graph.modules
        if part(module) in ("core", "session", "changes")
        for imported in graph.find_modules_directly_imported_by(module)
        if not imported.startswith("addon")
    }
    assert ("addon.core.pose", "lissom") in taken
    assert {imported for _, imported in taken} <= allowed, taken


def test_no_operator_is_long():
    """What it does is in jobs: 150 lines are the most."""
    lengths = {}
    for file in (ROOT / "addon" / "operators").glob("*.py"):
        for node in ast.parse(file.read_text()).body:
            if isinstance(node, ast.ClassDef):
                lengths[node.name] = node.end_lineno - node.lineno + 1
    assert lengths and max(lengths.values()) <= 150, max(lengths.items(), key=lambda item: item[1])


def test_no_file_is_long():
    lengths = {str(file): len(file.read_text().splitlines()) for file in (ROOT / "addon").rglob("*.py")}
    assert lengths and max(lengths.values()) <= 350, max(lengths.items(), key=lambda item: item[1])


def test_the_bridge_alone_moves_arrays_in_and_out_of_blender():
    files = [*(ROOT / "addon").rglob("*.py")]
    named = {file for file in files if "foreach_get" in file.read_text() or "foreach_set" in file.read_text()}
    assert {file.relative_to(ROOT / "addon").parts[0] for file in named} == {"bridge"}, named


def test_the_architecture_shows_what_imports_what(graph):
    imports = {name: set() for names in LAYERS for name in names}
    for module, imported in own(graph):
        if part(module) != part(imported):
            imports[part(module)].add(part(imported))
    lines = ["| part | layer | imports |", "|---|---|---|"]
    for number in reversed(range(len(LAYERS))):
        for name in LAYERS[number]:
            taken = sorted(imports[name], key=lambda other: (-height(other), other))
            lines.append(f"| `{name}` | {number + 1} | {', '.join(taken)} |")
    made = "\n".join(lines)
    _, _, rest = (ROOT / "docs/layers.md").read_text().partition(BEGIN)
    shown, _, _ = rest.partition(END)
    assert shown.strip() == made, f"docs/layers.md should have\n\n{BEGIN}\n\n{made}\n\n{END}"


def test_files_are_opened_in_one_place():
    files = [*(ROOT / "addon").rglob("*.py")]
    found = [
        file.relative_to(ROOT / "addon").as_posix() for file in files if "open_mainfile" in file.read_text()
    ]
    assert found == ["commands/outputs.py"], found
