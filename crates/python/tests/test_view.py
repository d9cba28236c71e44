"""The live page of a world."""

import json
import time
import urllib.request

import pytest
import usarsim
from websockets.sync.client import connect

# First byte of a binary message whose content is a scan: the field's number and wire type (live.proto).
SCAN_TAG = 2 << 3 | 2


def messages(view, count):
    """The first status and frames that a viewer gets."""
    address = view.url.replace("http", "ws") + "live"
    with connect(address, additional_headers={"Origin": view.url.rstrip("/")}, max_size=None) as socket:
        return [socket.recv(timeout=10) for _ in range(count)]


def test_a_page_shows_the_world_while_it_is_stepped(world):
    view = world.show(height=300)
    assert "iframe" in view._repr_html_() and 'height="300"' in view._repr_html_() and view.url in repr(view)
    with urllib.request.urlopen(view.url, timeout=10) as page:
        policy = page.headers["Content-Security-Policy"]
        assert b"<html" in page.read().lower()
    assert "frame-ancestors http://localhost:*" in policy and "default-src 'self'" in policy
    scene = json.load(urllib.request.urlopen(view.url + "scene.json", timeout=10))
    assert scene["map"]["name"] == "rough"
    first = messages(view, 8)
    status = next(json.loads(it)["status"] for it in first if isinstance(it, str) and "status" in json.loads(it))
    assert [(robot["class"], robot["name"]) for robot in status["robots"]] == [("KUKA_YouBot", "Bot")]
    assert any("refused" in json.loads(it) for it in first if isinstance(it, str)), "it may not control"
    frames = [it for it in first if isinstance(it, bytes)]
    world.robots[0].drive_twist(forward=0.5)
    world.run(1.0)
    later = [it for it in messages(view, 8) if isinstance(it, bytes)]
    assert frames and later and frames[-1] != later[-1], "the robot has moved"
    assert world.show().url == view.url
    view.close()
    with pytest.raises(OSError):
        urllib.request.urlopen(view.url, timeout=2)
    world.run(0.1)


def test_the_page_shows_the_beams_of_a_laser(world):
    laser = world.spawn("P3AT", position=(0, 3, 0))
    view = world.show()
    address, origin = view.url.replace("http", "ws") + "live", {"Origin": view.url.rstrip("/")}
    with connect(address, additional_headers=origin, max_size=None) as socket:
        seen = []
        while not (scans := [it for it in seen if it[0] == SCAN_TAG]) and len(seen) < 1000:
            world.run(0.1)
            seen += [it for it in (socket.recv(timeout=10) for _ in range(2)) if isinstance(it, bytes)]
    assert scans and len(scans[0]) > len(laser.reading("lms200")["ranges"]), "two bytes a beam"


def test_a_world_that_is_shown_has_the_same_bits(world):
    other = world.copy()
    world.show()
    for one in (world, other):
        one.robots[0].drive_twist(right=0.3)
        one.run(1.0)
    assert world.digest == other.digest


def test_a_world_keeps_to_a_pace(world):
    start = time.monotonic()
    world.run(0.6, real_time_factor=2.0)
    took = time.monotonic() - start
    assert world.time == pytest.approx(0.6) and 0.25 < took < 2.0
    for factor in (0, -1, float("nan"), 1e9):
        with pytest.raises(usarsim.CommandError, match="expected 0.001 to 1000"):
            world.run(1.0, real_time_factor=factor)


def test_a_port_that_is_taken_is_an_error(world):
    view = world.show()
    port = int(view.url.rstrip("/").rsplit(":", 1)[1])
    with pytest.raises(usarsim.CommandError, match="cannot listen"):
        world.copy().show(port=port)
