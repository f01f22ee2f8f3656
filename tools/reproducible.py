"""Is the wheel the same, to the byte, wherever it is built? Builds HEAD in two folders, and compares.

python tools/reproducible.py [arguments of maturin build]
"""

import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
CARGO = pathlib.Path(os.environ.get("CARGO_HOME", pathlib.Path.home() / ".cargo"))


def built(folder, words):
    """The bytes of the wheel, built in a new clone."""
    subprocess.run(["git", "clone", "-q", str(ROOT), str(folder)], check=True)
    # Messages of panics name their source; the release workflow says the same.
    flags = "\x1f".join(
        f"--remap-path-prefix={path}={name}" for path, name in ((folder, "lissom"), (CARGO, "cargo"))
    )
    environment = {**os.environ, "CARGO_ENCODED_RUSTFLAGS": flags, "CARGO_TARGET_DIR": str(folder / "target")}
    command = [sys.executable, "-m", "maturin", "build", "--release", "--locked", "--out", "dist", *words]
    subprocess.run(command, cwd=folder, env=environment, check=True)
    (wheel,) = (folder / "dist").glob("*.whl")
    return wheel.read_bytes()


def main():
    with tempfile.TemporaryDirectory() as here:
        folders = [pathlib.Path(here, name) for name in ("one", "another, of a longer name")]
        sums = [hashlib.sha256(built(folder, sys.argv[1:])).hexdigest() for folder in folders]
    print("\n".join(sums))
    sys.exit(None if len(set(sums)) == 1 else "the wheels differ")


if __name__ == "__main__":
    main()
