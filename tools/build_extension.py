"""Writes the installable extension: addon/ and the native wheel in one zip for each platform.

    python tools/build_extension.py                       every wheel in dist/
    python tools/build_extension.py WHEEL...              these wheels
    python tools/build_extension.py --blender blender     also lets Blender validate each zip

The result is dist/lissom-<version>-<platform>.zip. The manifest's lists of platforms and wheels are written
here, from the names of the wheels; the same input gives the same bytes.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
ADDON = ROOT / "addon"
DIST = ROOT / "dist"
MARK = "# platforms = [...]\n# wheels = [...]\n"

# Platform tags of wheels, and what Blender calls these platforms.
PLATFORMS = (
    (r"(many|musl)?linux.*_x86_64", ["linux-x64"]),
    (r"(many|musl)?linux.*_aarch64", ["linux-arm64"]),
    (r"macosx.*_universal2", ["macos-x64", "macos-arm64"]),
    (r"macosx.*_arm64", ["macos-arm64"]),
    (r"macosx.*_x86_64", ["macos-x64"]),
    (r"win_amd64", ["windows-x64"]),
    (r"win_arm64", ["windows-arm64"]),
)


def platforms(wheel):
    """Blender's names of the platforms that a wheel is for."""
    tag = wheel.stem.split("-")[-1]
    for pattern, names in PLATFORMS:
        if re.fullmatch(pattern, tag.split(".")[0]):
            return names
    sys.exit(f"{wheel.name}: unknown platform '{tag}'")


def manifest(wheels, names):
    """The text of the manifest with platforms and wheels filled in."""
    text = (ADDON / "blender_manifest.toml").read_text(encoding="utf-8")
    version = tomllib.loads(text)["version"]
    for wheel in wheels:
        if wheel.name.split("-")[1] != version:
            sys.exit(f"{wheel.name}: the manifest says version {version}")
    if MARK not in text:
        sys.exit("blender_manifest.toml has lost the two lines that stand for platforms and wheels")
    quoted = [
        ", ".join(f'"{item}"' for item in items) for items in (names, [f"./wheels/{w.name}" for w in wheels])
    ]
    return text.replace(MARK, f"platforms = [{quoted[0]}]\nwheels = [{quoted[1]}]\n"), version


def build(wheel, folder):
    """Writes the zip of one wheel and returns its path."""
    names = platforms(wheel)
    text, version = manifest([wheel], names)
    path = folder / f"lissom-{version}-{'-'.join(names)}.zip"
    sources = [p for p in sorted(ADDON.rglob("*")) if p.suffix == ".py"]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        _add(archive, "blender_manifest.toml", text.encode())
        _add(archive, "LICENSE", (ROOT / "LICENSE").read_bytes())
        for source in sources:
            _add(archive, source.relative_to(ADDON).as_posix(), source.read_bytes())
        _add(archive, f"wheels/{wheel.name}", wheel.read_bytes())
    return path


def _add(archive, name, data):
    archive.writestr(zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheels", nargs="*", type=pathlib.Path, help="one wheel of lissom for each platform")
    parser.add_argument("--out", type=pathlib.Path, default=DIST, help="folder for the zips")
    parser.add_argument("--blender", help="Blender's executable, to validate the zips with")
    options = parser.parse_args()
    wheels = options.wheels or sorted(DIST.glob("lissom-*.whl"))
    if not wheels:
        sys.exit(f"no wheel in {DIST}: build one with maturin first")
    options.out.mkdir(parents=True, exist_ok=True)
    for wheel in wheels:
        path = build(wheel, options.out)
        print(f"{path} ({path.stat().st_size / 1e6:.1f} MB)")
        if options.blender:
            subprocess.run([options.blender, "--command", "extension", "validate", str(path)], check=True)


if __name__ == "__main__":
    main()
