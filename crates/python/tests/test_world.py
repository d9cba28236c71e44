"""Worlds, robots, readings, pictures, saves and logs."""

import copy
import json
import pickle
import signal
import threading
import warnings

import numpy as np
import pytest
import usarsim


def test_a_youbot_drives_as_the_kinematics_say(world):
    robot = world.robots[0]
    robot.drive_wheels([4, 4, 4, 4])
    world.run(1.0)
    start = robot.position[0]
    angles = robot.wheel_angles
    world.run(2.0)
    turned = np.mean(robot.wheel_angles - angles)
    assert robot.position[0] - start == pytest.approx(0.05 * turned, rel=1e-3)
    assert robot.velocity[0] == pytest.approx(0.2, rel=0.05)


def test_state_has_documented_shapes(world):
    robot = world.robots[0]
    world.run(0.5)
    assert robot.position.shape == robot.velocity.shape == robot.angular_velocity.shape == (3,)
    assert robot.orientation.shape == (4,) and np.linalg.norm(robot.orientation) == pytest.approx(1)
    assert robot.rotation.shape == (3,)
    assert len(robot.joint_names) == len(robot.joint_positions) == len(robot.joint_speeds)
    assert robot.wheel_names == ["FLWheel", "FRWheel", "BLWheel", "BRWheel"]
    points, forces = robot.contacts
    assert points.shape == forces.shape and points.shape[1] == 3
    mass = sum(part["mass"] for link in usarsim.describe(world.scene, "KUKA_YouBot")["links"] for part in link["parts"])
    assert -forces[:, 2].sum() > 9 * mass, "the floor carries it"
    grip = robot.grip
    shapes = {key: values.shape[1:] for key, values in grip.items()}
    assert shapes == {"wheels": (), "slips": (3,), "friction_used": (), "patches": (2,)}
    assert all(len(values) == len(points) for values in grip.values())
    assert set(grip["wheels"]) == {0, 1, 2, 3} and not grip["patches"].any()


def test_a_robot_that_turns_slides_and_has_an_effective_track():
    world = usarsim.World(usarsim.Scene("rough"))
    robot = world.spawn("P3AT")
    world.run(0.5)
    assert robot.effective_track is None and robot.grip["friction_used"].max() < 0.1
    robot.drive_sides(left=1, right=-1)
    world.run(2.0)
    (points, forces), grip = robot.contacts, robot.grip
    assert (grip["friction_used"] > 0.99).all()
    # Friction pushes against the slip.
    push = (forces * grip["slips"])[:, :2].sum(axis=1)
    reach = np.linalg.norm(forces[:, :2], axis=1) * np.linalg.norm(grip["slips"], axis=1)
    assert (push < -0.98 * reach).all()
    # Four equal loads on points would give 1 + (wheelbase / track) ** 2, which is 1.475. Its front axle carries more.
    chi = robot.effective_track / 0.36
    assert chi == pytest.approx(1.444, rel=0.005)


def test_readings_are_those_of_the_state(world):
    robot = world.robots[0]
    assert robot.reading("GndTruth") is None, "nothing is measured yet"
    robot.drive_twist(right=0.3)
    world.run(1.0)
    truth = robot.readings["GndTruth"]
    assert truth.time == pytest.approx(1.0) and truth.type == "GroundTruth" and truth.units["position"] == "m"
    assert np.array_equal(truth["position"], robot.position)
    with pytest.raises(KeyError, match="expected one of position"):
        truth["place"]


def test_the_last_reading_of_a_laser_is_an_array(scene):
    world = usarsim.World(usarsim.Scene("hall"), time_step=0.01)
    robot = world.spawn("P3AT")
    world.run(0.5)
    ranges = robot.readings["lms200"]["ranges"]
    assert ranges.shape == (181,) and 0 < ranges.min() < 10


