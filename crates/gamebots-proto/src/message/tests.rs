//! Golden lines of every message, and reading as the inverse of writing.

use super::*;
use proptest::prelude::*;

/// Lines as USARSim sends them: read, then written back byte for byte.
#[test]
fn golden_lines_are_written_back_byte_for_byte() {
    for text in [
        "NFO {Gametype BotDeathMatch} {Level DM-Factory_250} {TimeLimit 0}",
        "NFO {StartPoses 2} {PlayerStart_0 1.0000,2.0000,-0.5000 0.0000,0.0000,1.5708 Dock 0.0000,0.0000,0.0000 0.0000,0.0000,0.0000}",
        "NFO {StartPoses 0}",
        "NFO {PathNodes 0}",
        "NFO {Pathnode None} {Location 0.0000,0.0000,0.0000}",
        "NFO {Error unknown verb}",
        "STA {Time 29.9739} {Battery 1199} {Type GroundVehicle} {LightToggle False} {LightIntensity 100} {FrontSteer 0} {RearSteer 0}",
        "STA {Time 29.9739} {Battery 1199} {Type GroundVehicle} {LightToggle True} {LightIntensity 100} {FrontSteer 0.2500} {RearSteer 0.0000}",
        "STA {Time 3.1000} {Battery 99999} {Type LeggedVehicle} {HeadYaw 0.0000} {HeadPitch -0.1012}",
        "STA {Time 3.1000} {Battery 99999} {Type StaticPlatform}",
        "STA {Time 3.1000} {Battery 1200}",
        "ASTA {Time 5.2000} {Name KR60Arm} {Link 1} {Value 0.1000} {Link 2} {Value -1.2500}",
        "EFF {Time 5.2000} {Type Gripper} {Name Hand} {Status CLOSED}",
        "EFF {Time 5.2000} {Type Gripper} {Name Hand} {Status OPEN}",
        "SEN {Time 29.9739} {Type GroundTruth} {Name GndTruth} {Location 0.625,2.250,1.875} {Orientation 0.000,-0.500,0.000}",
        "SEN {Time 5.2000} {Type IMU} {Name IMU} {XYZAcceleration 0.2500,-0.5000,0.0000} {AngularVel 0.0000,0.0000,1.5000} {AngularAccel 0.0000,0.0000,-0.2500} {Rotation 0.0000,-0.4375,1.2500}",
        "SEN {Type INS} {Name InsTest} {Location 12.61,-2.68,1.84} {Orientation 0.00,0.00,6.28}",
        "SEN {Time 44.5467} {Type Odometry} {Name Odometer} {Pose 0.0000,0.0000,0.0000}",
        "SEN {Time 5.2000} {Type Tachometer} {Name TachTest} {Vel 0.0000,0.0000,0.0000,0.0000} {Pos 6.2832,6.2832,6.2832,6.2832}",
        "SEN {Time 5.2000} {Type Tachometer} {Name TachTest}",
        "SEN {Time 5.2000} {Type Sonar} {Name F1} {Range 2.5000}",
        "SEN {Time 5.2000} {Type Encoder} {Name W1} {Tick 90}",
        "SEN {Time 5.2000} {Type Encoder} {Name W0} {Tick 3} {Name W2} {Tick -4}",
        "SEN {Time 5.2000} {Type RangeScanner} {Name lms200} {Resolution 0.0625} {FOV 3.1250} {Range 2.25,20.00,0.50}",
        "SEN {Time 5.2000} {Type Camera} ",
        "CONF {Name P3AT} {Type GroundVehicle} {SteeringType SkidSteered} {Mass 11.5000} {MaxSpeed 8.1250} {MaxTorque 50000.0000} {MaxFrontSteer 0} {MaxRearSteer 0}",
        "CONF {Name FrontAckerman} {Type GroundVehicle} {SteeringType AckermanSteered} {Mass 147.0000} {MaxSpeed 3.5000} {MaxTorque 50000.0000} {MaxFrontSteer 1.0000} {MaxRearSteer 6.2500}",
        "CONF {Name KR60} {Type StaticPlatform} {SteeringType None} {Mass 0} ",
        "CONF {Name AirRobot}",
        "CONF {Type rangescanner} {Name lms200} {MaxRange 20.0000} {MinRange 0.1250} {Resolution 0.0625} {Fov 3.1250} {Panning True} {Tilting False}",
        "CONF {Type GroundTruth} {Name GndTruth} {ScanInterval 0.1000}",
        "CONF {Type Encoder} {Name W1} {Resolution 0.0625} {Name W2} {Resolution 0.0625}",
        "CONF {Type Sonar} {Name F1} {MaxRange 5.0000} {MinRange 0.1250} {ScanInterval 0.2500} {beamAngle 0.3750} {maxAngleOfIncidence 0.1250} {tracesPerCone 16} {numberOfCones 10}",
        "CONF {Type Camera} {Name Camera}{TextureOffsetX 0}{TextureOffsetY 0}{TextureResolutionX 320}{TextureResolutionY 240}{CameraDefFov 80.0000}{CameraMinFov 20.0000}{CameraMaxFov 120.0000}{CameraFov 80.0000}",
        "CONF {Type Sensor} {Name battery}",
        "CONF {Type Actuator} {Name Arm} {Link 1} {JointType Revolute} {MaxTorque 47.5000} {MinValue -2.9500} {MaxValue 2.9500} {Link 2} {JointType Prismatic} {MaxTorque 5.0000} {MinValue 0.0000} {MaxValue 0.2500}",
        "CONF {Type MisPkg} {Name Arm} {Link 1} {JointType Revolute} {MaxRotationSpeed 1.571} {MaxTorque 47.5000} {MinRange -2.9500} {MaxRange 2.9500}",
        "CONF {Type Gripper} {Name Hand} {Opcode Grip} {MaxVal 1} {MinVal 0} {Opcode Close} {Opcode Open}",
        "CONF {Type MisPkg}",
        "GEO {Type GroundVehicle} {Name P3AT} {Dimensions 0.2500,0.3750,0.0000} {COG 0.0000,0.0000,0.0625} {WheelRadius 0.0980} {WheelSeparation 0.3750} {WheelBase 0.2500}",
        "GEO {Type StaticPlatform} {Name KR60}",
        "GEO {Name AirRobot}",
        "GEO {Type RangeScanner} {Name lms200} {Location 0.21,0.00,-0.20} {Orientation 0.00,0.00,0.00}{Mount P3AT}",
        "GEO {Type Sonar} {Name S1} {Location 0.21,0.00,-0.20} {Orientation 0.00,0.00,0.00}{Mount Arm}{MountLink 3}",
        "GEO {Type Gripper} {Name Gripper} {Location 0.25,0.00,-0.50} {Orientation 0.00,0.00,0.00}{Mount Arm}{MountLink 5}{Tip 0.00,0.00,0.00}",
        "GEO {Type Actuator} {Name Arm} {Location 0.125,0.000,-0.250} {Orientation 0.000,0.000,0.000}{Mount YouBot} {Link 1} {Parent 0} {Location 0.000,0.000,-0.125} {Orientation 0.00,0.00,0.00} {Link 2} {Parent 1} {Location 0.250,0.000,0.000} {Orientation 1.57,0.00,0.00}{Tip 0.00,0.00,-0.25}",
        "GEO {Type Encoder} {Name W1} {Location 0.00,0.00,0.00} {Orientation 0.00,0.00,0.00}{Mount P3AT} {Name W2} {Location 0.00,0.00,0.00} {Orientation 0.00,0.00,0.00}{Mount P3AT}",
    ] {
        let message = Message::read(text).unwrap_or_else(|| panic!("not read: {text}"));
        assert_eq!(message.write(), text);
    }
}

