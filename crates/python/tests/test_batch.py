"""Batches of worlds."""

import numpy as np
import pytest
import usarsim


def test_a_batch_has_the_bits_of_worlds_alone(world):
    batch = usarsim.Batch(world, 8, orders="wheels", observations=["position", "wheel_speeds", "sensor:GndTruth"])
    assert len(batch) == 8 and batch.order_width == 4
    orders = np.random.default_rng(0).uniform(-5, 5, (10, 8, 4))
    for row in orders:
        seen = batch.step(row, 5)
    columns = {name: slice(first, end) for _, name, first, end in batch.columns}
    for number in range(8):
        alone = world.copy()
        for row in orders:
            alone.robots[0].drive_wheels(list(row[number]))
            alone.step(5)
        assert alone.digest == batch.digests[number]
        assert np.array_equal(seen[number, columns["position"]], alone.robots[0].position)
        truth = alone.robots[0].readings["GndTruth"]
        assert np.array_equal(seen[number, columns["sensor:GndTruth"]][:3], truth["position"])


def test_observations_are_one_array(world):
    batch = usarsim.Batch(world, 3)
    first = batch.step(np.ones((3, 4)), 10)
    assert first is batch.observations
    before = first.copy()
    assert batch.step(np.ones((3, 4)), 10) is first and not np.array_equal(before, first)
    batch.reset(np.array([True, False, False]))
    assert np.array_equal(first[0, :2], [0, 0]) and first[1, 0] > 0.001


@pytest.mark.parametrize(
    ("act", "text"),
    [
        (lambda world: usarsim.Batch(world, 0), "got 0 worlds"),
        (lambda world: usarsim.Batch(world, 10**12), "at most"),
        (lambda world: usarsim.Batch(world, 2, orders="wheel"), "did you mean `wheels`"),
        (lambda world: usarsim.Batch(world, 2, observations=["sensor:Eye"]), "unknown sensor"),
        (lambda world: usarsim.Batch(world, 2).step(np.ones((2, 3))), r"expected \[2, 4\]"),
        (lambda world: usarsim.Batch(world, 2).step(np.ones((4, 8))[::2, ::2]), "contiguous"),
        (lambda world: usarsim.Batch(world, 2).step(np.asfortranarray(np.ones((2, 4)))), "in C order"),
        (lambda world: usarsim.Batch(world, 2).step(np.ones((4, 2)).T), "in C order"),
        (lambda world: usarsim.Batch(world, 2).world(2), "expected less than 2"),
        (lambda world: usarsim.Batch(world, 2).column("objects"), "has no observations"),
        (lambda world: usarsim.Batch(world, 2).step(np.full((2, 4), np.nan)), "2 worlds were not followed"),
        (lambda world: usarsim.Batch(world, 2).reset(np.array([True])), "expected 2"),
    ],
)
def test_bad_arrays_raise(world, act, text):
    with pytest.raises(usarsim.TaskError, match=text):
        act(world)


def test_arrays_of_another_type_raise(world):
    with pytest.raises(TypeError):
        usarsim.Batch(world, 2).step(np.ones((2, 4), np.int32))


def test_worlds_and_columns_can_be_taken_out(world):
    batch = usarsim.Batch(world, 2, observations=["velocity", "position"])
    batch.step(np.array([[1.0] * 4, [2.0] * 4]), 50)
    one = batch.world(1)
    assert one.digest == batch.digests[1] and one.digest != world.digest
    assert np.array_equal(batch.observations[1, batch.column("position")], one.robots[0].position)
    one.robots[0].drive_wheels([0] * 4)
    one.run(1.0)
    assert batch.world(1).digest == batch.digests[1], "a copy is independent"