def test_copies_and_saves_go_on_with_the_same_bits(world):
    world.robots[0].drive_twist(forward=0.3, clockwise=0.5)
    world.run(0.5)
    saved, twins = world.save(), [world.copy(), copy.copy(world), copy.deepcopy(world)]
    twins.append(usarsim.World.load(world.scene, saved))
    for one in [world, *twins]:
        one.robots[0].drive_twist(right=0.2)
        one.run(1.0)
    assert len({one.digest for one in [world, *twins]}) == 1
    assert twins[-1].robots[0].name == "Bot"
    twins[0].robots[0].remove()
    assert len(world.robots) == 1, "a copy is independent"


def test_a_log_replays_with_the_same_bits(scene, tmp_path):
    path = tmp_path / "run.mcap"
    with usarsim.World(scene, seed=3, log=path) as world:
        robots = [world.spawn("KUKA_YouBot", position=(0, y, 0), name=f"R{y}") for y in (0, 1)]
        robots[0].drive_twist(forward=0.123456789)
        robots[1].drive_wheels([1 / 3, 2, -1e-3, 7])
        world.run(1.0)
        robots[0].remove()
        world.run(0.5)
        with pytest.raises(usarsim.CommandError, match="would not replay"):
            world.put_object("x", (0, 0, 0))
        digest = world.digest
    again = usarsim.replay(path)
    assert again["same"] and again["digest"] == digest and again["states"] > 100
    with pytest.raises(usarsim.LogError):
        usarsim.World(scene, log=tmp_path / "none" / "run.mcap")
    path.write_bytes(b"nonsense")
    with pytest.raises(usarsim.LogError):
        usarsim.replay(path)


def test_pictures_are_arrays_that_notebooks_show(world, tmp_path):
    world.run(0.1)
    picture = world.picture((160, 120))
    assert picture.shape == (120, 160, 3) and picture.dtype == np.uint8 and picture.std() > 5
    assert picture._repr_png_().startswith(b"\x89PNG")
    picture.save(tmp_path / "robot.png")
    assert (tmp_path / "robot.png").read_bytes() == picture.to_png()
    assert picture[0]._repr_png_() is None, "a row is no picture"
    from_above = world.picture((160, 120), eye=(0, 0, -3), target=(0, 0.001, 0))
    assert not np.array_equal(picture, from_above)


def test_a_camera_sees_what_is_in_front_of_it():
    world = usarsim.World(usarsim.Scene("hall"), time_step=0.01)
    robot = world.spawn("P3AT")
    world.run(0.3)
    seen = robot.camera()
    assert seen.shape == (240, 320, 3)
    robot.drive_sides(2, -2)
    world.run(2.0)
    assert not np.array_equal(seen, robot.camera())
    assert robot.camera("Camera", (64, 48)).shape == (48, 64, 3)
    with pytest.raises(usarsim.CommandError, match="is no camera"):
        robot.camera("lms200")


def test_an_arm_moves_its_joints():
    world = usarsim.World(usarsim.Scene("rough"))
    robot = world.spawn("YouBotArm", position=(0, 0, 0))
    robot.move_joints({"ArmJoint2": 0.5, "armjoint3": -0.5})
    world.run(2.0)
    angles = dict(zip(robot.joint_names, robot.joint_positions))
    assert angles["ArmJoint2"] == pytest.approx(0.5, abs=0.01)
    assert angles["ArmJoint3"] == pytest.approx(-0.5, abs=0.01)
    assert robot.send("SET {Type Gripper} {Name Gripper} {Opcode Open}") == []
    with pytest.raises(usarsim.CommandError, match="ArmJoint9"):
        robot.move_joints({"ArmJoint9": 0})


def test_a_line_is_answered(world):
    robot = world.spawn("P3AT", position=(0, 3, 0))
    (conf,) = robot.send("GETCONF {Type RangeScanner}")
    assert conf.startswith("CONF {Type RangeScanner} {Name lms200}")
    (geo,) = robot.send("GETGEO {Type Robot}")
    assert geo.startswith("GEO {Type GroundVehicle} {Name P3AT}")
    assert robot.send("DRIVE {Left 1} {Right 1}") == []


