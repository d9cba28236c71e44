"""What the tests of the package share."""

import pytest
import usarsim


@pytest.fixture(scope="session")
def scene():
    """The bare floor with every shipped class."""
    return usarsim.Scene("rough", drive_model="analytic")


@pytest.fixture
def world(scene):
    """A world with a youBot in the middle."""
    world = usarsim.World(scene, time_step=0.004)
    world.spawn("KUKA_YouBot", position=(0, 0, 0), name="Bot")
    return world
