"""Every call with any of its options, on meshes of all kinds: finite or a typed error, and again the same.

The options are drawn from what the core says of them, so that a new one is tried without a line here. A bug
of ours, a panic or what takes longer than half a minute fails; `make fuzz` draws for as long as one lets it.
"""

import warnings

import lissom
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from random_meshes import crowds, meshes, motions, points

ANY = meshes(crowds())
# What may be asked of a mesh of any kind; others say no, by a typed error that is not InternalError.
REFUSED = (
    lissom.InvalidMesh,
    lissom.InvalidConstraint,
    lissom.InvalidValue,
    lissom.SolveFailed,
    lissom.OutOfMemory,
)


def number(option):
    """A number in the option's range, most often of a usual size; counts that cost time stay small."""
    if option.kind == "int":
        return st.integers(option.low or 0, min(option.high or 4, (option.low or 0) + 4))
    low = option.low if option.low is not None else -1e12
    high = option.high if option.high is not None and np.isfinite(option.high) else max(low, 1.0) * 1e12
    bounds = {"exclude_min": option.low_open, "exclude_max": option.high_open and high == option.high}
    usual = option.default if option.default is not None else 1.0
    return st.floats(low, high, allow_subnormal=False, **bounds) | st.just(usual)


def value(option, vertices):
    """What the option takes, for a mesh with these vertices; None for what only a pair of meshes can tell."""
    n = len(vertices)
    if option.kind in ("int", "float"):
        return number(option)
    if option.kind == "bool":
        return st.booleans()
    if option.kind == "choice":
        return st.sampled_from([name for name, _ in option.choices])
    if option.kind == "vertices":
        return st.lists(st.integers(0, n - 1), max_size=n, unique=True)
    if option.kind == "planes":
        normal = st.sampled_from([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 2.0, -3.0)])
        return st.lists(st.tuples(st.sampled_from([(0.0, 0.0, 0.0), tuple(vertices[0])]), normal), max_size=2)
    if option.kind == "shapes":
        return points(n).map(lambda shape: [(0.5, shape)])
    if option.kind == "modes":
        return hnp.arrays(float, (2, n, 3), elements=st.floats(-1, 1, allow_subnormal=False))
    return None


def options(draw, owner, vertices, leave=()):
    """Some of the options of a call, each within its range."""
    every = {o.name: value(o, vertices) for o in lissom.options(owner) if o.name not in leave}
    offered = {name: values for name, values in every.items() if values is not None}
    chosen = draw(st.lists(st.sampled_from(sorted(offered)), max_size=4, unique=True)) if offered else []
    return {name: draw(offered[name]) for name in chosen}


def twice(call):
    """What a call returns, the same both times; `None` where it refuses."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            first = call()
        except REFUSED:
            return None
        second = call()
    for one, other in zip(first, second, strict=True):
        assert np.isfinite(one).all()
        assert np.array_equal(one, other)
    return first


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
@given(ANY, st.data())
def test_row_38_poses(method, drawn, data):
    mesh, vertices, _ = drawn
    n = len(vertices)
    order = np.random.default_rng(data.draw(st.integers(0, 99))).permutation(n)
    held = data.draw(st.integers(2, n))
    handles = [order[: held // 2], order[held // 2 : held]]
    roi = order[: data.draw(st.integers(held, n))]
    asked = options(data.draw, "pose", vertices, {"method"})
    asked |= options(data.draw, f"pose.{method}", vertices)
    solving = {"max_iterations": 20} | options(data.draw, "pose.solve", vertices)
    transforms = [np.eye(4), data.draw(motions())]
    by_itself = data.draw(st.none() | st.just([1]))

    def solve():
        pose = lissom.Pose(mesh, handles, roi, method, **asked)
        return (pose.solve(transforms, by_itself=by_itself, **solving).vertices,)

    result = twice(solve)
    if result and not asked.get("symmetry"):
        outside = np.setdiff1d(np.arange(n), roi)
        assert np.array_equal(result[0][outside], vertices[outside])


@given(ANY, ANY, st.data())
def test_row_38_fits_and_transfers(source, target, data):
    (source, rest, _), (target, vertices, _) = source, target
    assume(len(rest) + len(vertices) < 2000)
    count = data.draw(st.integers(0, min(6, len(rest), len(vertices))))
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    markers = np.column_stack([rng.permutation(len(p))[:count] for p in (rest, vertices)])
    fitting = {"steps": 2, "rounds": 2} | options(data.draw, "fit", rest, {"target_mask"})
    transferring = options(data.draw, "transfer", vertices)
    keys = np.stack([rest, rest + np.ptp(rest) * 0.1 * rng.normal(size=rest.shape)])
    values = rng.random((len(rest), 2))

    def carry():
        fit = lissom.fit_correspondence(source, target, markers if count else None, **fitting)
        transfer = lissom.Transfer(source, target, fit, **transferring)
        carried = transfer.apply(keys).vertices
        transfer.quality(keys, carried)
        return fit.fitted_vertices, carried, transfer.attributes(values)

    result = twice(carry)
    if result:
        assert np.array_equal(result[1][0], vertices), "a key that is at rest"


@given(ANY, st.data())
def test_row_38_paths_and_their_keys(drawn, data):
    mesh, start, _ = drawn
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    turn = data.draw(motions())
    end = start @ turn[:3, :3].T + np.ptp(start) * data.draw(st.sampled_from([0.0, 0.1])) * rng.normal(
        size=start.shape
    )
    asked = options(data.draw, "inbetween", start)
    count = data.draw(st.integers(2, 6))

    def play():
        path = lissom.Inbetween(mesh, start, end, **asked)
        times = path.keyframes(count=count).times
        return path.at([0.0, 0.3, 1.0]), times

    result = twice(play)
    if result:
        assert np.array_equal(result[0][[0, -1]], [start, end])
        assert result[1][0] == 0.0 and result[1][-1] == 1.0


@given(ANY, st.data())
def test_row_38_blends(drawn, data):
    mesh, rest, _ = drawn
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    keys = rest + np.ptp(rest) * 0.1 * rng.normal(size=(2, *rest.shape))
    weights = data.draw(hnp.arrays(float, 2, elements=st.floats(-2, 2, allow_subnormal=False)))
    asked = options(data.draw, "blend", rest)
    twice(lambda: (lissom.Blend(mesh, rest, keys, **asked).at(weights),))


@given(
    hnp.arrays(float, hnp.array_shapes(min_dims=2, max_dims=2, max_side=24), elements=st.floats(0, 1)),
    st.data(),
)
def test_row_38_meshes_of_images(alpha, data):
    asked = options(data.draw, "image_mesh", np.zeros((1, 3)))
    result = twice(lambda: tuple(lissom.image_mesh(alpha, **asked)))
    if result:
        vertices, faces = result[0], result[1]
        assert faces.max(initial=-1) < len(vertices)