def test_sensors_of_one_name_are_told_apart(tmp_path):
    (tmp_path / "Twin").mkdir()
    sensor = '[[sensor]]\nclass = "HokuyoURG04LX"\nname = "laser"\nposition = [{x}, 0.0, -0.3]\n'
    robot = 'like = "P3AT"\ndescription = "Two lasers"\n' + sensor.format(x=0.2) + sensor.format(x=-0.4)
    (tmp_path / "Twin" / "robot.toml").write_text(robot)
    world = usarsim.World(usarsim.Scene("hall", robots=[tmp_path / "Twin"]), time_step=0.01)
    twin = world.spawn("Twin")
    assert twin.sensor_names == ["laser", "laser#2"]
    world.run(0.5)
    front, back = twin.readings["laser"]["ranges"], twin.reading("LASER#2")["ranges"]
    assert front.shape == back.shape and not np.allclose(front, back, atol=0.3)
    columns = usarsim.Batch(world, 2, observations=["sensor:laser", "sensor:laser#2"], orders="wheels").columns
    assert [name for _, name, _, _ in columns] == ["sensor:laser", "sensor:laser#2"]


def test_objects_come_and_go(scene, tmp_path):
    world = usarsim.World(scene, time_step=0.004, log=tmp_path / "objects.mcap")
    robot = world.spawn("KUKA_YouBot", position=(0, 0, 0))
    crate = world.create_object("WCCrate", "box", position=(0.75, 0, -0.25), scale=(1, 1, 0.5))
    assert (crate.name, crate.mass) == ("box", 2.5)
    robot.drive_twist(forward=0.3)
    world.run(2.0)
    (box,) = world.objects
    assert box.position[0] > 0.9, "the robot pushes it"
    wall = world.create_object("WCCrate", "wall", position=(0, 2, -0.25), rigid=False, material="carpet")
    assert world.control("CONTROL {Type RelMove} {Name wall} {Location 0,1,0}") == []
    assert world.control("CONTROL {Type GetSTA} {Name wall}")[0].startswith("STA {Name wall} {Size 0.5000,0.5000")
    assert [round(float(it.position[1]), 2) for it in world.objects if it.name == wall.name] == [3.0]
    world.remove_object("box")
    world.run(0.5)
    assert [it.name for it in world.objects] == ["wall"] and len(world.robots) == 1
    world.close()
    assert usarsim.replay(tmp_path / "objects.mcap")["same"]


def test_objects_outlive_a_save(scene):
    world = usarsim.World(scene, time_step=0.004)
    world.create_object("WCCrate", "box", position=(0.75, 0, -0.25))
    copied, loaded = world.copy(), usarsim.World.load(scene, world.save())
    for one in (copied, loaded):
        one.remove_object("box")
        assert one.objects == []
        one.create_object("WCCrate", "box", position=(1, 0, -0.25))
    assert len(world.objects) == 1


def test_what_is_wrong_with_an_object_is_said(scene):
    world = usarsim.World(scene, time_step=0.004)
    world.spawn("KUKA_YouBot", position=(0, 0, 0))
    world.create_object("WCCrate", "box", position=(2, 0, -0.25))
    for wrong, said in (
        (("WCCrat", "a", (1, 1, 0)), "did you mean `WCCrate`"),
        (("WCCrate", "BOX", (1, 1, 0)), "an object `BOX` already"),
        (("WCCrate", "", (1, 1, 0)), "expected a name"),
        (("WCCrate", "a} {Permanent True", (1, 1, 0)), "without braces"),
        (("WCCrate", "a", (0, 0, -0.1)), "is there"),
        (("WCCrate", "a", (float("inf"), 0, 0)), "expected finite"),
        (("WCCrate", "a", (1e9, 0, 0)), "expected"),
    ):
        with pytest.raises(usarsim.CommandError, match=said):
            world.create_object(*wrong)
    with pytest.warns(usarsim.UsarsimWarning, match="no material `cheese`"):
        world.create_object("WCCrate", "a", position=(0, 3, -0.25), material="cheese")
    with pytest.raises(usarsim.CommandError, match="unknown object `b`: expected one of"):
        world.remove_object("b")
    with pytest.raises(usarsim.CommandError):
        world.control("CONTROL {Type Kill} {Name nothing}")
    assert [it.name for it in world.objects] == ["box", "a"]


