"""Operators with long work: what follows a job may begin another."""

import bpy
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.core.work import Work
from bl_ext.user_default.lissom.operators.job import JobOperator


def _nothing():
    return
    yield


def test_what_follows_a_job_does_not_wait_for_it():
    class Probe(JobOperator):
        def finish(self, context, found):
            self.seen = session.work, bpy.ops.lissom.face_keys.poll()

    scene.monkey(1)
    probe = Probe()
    session.work, probe._history = Work(_nothing()), session.history
    probe._scene = bpy.context.scene.session_uid
    try:
        assert not bpy.ops.lissom.face_keys.poll()
        probe._tick(bpy.context)
    finally:
        session.work = None
    assert probe.seen == (None, True)
