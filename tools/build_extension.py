"""Writes the installable extension: addon/ and the native wheel in one zip for each platform.

    python tools/build_extension.py                       every wheel in dist/
    python tools/build_extension.py WHEEL...              these wheels
    python tools/build_extension.py --blender blender     also lets Blender validate each zip

The result is dist/lissom-<version>-<platform>.zip, for the platforms that extensions.blender.org takes, named
and filled as `blender --command extension build --split-platforms` does. The manifest's platforms and wheels
are written here, from the names of the wheels, which go in as they are; the same input gives the same bytes.
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
MARK = "# website = ...\n# platforms = [...]\n# wheels = [...]\n"

# Platform tags of wheels, and what Blender calls these platforms.
PLATFORMS = (
    (r"(many)?linux.*_x86_64", "linux-x64"),
    (r"macosx.*_arm64", "macos-arm64"),
    (r"macosx.*_x86_64", "macos-x64"),
    (r"win_amd64", "windows-x64"),
    (r"win_arm64", "windows-arm64"),
)


def platform(wheel):
    """Blender's name of the platform that a wheel is for."""
    tag = wheel.stem.split("-")[-1]
    for pattern, name in PLATFORMS:
        if re.fullmatch(pattern, tag.split(".")[0]):
            return name
    sys.exit(f"{wheel.name}: there is no Blender for '{tag}'")


def manifest(wheel, website=None):
    """The text of the manifest with website, platforms and wheels filled in, and its version."""
    text = (ADDON / "blender_manifest.toml").read_text(encoding="utf-8")
    version = tomllib.loads(text)["version"]
    if wheel.name.split("-")[1] != version:
        sys.exit(f"{wheel.name}: the manifest says version {version}")
    if MARK not in text:
        sys.exit("blender_manifest.toml has lost the lines that stand for website, platforms and wheels")
    lines = [f'website = "{website}"\n'] if website else []
    lines += [f'platforms = ["{platform(wheel)}"]\n', f'wheels = ["./wheels/{wheel.name}"]\n']
    return text.replace(MARK, "".join(lines)), version


def build(wheel, folder, website=None):
    """Writes the zip of one wheel and returns its path."""
    text, version = manifest(wheel, website)
    path = folder / f"lissom-{version}-{platform(wheel).replace('-', '_')}.zip"
    sources = [p for p in sorted(ADDON.rglob("*")) if p.suffix in (".py", ".json")]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        _add(archive, "blender_manifest.toml", text.encode())
        for notice in ("LICENSE", "THIRD_PARTY.txt"):
            _add(archive, notice, (ROOT / notice).read_bytes())
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
    parser.add_argument("--website", help="where the project lives, for the manifest")
    parser.add_argument("--blender", help="Blender's executable, to validate the zips with")
    options = parser.parse_args()
    wheels = options.wheels or sorted(DIST.glob("lissom-*.whl"))
    if not wheels:
        sys.exit(f"no wheel in {DIST}: build one with maturin first")
    options.out.mkdir(parents=True, exist_ok=True)
    for wheel in wheels:
        path = build(wheel, options.out, options.website)
        print(f"{path} ({path.stat().st_size / 1e6:.1f} MB)")
        if options.blender:
            subprocess.run([options.blender, "--command", "extension", "validate", str(path)], check=True)


if __name__ == "__main__":
    main()
