"""Writes THIRD_PARTY.txt: the notices of what is compiled into the wheel, which go into it and into the zip.

python tools/licences.py             writes it
python tools/licences.py --check     says whether it is as it would be written
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
FILE = ROOT / "THIRD_PARTY.txt"

# Of several licences on offer the first of these that there is; what deny.toml allows.
PREFERRED = ("MIT", "Zlib", "BSD-2-Clause", "Apache-2.0")
HEAD = """Lissom is under the GPL, version 3 or later: see LICENSE. Compiled into it are the Rust standard
library (MIT OR Apache-2.0, copyright the Rust Project contributors) and these packages, on one
platform or another.
"""


def packages():
    """What is compiled into the wheel: dependencies of its crate, but for builds, tests and macros."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked"]
    told = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
    package = {found["id"]: found for found in told["packages"]}
    node = {found["id"]: found for found in told["resolve"]["nodes"]}
    pending, seen = [name for name in told["workspace_members"] if "lissom-py" in name], {}
    while pending:
        name = pending.pop()
        if name in seen or any("proc-macro" in target["kind"] for target in package[name]["targets"]):
            continue
        seen[name] = package[name]
        pending += [d["pkg"] for d in node[name]["deps"] if any(k["kind"] is None for k in d["dep_kinds"])]
    return sorted((p for p in seen.values() if p["source"]), key=lambda p: (p["name"], p["version"]))


def notices(package):
    """The texts of its licence, as it comes with them; where it comes without, nothing."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = sorted(
        f for f in folder.iterdir() if re.match(r"(licen[cs]e|copying|notice)", f.name, re.I) and f.is_file()
    )
    if " AND " not in package["license"]:
        short = chosen(package).split("-")[0].lower()
        files = [f for f in files if short in f.name.lower()] or files
    return [f.read_text(encoding="utf-8").replace("\r", "").strip() for f in files]


def chosen(package):
    """The licence that is taken of those on offer."""
    offered = re.split(r" OR |/", package["license"].strip("()"))
    return next((licence for licence in PREFERRED if licence in offered), package["license"])


def written():
    """The text of THIRD_PARTY.txt."""
    found = packages()
    texts = [text for package in found for text in notices({**package, "license": "all, AND all"})]
    # Packages that forgot theirs get the words of one that names nobody.
    common = {
        "MIT": next(text for text in texts if text.startswith("Permission is hereby granted, free")),
        "Apache-2.0": next(text for text in texts if "APPENDIX: How to apply the Apache" in text),
    }
    bearers = {}
    for package in found:
        by = ", ".join(re.sub(r" *<.*>", "", author) for author in package["authors"]) or "its authors"
        for text in notices(package) or [f"Copyright (c) {by}\n\n{common[chosen(package)]}"]:
            bearers.setdefault(text, []).append(
                f"{package['name']} {package['version']} ({package['license']})"
            )
    parts = [HEAD, *("\n".join([*names, "", text]) for text, names in bearers.items())]
    return f"\n{'-' * 100}\n\n".join(part.strip() + "\n" for part in parts)


def main():
    text = written()
    if sys.argv[1:] == ["--check"]:
        sys.exit(None if FILE.read_text(encoding="utf-8") == text else f"{FILE}: run tools/licences.py")
    FILE.write_text(text, encoding="utf-8")
    print(FILE)


if __name__ == "__main__":
    main()
