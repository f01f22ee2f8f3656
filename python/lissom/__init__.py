"""Pose, transfer and interpolate triangle meshes.

Positions are float64 arrays of shape (n, 3) in the mesh's own units, indices are integer arrays counted
from 0. Other float and integer arrays, in any memory layout, are converted.

Every call that may take long has two forms: ``x(...)`` waits, with the interpreter released, and Ctrl-C
cancels it; ``start_x(...)`` takes the same arguments and returns a :class:`Job` at once, whose ``result()``
is what ``x`` returns.
"""

from . import data, names
from ._geometry import closest_points, components, nearest_rotations, rotation_vectors
from ._image import ImageMesh, image_mesh, start_image_mesh
from ._inbetween import Blend, Inbetween, Keyframes, start_blend, start_inbetween
from ._learn import Learned, learn, start_learn
from ._native import (
    Cancelled,
    Error,
    InternalError,
    InvalidConstraint,
    InvalidMesh,
    InvalidValue,
    Job,
    Mesh,
    OutOfMemory,
    SolveFailed,
    __version__,
    _panic,  # noqa: F401
)
from ._options import OPTION_OWNERS, POSE_METHODS, Option, options
from ._pose import Pose, Posed, PoseInfo, PoseReport, start_pose
from ._report import Report
from ._transfer import (
    Fit,
    FitReport,
    Quality,
    Transfer,
    Transferred,
    TransferReport,
    fit_correspondence,
    start_fit,
    start_transfer,
)

__all__ = [
    "OPTION_OWNERS",
    "POSE_METHODS",
    "Blend",
    "Cancelled",
    "Error",
    "Fit",
    "FitReport",
    "ImageMesh",
    "Inbetween",
    "InternalError",
    "InvalidConstraint",
    "InvalidMesh",
    "InvalidValue",
    "Job",
    "Keyframes",
    "Learned",
    "Mesh",
    "Option",
    "OutOfMemory",
    "Pose",
    "PoseInfo",
    "PoseReport",
    "Posed",
    "Quality",
    "Report",
    "SolveFailed",
    "Transfer",
    "TransferReport",
    "Transferred",
    "__version__",
    "closest_points",
    "components",
    "data",
    "fit_correspondence",
    "image_mesh",
    "learn",
    "names",
    "nearest_rotations",
    "options",
    "rotation_vectors",
    "start_blend",
    "start_fit",
    "start_image_mesh",
    "start_inbetween",
    "start_learn",
    "start_pose",
    "start_transfer",
]

# Everything is found here, whatever file it is written in.
for _name in __all__:
    if getattr(globals()[_name], "__module__", "").startswith("lissom."):
        globals()[_name].__module__ = "lissom"
del _name