def test_worlds_scenes_and_robots_can_be_pickled(world, tmp_path):
    robot = world.robots[0]
    robot.drive_twist(forward=0.3)
    world.run(0.5)
    again, its = pickle.loads(pickle.dumps((world, robot)))
    assert its == again.robots[0] and its.class_name == "KUKA_YouBot"
    for one in (world, again):
        one.run(0.5)
    assert again.digest == world.digest
    for name in usarsim.maps():
        scene = usarsim.Scene(name)
        other = pickle.loads(pickle.dumps(scene))
        assert usarsim.describe(other) == usarsim.describe(scene) and other.classes == scene.classes
    with pytest.raises(usarsim.SaveError, match="bodies"):
        engine = usarsim.World(usarsim.Scene("rough"))
        engine.spawn("KUKA_YouBot", position=(0, 0, 0))
        pickle.dumps(engine)
    with pytest.raises(usarsim.SceneError, match="not a pickled scene"):
        usarsim.Scene._from_bytes(b"{}")


def test_an_object_can_be_put_elsewhere():
    world = usarsim.World(usarsim.Scene("hall"), time_step=0.01)
    name = world.objects[0].name
    world.put_object(name, (1.0, 2.0, -1.0))
    assert np.array_equal(world.objects[0].position, (1.0, 2.0, -1.0))
    world.run(2.0)
    assert world.objects[0].position[2] > -1.0, "it fell"
    with pytest.raises(usarsim.CommandError, match="expected one of"):
        world.put_object("nothing", (0, 0, 0))
    with pytest.raises(usarsim.CommandError, match="on the map"):
        world.put_object(name, (1e9, 0, 0))