#[test]
fn a_tachometer_has_a_speed_for_each_angle() {
    for blocks in ["{Vel 1,2} {Pos 1}", "{Vel 1}", "{Pos 1}", "{Vel 1} {Pos 1"] {
        let text = format!("SEN {{Type Tachometer}} {{Name T}} {blocks}");
        assert_eq!(Message::read(&text), None, "{text}");
    }
}

#[test]
fn lines_that_are_no_message_are_none() {
    for text in ["", "RES {Type x}", "SEN {Type Laser}", "STA {Time x}", "NFO", "GEO {Type GroundVehicle}", "CONF"] {
        assert_eq!(Message::read(text).filter(|message| !matches!(message, Message::Geo(_))), None, "{text}");
    }
}

/// A number that the formats write without loss: a multiple of 1 / 2^bits.
fn grid(bits: u32) -> impl Strategy<Value = f32> {
    (-4000i32..4000).prop_map(move |n| n as f32 / (1 << bits) as f32)
}

fn vector(bits: u32) -> impl Strategy<Value = [f32; 3]> {
    [grid(bits), grid(bits), grid(bits)]
}

fn word() -> impl Strategy<Value = String> {
    "[A-Za-z][A-Za-z0-9_]{0,8}"
}

fn poses() -> impl Strategy<Value = Vec<NamedPose>> {
    let pose = (word(), vector(4), vector(4));
    let pose = pose.prop_map(|(name, location, rotation)| NamedPose { name, location, rotation });
    proptest::collection::vec(pose, 0..4)
}

