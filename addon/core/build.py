"""Whether the native part that is imported is the one that came with the extension."""

import pathlib
import zipfile

MESSAGE = (
    "The native part is of another build of this version: remove Lissom, restart Blender and install it again"
)


def differs(wheels, module):
    """Whether the wheel in the folder ``wheels`` is another than that of ``module``, a file of the package.

    Blender unpacks a wheel where there is none of its version: installed anew, a version keeps the old one.
    Without a wheel, as from a checkout, nothing is known, and nothing differs.
    """
    for wheel in pathlib.Path(wheels).glob("lissom-*.whl"):
        with zipfile.ZipFile(wheel) as archive:
            record = next(name for name in archive.namelist() if name.endswith(".dist-info/RECORD"))
            installed = pathlib.Path(module).parents[1] / record
            return installed.is_file() and installed.read_bytes() != archive.read(record)
    return False
