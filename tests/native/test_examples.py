"""The examples run, and show what they say."""

import numpy as np
from lissom import examples


def test_the_examples_run_and_write_what_they_make(tmp_path, capsys):
    examples.main([str(tmp_path)])
    assert [line.split(":")[0] for line in capsys.readouterr().out.splitlines()] == [
        "pose",
        "transfer",
        "in-between",
    ]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["inbetween.obj", "pose.obj", "transfer.obj"]
    bent = examples.pose()
    top = examples.tube()[0][-24:]
    turned = np.c_[top, np.ones(24)] @ examples.turn(90, at=3).T
    np.testing.assert_allclose(bent[-24:], turned[:, :3], atol=1e-12)
    leaning = examples.transfer(bent)
    assert np.linalg.norm(leaning[-31:].mean(axis=0) - bent[-24:].mean(axis=0)) < 0.8
