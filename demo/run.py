"""The demo: all three jobs on real meshes, in Blender without a window.

    python demo/run.py --out build/demo                 # demo.blend, pictures, report.md, report.json
    python demo/run.py --out build/demo --publish       # and copies, the pictures' small, into docs/pictures

It needs the modules bpy and lissom, and drives the extension's own operators, as an artist's script would.
"""

import argparse
import os
import shutil
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))  # for the extension's package; that of this file is there already

import arcs  # noqa: E402
import bpy  # noqa: E402
import drawing  # noqa: E402
import elbow  # noqa: E402
import face as ict  # noqa: E402
import guide  # noqa: E402
import inbetween  # noqa: E402
import lissom  # noqa: E402
import pose  # noqa: E402
import remeshed  # noqa: E402
import report  # noqa: E402
import scene  # noqa: E402
import source  # noqa: E402
import suzanne  # noqa: E402
from studio import SAMPLES, Studio, publish  # noqa: E402

import addon  # noqa: E402

ARCS = ("lid", "jaw", "blink", "twist")
FILMS = ("pose", "transfer", "inbetween")
PICTURES = ("pose", "remeshed", "suzanne", "suzanne_keys", "inbetween", *ARCS, "elbow", "drawing")


def main(arguments):
    started = time.perf_counter()
    folder = arguments.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon.register()

    face = ict.load()
    given = scene.material("Given", (0.44, 0.38, 0.33), 0.55)
    made = scene.material("Made by Lissom", (0.07, 0.27, 0.31), 0.5)
    studio = Studio(arguments.samples)
    pictures = {name: folder / f"{name}.png" for name in PICTURES}
    films = {name: folder / f"{name}.gif" for name in FILMS}

    figures = {"blender": bpy.app.version_string, "lissom": lissom.__version__, "processors": os.cpu_count()}
    figures["pose"] = pose.run(face, made, studio, pictures["pose"], films["pose"])
    obj = source.make("ICT face", face, given, scene.collection("2 ICT face"), (3.0, 0, 0))
    figures["remeshed"] = remeshed.run(
        face, obj, made, studio, folder, pictures["remeshed"], films["transfer"]
    )
    figures["suzanne"] = suzanne.run(
        face, obj, given, made, studio, pictures["suzanne"], pictures["suzanne_keys"]
    )
    figures["inbetween"] = inbetween.run(face, given, made, studio, pictures["inbetween"], films["inbetween"])
    figures["arcs"] = arcs.run(face, given, made, studio, pictures)
    figures["elbow"] = elbow.run(given, made, studio, pictures["elbow"])
    figures["drawing"] = drawing.run(studio, pictures["drawing"])
    figures["picture_seconds"] = studio.seconds
    studio.close()

    guide.write()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "demo.blend"), compress=True)
    figures["seconds"] = time.perf_counter() - started
    report.write(folder, figures)
    errors = figures["remeshed"]["expressions"]
    print(report.expressions(errors))
    for line in report.stale(errors, (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")):
        print(f"docs/benchmarks.md has another row: {line}")
    made = f"demo.blend, report.md, {len(pictures)} pictures and {len(films)} films"
    print(f"{folder}: {made} in {figures['seconds']:.0f} s")
    if arguments.publish:
        for name, picture in pictures.items():
            publish(picture, ROOT / "docs" / "pictures" / f"{name}.jpg")
        for film in films.values():
            shutil.copy(film, ROOT / "docs" / "pictures")


def parsed(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "demo", help="folder for the results")
    parser.add_argument("--samples", type=int, default=SAMPLES, help="samples of a pixel in the pictures")
    parser.add_argument("--publish", action="store_true", help="copy the pictures into docs/pictures")
    return parser.parse_args(words)


if __name__ == "__main__":
    main(parsed(sys.argv[1:]))