def test_a_robot_from_a_urdf_and_overrides(tmp_path):
    scene = usarsim.Scene("rough", set=["P3AT.wheels.max_speed=1.5"])
    world = usarsim.World(scene)
    robot = world.spawn("P3AT", position=(0, 0, 0))
    robot.drive_sides(100, 100)
    world.run(2.0)
    assert robot.wheel_speeds.max() == pytest.approx(1.5, abs=0.05)
    wheel = '<link name="{0}"><inertial><mass value="0.5"/><inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>' \
        '<collision><geometry><cylinder radius="0.1" length="0.05"/></geometry></collision></link>' \
        '<joint name="{0}_joint" type="continuous"><parent link="base_link"/><child link="{0}"/><origin xyz="{1} {2} 0" rpy="-1.5708 0 0"/><axis xyz="0 0 1"/></joint>'
    wheels = "".join(wheel.format(f"{end}_{side}_wheel", x, y) for end, x in (("front", 0.2), ("rear", -0.2)) for side, y in (("left", 0.2), ("right", -0.2)))
    (tmp_path / "cart.urdf").write_text(
        '<robot name="cart"><link name="base_link"><inertial><mass value="10"/><inertia ixx="0.1" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial>'
        f'<collision><geometry><box size="0.5 0.3 0.1"/></geometry></collision></link>{wheels}</robot>'
    )
    world = usarsim.World(usarsim.Scene("rough", robots=[tmp_path / "cart.urdf"]))
    cart = world.spawn("cart", position=(0, 0, 0))
    cart.drive_sides(2, 2)
    world.run(2.0)
    assert cart.position[0] > 0.3


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda: usarsim.Scene("arnea"), usarsim.SceneError, "did you mean `arena`"),
        (lambda: usarsim.Scene("rough", robots=["/nowhere.toml"]), usarsim.SceneError, "nowhere"),
        (lambda: usarsim.Scene("rough", set=["P3AT.nothing=1"]), usarsim.SceneError, "P3AT.nothing=1"),
        (lambda: usarsim.Scene("rough", drive_model="magic"), usarsim.SceneError, "magic"),
        (lambda: usarsim.Scene("rough", equipment="nothing"), usarsim.SceneError, "nothing"),
        (lambda: usarsim.World(usarsim.Scene("rough"), time_step=1.0), usarsim.SceneError, "expected 0.0001 to 0.02"),
        (lambda: usarsim.World(usarsim.Scene("rough"), time_step=float("nan")), usarsim.SceneError, "expected 0.0001"),
        (lambda: usarsim.World(usarsim.Scene("rough"), threads=9999), usarsim.CommandError, "expected 0 to 256"),
        (lambda: usarsim.World.load(usarsim.Scene("rough"), b"{}"), usarsim.SaveError, "missing field"),
        (lambda: usarsim.replay("/nowhere.mcap"), usarsim.LogError, "nowhere"),
        (lambda: usarsim.run_experiment("/nowhere.toml", "/tmp/x"), usarsim.TaskError, "nowhere"),
        (lambda: usarsim.fit("/nowhere.toml"), usarsim.TaskError, "nowhere"),
        (lambda: usarsim.validate("NoBot"), usarsim.SceneError, "NoBot"),
        (lambda: usarsim.validate("P3AT", seconds=1e9), usarsim.TaskError, "expected 1 to 60"),
        (lambda: usarsim.Environments("NoTask"), usarsim.TaskError, "unknown task"),
        (lambda: usarsim.Environments("YouBotReach", 0), usarsim.TaskError, "got 0 worlds"),
    ],
)
def test_bad_input_raises_an_error_that_says_what(make, error, text):
    with pytest.raises(error, match=text) as raised:
        make()
    assert isinstance(raised.value, usarsim.Error)


@pytest.mark.parametrize(
    ("act", "text"),
    [
        (lambda world, robot: world.spawn("P3ATT"), "did you mean"),
        (lambda world, robot: world.spawn("P3AT", start="Nowhere"), "unknown start"),
        (lambda world, robot: world.spawn("P3AT", start="PlayerStart_0", position=(0, 0, 0)), "expected one of them"),
        (lambda world, robot: world.spawn("P3AT", position=(float("nan"), 0, 0)), "expected finite numbers"),
        (lambda world, robot: world.spawn("P3AT", position=(1e9, 0, 0)), "outside the map"),
        (lambda world, robot: world.spawn("P3AT} {Name x"), "without braces"),
        (lambda world, robot: world.spawn("P3AT", name="a}\n{b"), "without braces"),
        (lambda world, robot: robot.drive_wheels([1, 2]), "expected 4"),
        (lambda world, robot: robot.drive_wheels([1, 2, 3, float("inf")]), "expected finite numbers"),
        (lambda world, robot: robot.send("FLY {Up 1}"), "FLY"),
        (lambda world, robot: robot.send("DRIVE {Left 1}\nINIT {ClassName P3AT}"), "expected one line"),
        (lambda world, robot: robot.reading("Eye"), "unknown sensor `Eye`"),
        (lambda world, robot: robot.drive({"Lft": 1}), "no key `Lft` .did you mean `Left`"),
        (lambda world, robot: robot.send("DRIVE {Speed 2}"), "no key `Speed`; expected Front-Left, "),
        (lambda world, robot: robot.send("GETCONF {Type RangeScaner}"), "no such item"),
        (lambda world, robot: world.run(-1), "expected 0 to"),
        (lambda world, robot: world.run(float("nan")), "expected 0 to"),
        (lambda world, robot: world.step(2**60), "at most"),
        (lambda world, robot: world.picture((1, 1)), "expected 16 to 8192"),
    ],
)
def test_a_robot_says_why_it_does_not_obey(world, act, text):
    digest = world.digest
    with pytest.raises(usarsim.CommandError, match=text):
        act(world, world.robots[0])
    assert len(world.robots) == 1 and world.digest == digest, "nothing changed"