fn reading() -> impl Strategy<Value = Reading> {
    let numbers = |bits, range| proptest::collection::vec(grid(bits), range);
    prop_oneof![
        (word(), vector(3), vector(3)).prop_map(|(name, location, orientation)| GroundTruth {
            name,
            location,
            orientation
        }
        .into()),
        (word(), vector(2), vector(2))
            .prop_map(|(name, location, orientation)| Ins { name, location, orientation }.into()),
        (word(), vector(4), vector(4), vector(4), vector(4)).prop_map(
            |(name, acceleration, angular_velocity, angular_acceleration, rotation)| {
                Imu { name, acceleration, angular_velocity, angular_acceleration, rotation }.into()
            }
        ),
        (word(), vector(4)).prop_map(|(name, pose)| Odometry { name, pose }.into()),
        proptest::collection::vec((word(), any::<i32>()), 0..4).prop_map(|ticks| Encoder { ticks }.into()),
        (word(), numbers(4, 0..5))
            .prop_map(|(name, values)| { Tachometer { name, velocities: values.clone(), positions: values }.into() }),
        (word(), grid(4), grid(4), numbers(2, 1..20)).prop_map(|(name, resolution, field_of_view, ranges)| {
            RangeScanner { name, resolution, field_of_view, ranges }.into()
        }),
        (word(), grid(4)).prop_map(|(name, range)| Sonar { name, range }.into()),
        Just(Camera.into()),
    ]
}

fn items() -> impl Strategy<Value = Conf> {
    let list = |type_name: &'static str, item: BoxedStrategy<ItemConf>| {
        proptest::collection::vec(item, 1..4)
            .prop_map(move |items| Conf::Items { type_name: type_name.to_owned(), items })
    };
    prop_oneof![
        list("Sensor", word().prop_map(|name| ItemConf::Plain { name }).boxed()),
        list(
            "INS",
            (word(), grid(4)).prop_map(|(name, scan_interval)| ItemConf::Timed { name, scan_interval }).boxed()
        ),
        list(
            "encoder",
            (word(), grid(4)).prop_map(|(name, resolution)| ItemConf::Encoder { name, resolution }).boxed()
        ),
        list(
            "RangeScanner",
            (word(), grid(4), grid(4), any::<bool>())
                .prop_map(|(name, a, b, flag)| ItemConf::RangeScanner {
                    name,
                    max_range: a,
                    min_range: b,
                    resolution: a,
                    fov: b,
                    panning: flag,
                    tilting: !flag
                })
                .boxed()
        ),
        list(
            "SONAR",
            (word(), grid(4), grid(4), any::<u32>())
                .prop_map(|(name, a, b, n)| ItemConf::Sonar {
                    name,
                    max_range: a,
                    min_range: b,
                    scan_interval: a,
                    beam_angle: b,
                    max_angle_of_incidence: a,
                    traces_per_cone: n,
                    number_of_cones: n / 2
                })
                .boxed()
        ),
        list(
            "Camera",
            (word(), any::<[i32; 2]>(), grid(4))
                .prop_map(|(name, pixels, angle)| ItemConf::Camera {
                    name,
                    offset: pixels,
                    resolution: pixels,
                    default_fov: angle,
                    min_fov: angle,
                    max_fov: angle,
                    fov: angle
                })
                .boxed()
        ),
    ]
}

