"""Types of the options, for editors and type checkers. Written by tools/options_doc.py."""

from collections.abc import Sequence
from typing import Literal, TypedDict

from numpy.typing import ArrayLike

from ._native import Mesh


class PoseOptions(TypedDict, total=False):
    """Options of pose, pose.*."""

    constraints: Literal["hard", "soft"]
    """Whether vertices of a handle go just where it takes them."""
    weight: float
    """How strongly soft handles pull: more holds them closer."""
    preserve_volume: bool
    """Closed components keep the volume that they have at rest."""
    unheld: Literal["follow", "rest"]
    """What parts without a handle do, such as eyes, teeth and buttons."""
    mirror: Sequence[tuple[ArrayLike, ArrayLike]] | None
    """Planes, each (point, normal), that complete a half mesh by its mirror image, with the same handles:
    vertices on them stay on them."""
    symmetry: Sequence[tuple[ArrayLike, ArrayLike]] | None
    """Planes, each (point, normal), that a whole mesh is symmetric about: every handle's mirror image moves
    as its mirror image. Where both are handles, the one on the normal's side leads."""
    mirror_tolerance: float
    """How far a vertex may be from where a mirror image has it to be that."""
    weights: Literal["cotangent", "uniform"]
    """How much each neighbour of a vertex counts."""
    scale: bool
    """Let details grow and shrink as they turn: for handles that scale; large turns swell."""
    frames: Literal["uniform", "principal"]
    """Along which edges turns are spread."""
    interpolation: Literal["rotation_vector", "matrix"]
    """What is spread between the handles."""
    project: bool
    """Make every spread matrix a rotation; without, stretches of the handles are spread as well."""
    k_s: float
    """Resistance to stretching."""
    k_b: float
    """Resistance to bending."""
    border: int
    """How smoothly the pose joins the handles and the border of the region: 0 in value, 1 in slope too, 2 in
    curvature too."""
    solid: bool
    """Closed parts keep their thickness when they bend and twist, as a body does and a hollow shell does
    not."""
    smoothing: float
    """Bumps narrower than this are details, and follow the base."""
    details: Literal["gradients", "offsets"]
    """How details are put back on the posed base."""
    base: Literal[
        "laplacian",
        "laplacian_fitted",
        "rotation_invariant",
        "thin_shell",
        "poisson",
        "arap",
        "laplacian_rotated",
    ]
    """The method that poses the smooth base, whose options may be given too."""
    cells: Literal["spokes_and_rims", "spokes"]
    """The edges around a vertex that are kept rigid together."""
    rotation_smoothing: float
    """How much neighbours must turn alike: more spreads a bend further along, 0 creases."""
    smoothness: float
    """How much curvature counts against lengths: 0.1 takes the spike off a single moved vertex."""
    estimate: float
    """Bumps narrower than this turn as the surface around them does."""


class SolveOptions(TypedDict, total=False):
    """Options of pose.solve."""

    max_iterations: int
    """Most iterations."""
    tolerance: float
    """Stop when an iteration lowers the energy by less than this."""
    warm_start: bool
    """Start from the previous pose, where there is one, instead of the linear guess."""


class FitOptions(TypedDict, total=False):
    """Options of fit."""

    source_points: ArrayLike | None
    """Where on the source each marker is, where that is not at its vertices; a marker's source vertex then
    only names it."""
    curves: Sequence[tuple[ArrayLike, ArrayLike]] | None
    """Edge paths of the source, each with one of the target that belongs to it: rims of lids, lips. One that
    ends with its first vertex is closed. They are matched by length between the markers that lie on both."""
    marker_tolerance: float
    """How far off markers may be: they pull at first and are released in the end. 0 takes them as exact."""
    smoothness: float
    """How much neighbouring triangles must change alike."""
    identity: float
    """How much triangles must keep their shape and orientation."""
    closest: float
    """How tightly the source is pulled onto the target in the end."""
    steps: int
    """How many pulls it takes from 1 to the tightest, each of which costs a factorization."""
    rounds: int
    """Rounds of closest points at each pull."""
    match_distance: float
    """How far the centre of a triangle may be from the other surface to be matched there."""
    modes: ArrayLike | None
    """How people of the source's kind differ from it, most of all first: offsets of its vertices, as long as
    they spread. The fit begins at the one that the target looks like."""
    most_turn: float
    """Without markers, by how much the target is turned against the source at most; 180 for any way."""
    overlap: bool
    """The meshes lie on each other as they are, as clothes lie on a body: every place belongs to the closest
    one within `match_distance`, nothing is pulled, and motions keep their size. Takes no markers."""
    source_mask: ArrayLike | None
    """Vertices of the source that match nothing: the inside of a mouth, eye sockets."""
    target_mask: ArrayLike | None
    """Vertices of the target that match nothing."""


class TransferOptions(TypedDict, total=False):
    """Options of transfer."""

    unmatched: Literal["follow", "rest"]
    """What components of the target do that no part of the source matches, such as eyes and teeth."""
    weighting: Literal["area", "pairs"]
    """How much each triangle of the target counts."""
    scale: Literal["target", "source"]
    """How far the target goes for what the source does."""
    frames: Literal["global", "local"]
    """In which directions a place of the target moves."""
    anchor: float
    """The length below which gradients rule and beyond it displacements: lower suits shapes that are much
    alike, inf is gradients alone."""
    contact: bool
    """Openings of another height that close on the source, as lids do in a blink, close by the same part of
    it on the target, and slide around closed convex parts, as eyes are."""
    stretch: float
    """How many times as long as at rest edges of the target get at most, unless the source is stretched as
    much there; inf for any."""


class LearnOptions(TypedDict, total=False):
    """Options of learn."""

    strength: float
    """How much of what is learned is taken."""
    reach: float
    """How far around a correction it counts."""


class PathOptions(TypedDict, total=False):
    """Options of inbetween."""

    stretch: Literal["linear", "logarithmic"]
    """How triangles grow and shrink along the path."""
    refinement: int
    """Rounds in which turns are fitted to the shapes that came out, by a radian at most: lengths along the
    path get up to twice as good in 4 to 16."""
    through: Sequence[tuple[float, ArrayLike]] | None
    """Shapes to hit on the way, each (time, positions), in ascending order; speed may change there."""
    preserve_volume: bool
    """Closed components keep their volume: it changes in equal steps and none is lost between the ends."""
    clearance: Mesh | None
    """A closed mesh in the same units, as an eyeball under a lid, that no vertex enters deeper than at the
    deeper of its ends, or comes closer to than at the closer one."""
    clearance_end: ArrayLike | None
    """Where the vertices of that mesh are at the end, if they move."""
    mirror: Sequence[tuple[ArrayLike, ArrayLike]] | None
    """Planes, each (point, normal), that complete half shapes by their mirror image: vertices on them in all
    shapes stay on them."""
    mirror_tolerance: float
    """How far a vertex may be from its mirror image to be on the plane."""


class BlendOptions(TypedDict, total=False):
    """Options of blend."""

    refinement: int
    """Rounds in which turns are fitted to the shape that came out."""


class ImageMeshOptions(TypedDict, total=False):
    """Options of image_mesh."""

    edge: float
    """Wanted length of edges; 0 takes a 25th of the square root of the opaque area, some 1500 triangles, and
    no less than a pixel."""
    threshold: float
    """Alpha from which on a place is part of the drawing."""
    tolerance: float
    """How far the outline may go from the alpha's: larger is smoother, with fewer small triangles."""
    smallest: float
    """Islands and holes of less area are left out."""