def test_a_robot_that_is_gone_says_so(world):
    robot = world.robots[0]
    robot.remove()
    assert not robot.is_alive and "gone" in repr(robot)
    for act in (lambda: robot.position, lambda: robot.drive_wheels([0] * 4), robot.remove, lambda: robot.contacts):
        with pytest.raises(usarsim.CommandError, match="is gone"):
            act()


def test_a_robot_beside_another_is_a_warning(world):
    with pytest.warns(usarsim.UsarsimWarning, match="robot 0 `Bot` takes it"):
        other = world.spawn("KUKA_YouBot", position=(0, 0, 0))
    assert np.linalg.norm(other.position[:2]) > 0.3


def test_a_full_world_refuses_another_robot(scene):
    world = usarsim.World(scene)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for number in range(256):
            world.spawn("P3AT", position=(number % 16, number // 16, 0))
    with pytest.raises(usarsim.CommandError, match="256"):
        world.spawn("P3AT")


def test_other_threads_run_while_it_steps(world):
    done = threading.Event()
    counter = 0

    def count():
        nonlocal counter
        while not done.is_set():
            counter += 1

    thread = threading.Thread(target=count)
    thread.start()
    before = counter
    world.run(20.0)
    after = counter
    done.set()
    thread.join()
    assert after > before + 1000


def test_two_threads_step_two_worlds(scene):
    def play(worlds):
        world = usarsim.World(scene, time_step=0.004)
        world.spawn("KUKA_YouBot", position=(0, 0, 0)).drive_twist(right=0.3)
        for _ in range(100):
            world.step(5)
        worlds.append(world.digest)

    digests = []
    threads = [threading.Thread(target=play, args=(digests,)) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(digests) == 4 and len(set(digests)) == 1


def test_validate_experiment_and_fit_do_what_the_program_does(tmp_path):
    findings = usarsim.validate("P3AT", checks=[1], seconds=2.0)
    assert findings and all(finding["passes"] for finding in findings)
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'description = "P3AT ahead"\nsamples = 2\n[setup]\nmap = "rough"\nrobot = "P3AT"\n'
        'drive = "{Left 1} {Right 1}"\nsteps = 1\nstep_seconds = 1.0\n[tolerances]\nmass = 0.1\n'
    )
    outcomes = usarsim.run_experiment(plan, tmp_path / "out", jobs=2)
    assert len(outcomes) == 2 and outcomes[0]["steps"][0]["main"] > 0.05
    assert (tmp_path / "out" / "report.html").exists()
    assert json.loads((tmp_path / "out" / "experiment.json").read_text())


def test_orders_that_a_class_does_not_take_raise():
    world = usarsim.World(usarsim.Scene("rough"))
    skid, car = world.spawn("P3AT", position=(0, 0, 0)), world.spawn("Sedan", position=(0, 5, 0))
    for act, text in [
        (lambda: skid.drive_wheels([1] * 4), "expected drive_sides"),
        (lambda: skid.drive_twist(forward=1), "expected drive_sides"),
        (lambda: car.drive_sides(1, 1), "Speed, FrontSteer and RearSteer"),
        (lambda: world.spawn("USARBotAPI.WorldController"), "expected a robot class"),
        (lambda: world.spawn("P3AT", start="PlayerStart_0", rotation=(0, 0, 1)), "its own rotation"),
    ]:
        with pytest.raises(usarsim.CommandError, match=text):
            act()
    assert len(world.robots) == 2
    car.drive({"Speed": 5.0, "FrontSteer": 0.0, "RearSteer": 0.0})
    flyer = world.spawn("AirRobot", position=(0, -3, -1))
    flyer.drive_twist(forward=0.5)
    world.run(1.0)
    assert car.position[0] > 0.1 and flyer.position[0] > 0.1


def test_a_world_that_another_thread_steps_says_so(world):
    robot, thread = world.robots[0], threading.Thread(target=lambda: world.run(30.0))
    thread.start()
    errors = []
    while thread.is_alive():
        for act in (lambda: robot.position, lambda: robot.drive_wheels([0] * 4), lambda: world.robots, lambda: world.time):
            try:
                act()
            except RuntimeError as error:
                errors.append(str(error))
    thread.join()
    assert any("another thread" in error for error in errors)
    assert robot.position.shape == (3,), "it goes on afterwards"


def test_ctrl_c_ends_a_long_run(world):
    threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start()
    with pytest.raises(KeyboardInterrupt):
        world.run(1e6)
    time = world.time
    world.step()
    assert 0 < time < world.time < 1e5


def test_a_log_never_replaces_a_file(scene, tmp_path):
    (tmp_path / "run.mcap").write_text("precious")
    with pytest.raises(usarsim.LogError, match="it exists"):
        usarsim.World(scene, log=tmp_path / "run.mcap")
    assert (tmp_path / "run.mcap").read_text() == "precious"


def test_a_state_of_another_scene_is_refused(world):
    state = world.save()
    for other in (usarsim.Scene("hall", drive_model="analytic"), usarsim.Scene("rough", set=["KUKA_YouBot.wheels.gain=1"])):
        with pytest.raises(usarsim.SaveError, match="another scene"):
            usarsim.World.load(other, state)
    for broken in (b"", b"nonsense", b"{}", state[: len(state) // 2]):
        with pytest.raises(usarsim.SaveError, match="not a saved world"):
            usarsim.World.load(world.scene, broken)


def test_a_reading_that_is_not_there_says_which_are(world):
    robot = world.robots[0]
    with pytest.raises(KeyError, match="GndTruth has not measured yet"):
        robot.readings["GndTruth"]
    world.run(0.2)
    with pytest.raises(KeyError, match="unknown sensor `nothing`: expected one of .*GndTruth"):
        robot.readings["nothing"]
    with pytest.raises(KeyError, match="did you mean `GndTruth`"):
        robot.readings["GndTruht"]
    assert robot.readings.get("nothing") is None and "nothing" not in robot.readings


def test_readings_and_robots_behave_as_python_expects(world):
    world.run(0.2)
    robot = world.robots[0]
    truth = robot.readings["GndTruth"]
    assert "position" in truth and "nothing" not in truth and list(truth) == truth.keys() and len(truth) == 2
    assert robot == world.robots[0] and robot in world.robots and len({robot, world.robots[0]}) == 1
    assert robot != world.copy().robots[0] and robot != 1


def test_a_scenario_is_played_and_judged():
    world = usarsim.World(usarsim.Scene(scenario="sideways"))
    with pytest.raises(usarsim.CommandError, match="team players has no P3AT: expected one of KUKA_YouBot"):
        world.spawn("P3AT")
    robot = world.spawn("KUKA_YouBot")
    assert (world.reached, world.finished) == ([], None)
    while world.finished is None and world.time < 60:
        robot.drive_twist(right=max(-0.3, min(0.3, 1.5 * (2.0 - robot.position[1]))), clockwise=-2 * robot.rotation[2])
        world.run(0.1)
    assert world.reached == ["on-the-mark"] and 5 < world.finished < 30
    with pytest.raises(usarsim.SceneError, match="got both map and scenario"):
        usarsim.Scene("hall", scenario="sideways")
    with pytest.raises(usarsim.SceneError, match="unknown scenario `side`"):
        usarsim.Scene(scenario="side")
