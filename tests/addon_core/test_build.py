"""The native part is recognised as that of the wheel, or as another."""

import zipfile

import pytest
from lissom_addon_core import build

RECORD = "lissom-1.2.3.dist-info/RECORD"


@pytest.mark.parametrize("installed, differs", [("same", False), ("other", True), (None, False)])
def test_a_wheel_is_told_from_another_of_its_version(tmp_path, installed, differs):
    with zipfile.ZipFile(tmp_path / "lissom-1.2.3-cp311-abi3-any.whl", "w") as archive:
        archive.writestr("lissom/__init__.py", "")
        archive.writestr(RECORD, "same")
    module = tmp_path / "site-packages" / "lissom" / "__init__.py"
    if installed:
        record = tmp_path / "site-packages" / RECORD
        record.parent.mkdir(parents=True)
        record.write_text(installed)
    assert build.differs(tmp_path, module) is differs


def test_a_checkout_has_no_wheel(tmp_path):
    assert not build.differs(tmp_path / "wheels", tmp_path / "lissom" / "__init__.py")
