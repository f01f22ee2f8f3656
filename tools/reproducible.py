"""Is the wheel the same, to the byte, wherever it is built? Builds HEAD in two folders, and compares.

python tools/reproducible.py [arguments of maturin build]
"""

import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
CARGO = pathlib.Path(os.environ.get("CARGO_HOME", pathlib.Path.home() / ".cargo"))


def built(folder, words):
    """The wheel, built in a new clone, and what it holds."""
    subprocess.run(["git", "clone", "-q", str(ROOT), str(folder)], check=True)
    # Messages of panics name their source; the release workflow says the same.
    flags = "\x1f".join(
        f"--remap-path-prefix={path}={name}" for path, name in ((folder, "lissom"), (CARGO, "cargo"))
    )
    environment = {**os.environ, "CARGO_ENCODED_RUSTFLAGS": flags, "CARGO_TARGET_DIR": str(folder / "target")}
    command = [sys.executable, "-m", "maturin", "build", "--release", "--locked", "--out", "dist", *words]
    subprocess.run(command, cwd=folder, env=environment, check=True)
    (wheel,) = (folder / "dist").glob("*.whl")
    print(f"{hashlib.sha256(wheel.read_bytes()).hexdigest()}  {wheel.name}", flush=True)
    with zipfile.ZipFile(wheel) as archive:
        return wheel.read_bytes(), {name: archive.read(name) for name in archive.namelist()}


def main():
    with tempfile.TemporaryDirectory() as here:
        folders = [pathlib.Path(here, name) for name in ("one", "another, of a longer name")]
        (first, holds), (second, holds_too) = (built(folder, sys.argv[1:]) for folder in folders)
    names = [name for name in {**holds, **holds_too} if holds.get(name) != holds_too.get(name)]
    sys.exit(None if first == second else f"the wheels differ, in {', '.join(names) or 'their order'}")


if __name__ == "__main__":
    main()