fn vehicle() -> impl Strategy<Value = Vehicle> {
    prop_oneof![
        (any::<bool>(), proptest::option::of([grid(4), grid(4)]))
            .prop_map(|(light, steer)| Vehicle::Ground { light, steer }),
        proptest::collection::vec((word(), grid(4)), 0..4).prop_map(|joints| Vehicle::Legged { joints }),
        Just(Vehicle::Static),
        Just(Vehicle::Aerial),
    ]
}

fn any_message() -> impl Strategy<Value = Message> {
    prop_oneof![
        (word(), any::<u32>()).prop_map(|(level, time_limit)| Message::Nfo(Nfo::Greeting { level, time_limit })),
        poses().prop_map(|poses| Message::Nfo(Nfo::StartPoses(poses))),
        poses().prop_map(|poses| Message::Nfo(Nfo::PathNodes(poses))),
        (word(), vector(4)).prop_map(|(name, location)| Message::Nfo(Nfo::PathNode { name, location })),
        word().prop_map(|text| Message::Nfo(Nfo::Error(text))),
        (grid(4), any::<i32>(), vehicle()).prop_map(|(time, battery, vehicle)| Message::Sta(Sta {
            time,
            battery,
            vehicle
        })),
        (reading(), grid(4)).prop_map(|(reading, time)| Message::Sen(reading.at(time))),
        (word(), word(), vector(4), proptest::option::of([grid(4), grid(4)])).prop_map(
            |(name, steering_type, [mass, max_speed, max_torque], max_steer)| {
                let vehicle = VehicleConf::Ground { steering_type, mass, max_speed, max_torque, max_steer };
                Message::Conf(Conf::Robot(RobotConf { name, vehicle }))
            }
        ),
        (word(), prop_oneof![Just(VehicleConf::Static), Just(VehicleConf::Plain)])
            .prop_map(|(name, vehicle)| Message::Conf(Conf::Robot(RobotConf { name, vehicle }))),
        (word(), prop_oneof![Just(VehicleGeo::Static), Just(VehicleGeo::Plain)])
            .prop_map(|(name, vehicle)| Message::Geo(Geo::Robot(RobotGeo { name, vehicle }))),
        items().prop_map(Message::Conf),
        (word(), vector(4), vector(4)).prop_map(|(name, a, b)| {
            let [wheel_radius, wheel_separation, wheel_base] = a;
            let (dimensions, centre_of_gravity) = (a, b);
            let vehicle =
                VehicleGeo::Ground { dimensions, centre_of_gravity, wheel_radius, wheel_separation, wheel_base };
            Message::Geo(Geo::Robot(RobotGeo { name, vehicle }))
        }),
        (word(), proptest::collection::vec((word(), vector(2), vector(2), word(), 0usize..3, any::<bool>()), 1..4))
            .prop_map(|(type_name, items)| {
                let items = items.into_iter().map(|(name, location, orientation, mount, link, has_tip)| ItemGeo {
                    name,
                    location,
                    orientation,
                    mount,
                    mount_link: Some(link).filter(|&link| link > 0),
                    tip: has_tip.then_some(location),
                });
                Message::Geo(Geo::Items { type_name, items: items.collect() })
            }),
    ]
}

proptest! {
    #[test]
    fn reading_gives_back_what_was_written(message in any_message()) {
        prop_assert_eq!(Message::read(&message.write()), Some(message));
    }

    #[test]
    fn any_text_is_read_without_a_panic(text in ".*") {
        Message::read(&text);
    }
}
