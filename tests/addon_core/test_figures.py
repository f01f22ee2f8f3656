"""What README and the manual quote is so elsewhere: figures in the benchmarks, versions in what is tested."""

import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
NUMBER = re.compile(r"(?<![\d.,])\d[\d,]*(?:\.\d+)?")


def read(name):
    return (ROOT / name).read_text(encoding="utf-8")


def numbers(text):
    return set(NUMBER.findall(text))


def test_figures_of_readme_are_those_of_the_benchmarks():
    table = read("README.md").partition("## Measured")[2]
    rows = [line.split("|")[2:4] for line in table.splitlines() if line.startswith("| ")][1:]
    quoted = [numbers(ours) | numbers(others) for ours, others in rows]
    known = [numbers(line) for line in read("docs/benchmarks.md").splitlines()]
    assert len(quoted) == 3 and all(len(row) == 2 for row in quoted)
    assert [row for row in quoted if not any(row <= line for line in known)] == []


def test_supported_blenders_are_those_of_the_manifest_and_the_tests():
    oldest = re.search(r'blender_version_min = "(\d+\.\d+)\.0"', read("addon/blender_manifest.toml"))[1]
    first, newest = re.search(
        r"^BLENDERS := (\S+) \$\(if \$\(PYTHON313\),(\S+?),", read("Makefile"), re.M
    ).groups()
    assert first == oldest
    for page in ("README.md", "docs/index.md"):
        assert re.findall(r"(\d\.\d) to\s+(\d\.\d)", read(page)) == [(oldest, newest)], page
