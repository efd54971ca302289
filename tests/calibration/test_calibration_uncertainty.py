"""Standard deviations are worth their name: the truth lies within 1.96 of them about 95 times in 100."""

import numpy as np

from calibration.bundle import adjust
from calibration.equations import PER_CAMERA
from calibration.rig import BoardShape, Observation, Prior, Rig
from calibration.solving import PRIOR, RIGID

RUNS, VIEWS = 24, 8


def test_the_truth_lies_within_95_percent_bounds_95_times_in_100(known_bench):
    bench = known_bench(seed=5)
    names = list(bench.cameras)
    poses = np.array(list(bench.poses(VIEWS)))
    truth = Rig(
        np.array([[*one.K[[0, 1, 0, 1], [0, 1, 2, 2]], *one.distortion] for one in bench.cameras.values()]),
        np.array([one.camera_from_rig for one in bench.cameras.values()]),
        poses,
        BoardShape.of(bench.board.points_mm),
    )
    scores = []
    for run in range(RUNS):
        noise_px = (0.03, 0.08) if run % 2 else (0.05, 0.05)
        solved = adjust(truth, observed(bench, names, poses, noise_px), PRIOR, np.array(noise_px))
        sigma = np.sqrt(np.diag(solved.covariance))[: 2 * PER_CAMERA].reshape(2, PER_CAMERA)
        scores.append((solved.rig.intrinsics - truth.intrinsics) / sigma[:, :9])
        place = solved.rig.camera_from_rig[1, :3, 3] - truth.camera_from_rig[1, :3, 3]
        scores.append((place / sigma[1, 12:])[None])
        np.testing.assert_allclose(solved.noise_px, noise_px, rtol=0.3)
    within = np.mean(np.abs(np.concatenate([one.ravel() for one in scores])) < 1.96)
    assert 0.915 < within < 0.985


def test_what_the_views_do_not_show_keeps_to_the_prior_and_says_so(known_bench):
    bench = known_bench(seed=6)
    poses = np.array(list(bench.poses(6, spread=0.02)))
    names = list(bench.cameras)
    nothing = Prior(np.full(9, np.inf))
    start = Rig(
        np.array([[*one.K[[0, 1, 0, 1], [0, 1, 2, 2]], *one.distortion] for one in bench.cameras.values()]),
        np.array([one.camera_from_rig for one in bench.cameras.values()]),
        poses,
    )
    seen = observed(bench, names, poses, (0.3, 0.3))
    open_k3, held_k3 = (adjust(start, seen, prior).covariance[8, 8] ** 0.5 for prior in (nothing, RIGID))
    assert held_k3 < 0.25 < open_k3


def observed(bench, names, poses, noise_px):
    ids = np.arange(len(bench.board.points_mm))
    return [
        Observation(
            camera,
            view,
            ids,
            bench.board.points_mm,
            bench.true_px(name, pose) + bench.random.normal(0, noise_px[camera], (len(ids), 2)),
        )
        for view, pose in enumerate(poses)
        for camera, name in enumerate(names)
    ]
