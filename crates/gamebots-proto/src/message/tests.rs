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
        "SEN {Time 5.2000} {Type Accel} {Name Acc} {Acceleration 0.2500,-0.5000,0.0000}",
        "SEN {Time 5.2000} {Type AcceleroMeter} {Name Accelerometer} {ProperAcceleration 0.0000,0.0000,9.8125}",
        "SEN {Time 5.2000} {Type AltitudeSensor} {Name GPS} {relativeAltitude 1.5000} {absoluteAltitude 112.5000}",
        "SEN {Time 5.2000} {Type MagneticCompass} {Name Compass} {MagneticAngle -1.2500}",
        "SEN {Time 65.2000} {Type MissionTime} {Name Time} {Minutes 1}",
        "SEN {Type INS} {Name InsTest} {Location 12.61,-2.68,1.84} {Orientation 0.00,0.00,6.28}",
        "SEN {Time 44.5467} {Type Odometry} {Name Odometer} {Pose 0.0000,0.0000,0.0000}",
        "SEN {Time 5.2000} {Type Tachometer} {Name TachTest} {Vel 0.0000,0.0000,0.0000,0.0000} {Pos 6.2832,6.2832,6.2832,6.2832}",
        "SEN {Time 5.2000} {Type Tachometer} {Name TachTest}",
        "SEN {Time 5.2000} {Type Sonar} {Name F1} {Range 2.5000}",
        "SEN {Time 5.2000} {Type Touch} {Name Touch1} {Touch False}",
        "SEN {Time 5.2000} {Type Encoder} {Name W1} {Tick 90}",
        "SEN {Time 5.2000} {Type Encoder} {Name W0} {Tick 3} {Name W2} {Tick -4}",
        "SEN {Time 5.2000} {Type RangeScanner} {Name lms200} {Resolution 0.0625} {FOV 3.1250} {Range 2.25,20.00,0.50}",
        "SEN {Time 5.2000} {Type Camera} ",
        "SEN {Time 5.2000} {Type IR} {Name IR1} {Range 1.2500}",
        "SEN {Time 5.2000} {Type IRScanner} {Name Scan} {Resolution 0.0625} {FOV 3.1250} {Range 2.25,10.00,0.50}",
        "SEN {Time 5.2000} {Type RangeScanner3D} {Name Scan} {Resolution 0.0625,0.0312} {FOV 0.5000,3.1250} {Range 2.25,20.00,0.50}",
        "SEN {Time 5.2000} {Type RangeImager} {Name Kinect} {Resolution 320,240} {FOV 1.0000,0.7500} {Frames 0} {Frame 0}",
        "SEN {Time 5.2000} {Type RangeImager} {Name Kinect} {Resolution 320,240} {FOV 1.0000,0.7500} {Frames 20} {Frame 3} {Range 2.25,20.00}",
        "SEN {Type LineLaser} {Name Line} {Location 0.5000,0.0000,-0.2500} {Orientation 0.0000,0.0000,1.5000} {Points [1.500,-0.250,0.000][1.500,0.250,0.000]}",
        "SEN {Time 5.2000} {Type PCL} {Name Cloud} {1.50,-0.25,0.00;1.50,0.25,0.00}",
        "SEN {Time 5.2000} {Type PCL}{Name Grid}{1.5000,-0.2500,0.0000 1.5000,0.2500,0.0000}",
        "SEN {Time 5.2000} {Type TouchArray} {Name Bumper} {Touch True}",
        "SEN {Time 5.2000} {Type GPS} {Name GPS} {Latitude 39,8.0312,N} {Longitude 77,12.9980,W} {Fix 1} {Satellites 11}",
        "SEN {Time 5.2000} {Type GPS} {Name GPS} {Fix 0} {Satellites 2}",
        "SEN {Time 5.2000} {Type Acoustic} {Name Ears} {None}",
        "SEN {Time 5.2000} {Type Acoustic} {Name Ears} {Far} {Direction 0.50,0.00,-0.50} {Volume 97.0000} {Duration 0.5000} {Delay 0.0312} {Far}",
        "SEN {Type ObjectSensor} {Name Vision1}",
        "SEN {Type ObjectSensor} {Name Vision1} {Object Crate}{Location 4.00,0.25,-1.00}{Orientation 0.00,0.00,1.50}{HitLoc 3.75,0.25,-1.00}{Material wood} {Object Wall}{Location 5.00,0.00,-1.00}{Orientation 0.00,0.00,0.00}{HitLoc 5.00,0.25,-1.00}{Material None}",
        "SEN {Type RFID} {Name RFIDReader} {ID 118} {Location -0.25,-0.50,0.25} {Mem 0} {ID 119} {Location 1.00,0.00,0.00}",
        "SEN {Type VictSensor} {Name VictimSensor} {PartName Leg} {Location 2.00,0.25,0.50} {PartName Arm} {Location 2.50,0.50,0.25}",
        "SEN {Type VictSensor} {Name VictimSensor} {Status NoVictims}",
        "SEN {Type HumanMotion} {Name Motion} {Prob 0.50}",
        "SEN {Type Sound} {Name Ear} {Loudness 42.50} {Duration 1.50}",
        "SEN {Type CO2Sensor} {Name CO2} {Gas CO2} {Density 0.25}",
        "SEN {Type INU} {Name INU} {Orientation 0.00,-0.50,1.50}",
        "CONF {Type IR} {Name IR1} {MaxRange 1.5000} {MinRange 0.2500} {MaxRange 1.5000} {MinRange 0.2500}",
        "CONF {Type IRScanner} {Name Scan} {MaxRange 10.0000} {MinRange 0.2500} {Resolution 0.0625} {Fov 3.1250} {Panning True} {Tilting False}",
        "CONF {Type RangeScanner3D} {Name Scan} {MaxRange 20.0000} {MinRange 0.1250} {Resolution 0.0625,0.0312} {Fov 0.5000,3.1250}",
        "CONF {Type RangeImager} {Name Kinect} {MaxRange 20.0000} {MinRange 0.1250} {Resolution 320,240} {Fov 1.0000,0.7500}",
        "CONF {Type LineLaser} {Name Line} {MaxRange 5.0000} {MinRange 0.1250} {FOV 1.5000} {Resolution 120}",
        "CONF {Type TouchArray} {Name Bumper} {Diameter 0.0098} {ArcRotation Pitch 0.2500 Roll 0.0000 Yaw -0.5000} {ArcRadius 0.1250} {ArcAngle 3.1250}",
        "CONF {Type GPS} {Name GPS} {ScanInterval 0.2000}",
        "CONF {Name P3AT} {Type GroundVehicle} {SteeringType SkidSteered} {Mass 11.5000} {MaxSpeed 8.1250} {MaxTorque 50000.0000} {MaxFrontSteer 0} {MaxRearSteer 0}",
        "CONF {Name FrontAckerman} {Type GroundVehicle} {SteeringType AckermanSteered} {Mass 147.0000} {MaxSpeed 3.5000} {MaxTorque 50000.0000} {MaxFrontSteer 1.0000} {MaxRearSteer 6.2500}",
        "CONF {Name KR60} {Type StaticPlatform} {SteeringType None} {Mass 0} ",
        "CONF {Name AirRobot}",
        "CONF {Type rangescanner} {Name lms200} {MaxRange 20.0000} {MinRange 0.1250} {Resolution 0.0625} {Fov 3.1250} {Panning True} {Tilting False}",
        "CONF {Type GroundTruth} {Name GndTruth} {ScanInterval 0.1000}",
        "CONF {Type Encoder} {Name W1} {Resolution 0.0625} {Name W2} {Resolution 0.0625}",
        "CONF {Type Touch} {Name Touch1} {Diameter 0.0098}",
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
        check(text, Dialect::Udk);
    }
}

/// Lines as a UT2004 server of 2011 sends them, or as clients quote them. Their numbers lose no digits.
#[test]
fn golden_lines_of_ut2004_are_written_back_byte_for_byte() {
    for text in [
        "NFO {Gametype BotDeathMatch} {Level DM-Factory_250} {TimeLimit 0}",
        "NFO {StartPoses 2} {Name UnitLoader1 Location 10.24,3.54,10.05 Orientation 0.00,0.00,1.60} {Name UnitLoader2 Location 10.25,3.50,10.00 Orientation 0.00,0.00,0.00}",
        "NFO {StartPoses 0}",
        "SEN {Time 310.5625} {Type Sonar} {Name F1 Range 4.5625} {Name F2 Range 1.9375}",
        "SEN {Type Touch} {Name S1 Touch False} {Name S2 Touch True}",
        "SEN {Type Encoder} {Name ECLeft Tick 0} {Name ECRight Tick -4}",
        "SEN {Time 310.5625} {Type GroundTruth} {Name GroundTruth} {Location 4.50,1.90,1.85} {Orientation 0.00,6.28,6.28}",
        "SEN {Time 310.57} {Type RangeScanner} {Name Scanner1} {Resolution 0.0625} {FOV 3.1250} {Range 2.1875,2.1250,2.0625}",
        "SEN {Type INS} {Name INS} {Location 4.50,1.90,1.80} {Orientation 0.00,0.00,0.00}",
        "SEN {Type Odometry} {Name Odometry} {Pose -0.0625,0.0000,0.0000}",
        "SEN {Type Tachometer} {Name TachTest} {Vel 0.0000,0.0000} {Pos 6.2832,6.2832}",
        "MISSTA {Time 310.57} {Name CameraPanTilt} {Link 1} {Value 0.0000} {Torque -20.00} {Link 2} {Value 0.0000} {Torque -20.00}",
        "STA {Type GroundVehicle} {Time 310.57} {FrontSteer 0.0000} {RearSteer 0.0000} {LightToggle False} {LightIntensity 0} {Battery 1200} {View -1}",
        "STA {Type GroundVehicle} {Time 48.25} {FrontSteer 0.0000} {RearSteer 0.0000} {FRFlipper -0.0625} {FLFlipper 0.0000} {LightToggle False} {LightIntensity 0} {Battery 1196} {View -1}",
        "STA {Type AerialVehicle} {Time 268.50} {LightToggle False} {LightIntensity 0} {Battery 1192} {View -1}",
        "CONF {Type GroundVehicle} {Name P2AT} {SteeringType SkidSteered} {Mass 14.0000} {MaxSpeed 5.3750} {MaxTorque 60.0000} {MaxFrontSteer 0.0000} {MaxRearSteer 0.0000}",
        "CONF {Type RangeScanner} {Name Scanner1} {MaxRange 20.0000} {MinRange 0.1250} {Resolution 0.0625} {Fov 3.1250} {Paning True} {Tilting False}",
        "CONF {Type Sonar} {Name R8} {MaxRange 5.0000} {MinRange 0.1250} {BeamAngle 0.3750}",
        "CONF {Type GroundTruth} {Name GroundTruth} {ScanInterval 0.05}",
        "CONF {Type Tachometer} {Name TachTest} {ScanInterval 0.2000}",
        "CONF {Type Encoder} {Name ECLeft} {Resolution 0.0625}",
        "GEO {Type GroundVehicle} {Name P2AT} {Dimensions 0.5000,0.4375,0.2500} {COG 0.0000,0.0000,0.0000} {WheelRadius 0.1250} {WheelSeparation 0.5000} {WheelBase 0.2500}",
        "GEO {Type Sonar} {Name F1 Location 0.1250,-0.1875,0.0000 Orientation 0.0000,0.0000,-1.5625 Mount HARD} {Name F2 Location 0.1875,-0.1250,0.0000 Orientation 0.0000,0.0000,-0.8750 Mount HARD}",
        "RES {Time 310.57} {Type Camera} {Name Camera} {Status OK}",
        "RES {Time 310.57} {Type Camera} {Name Other} {Status Failed}",
    ] {
        check(text, Dialect::Ut2004);
    }
}

#[track_caller]
fn check(text: &str, dialect: Dialect) {
    let messages = Message::read_all(text);
    assert!(!messages.is_empty(), "not read: {text}");
    let written: Vec<String> = lines(&messages, dialect).into_iter().map(|written| written.line).collect();
    assert_eq!(written, [text]);
}

#[test]
fn angles_of_ut2004_have_one_turn() {
    for (angle, turned, theta) in [
        (-0.0015, "6.28", "-0.0015"),
        (3.5, "3.50", "-2.7831"),
        (7.0, "0.72", "0.7168"),
        (-4.0, "2.28", "2.2831"),
        (-1e-9, "6.28", "-0.0000"),
    ] {
        let [name, orientation] = ["n".to_owned(), "o".to_owned()];
        let truth = Reading::from(GroundTruth { name, location: [0.0; 3], orientation: [0.0, 0.0, angle] });
        let odometry = Reading::from(Odometry { name: orientation, pose: [0.0, 0.0, angle] });
        let [truth, odometry] = [truth, odometry].map(|it| Message::Sen(it.at(1.0)).write(Dialect::Ut2004));
        assert!(truth.ends_with(&format!("{{Orientation 0.00,0.00,{turned}}}")), "{truth}");
        assert_eq!(odometry, format!("SEN {{Type Odometry}} {{Name o}} {{Pose 0.0000,0.0000,{theta}}}"));
    }
}

/// UT2004 echoes questions that nothing matches and answers every SET; UDK does neither.
#[test]
fn ut2004_always_answers() {
    for (text, found, answer) in [
        ("SET {Type Camera} {Name C}", true, Some("RES {Time 2.50} {Type Camera} {Name C} {Status OK}")),
        ("SET {Type Camera} {Name C}", false, Some("RES {Time 2.50} {Type Camera} {Name C} {Status Failed}")),
        ("GETCONF {Type RFID}", false, Some("CONF {Type RFID}")),
        ("GETGEO {Type RFID} {Name R}", false, Some("GEO {Type RFID} {Name R}")),
        ("GETGEO {Type Sonar}", true, None),
        ("DRIVE {Left 1}", false, None),
    ] {
        let command = Command::parse(text, &mut Vec::new()).unwrap();
        let receipt = |dialect| Message::receipt(&command, found, 2.5, dialect);
        assert_eq!(receipt(Dialect::Ut2004).map(|it| it.write(Dialect::Ut2004)).as_deref(), answer, "{text}");
        assert_eq!(receipt(Dialect::Udk), None, "{text}");
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
    for text in
        ["", "RES {Type x}", "DIE", "SEN {Type Laser}", "STA {Time x}", "NFO", "GEO {Type GroundVehicle}", "CONF"]
    {
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
        (word(), vector(4)).prop_map(|(name, acceleration)| Acceleration { name, acceleration }.into()),
        (word(), vector(4)).prop_map(|(name, acceleration)| AcceleroMeter { name, acceleration }.into()),
        (word(), grid(4), grid(4))
            .prop_map(|(name, relative, absolute)| AltitudeSensor { name, relative, absolute }.into()),
        (word(), grid(4)).prop_map(|(name, angle)| MagneticCompass { name, angle }.into()),
        (word(), any::<i32>()).prop_map(|(name, minutes)| MissionTime { name, minutes }.into()),
        (word(), vector(4)).prop_map(|(name, pose)| Odometry { name, pose }.into()),
        proptest::collection::vec((word(), any::<i32>()).prop_map(|(name, tick)| Tick { name, tick }), 0..4)
            .prop_map(|ticks| Encoder { ticks }.into()),
        (word(), numbers(4, 0..5))
            .prop_map(|(name, values)| { Tachometer { name, velocities: values.clone(), positions: values }.into() }),
        (word(), grid(4), grid(4), numbers(2, 1..20)).prop_map(|(name, resolution, field_of_view, ranges)| {
            RangeScanner { name, resolution, field_of_view, ranges }.into()
        }),
        (word(), grid(4)).prop_map(|(name, range)| Sonar { name, range }.into()),
        (word(), any::<bool>()).prop_map(|(name, touch)| Touch { name, touch }.into()),
        (word(), any::<bool>()).prop_map(|(name, touch)| TouchArray { name, touch }.into()),
        (word(), grid(4)).prop_map(|(name, range)| Ir { name, range }.into()),
        (word(), grid(2), grid(2)).prop_map(|(name, loudness, duration)| Sound { name, loudness, duration }.into()),
        (word(), vector(4), proptest::collection::vec(vector(2), 1..5))
            .prop_map(|(name, location, points)| LineLaser { name, location, orientation: location, points }.into()),
        (word(), proptest::collection::vec(vector(2), 1..5))
            .prop_map(|(name, points)| PointCloud { name, points }.into()),
        (word(), proptest::collection::vec(vector(4), 2..5))
            .prop_map(|(name, points)| SonarArray { name, points }.into()),
        (word(), proptest::option::of((0..90u32, grid(4))), any::<u32>()).prop_map(|(name, place, satellites)| {
            let bearing = |letter| place.map(|(degrees, minutes)| Bearing { degrees, minutes, letter });
            Gps { name, latitude: bearing('S'), longitude: bearing('E'), fix: 1, satellites }.into()
        }),
        (word(), proptest::collection::vec(proptest::option::of((vector(2), grid(4))), 0..4)).prop_map(
            |(name, sounds)| {
                let heard = |(direction, volume)| Heard { direction, volume, duration: volume, delay: volume };
                Acoustic { name, sounds: sounds.into_iter().map(|sound| sound.map(heard)).collect() }.into()
            }
        ),
        (word(), proptest::collection::vec((word(), vector(2), word()), 0..4)).prop_map(|(name, objects)| {
            let seen = |(object, location, material)| SeenObject {
                object,
                location,
                orientation: location,
                hit: location,
                material,
            };
            ObjectSensor { name, objects: objects.into_iter().map(seen).collect() }.into()
        }),
        (word(), proptest::collection::vec((any::<u32>(), vector(2), proptest::option::of(word())), 1..4)).prop_map(
            |(name, tags)| {
                let tag = |(id, location, memory)| SeenTag { id, location, memory };
                Rfid { name, tags: tags.into_iter().map(tag).collect() }.into()
            }
        ),
        Just(Camera {}.into()),
    ]
}

fn items() -> impl Strategy<Value = Conf> {
    let list = |type_name: &'static str, item: BoxedStrategy<ItemConf>| {
        proptest::collection::vec(item, 1..4)
            .prop_map(move |items| Conf::Items { type_name: type_name.to_owned(), items })
    };
    let joints = || proptest::collection::vec((word(), vector(2)), 0..4);
    prop_oneof![
        list("Sensor", word().prop_map(|name| PlainConf { name }.into()).boxed()),
        list(
            "INS",
            (word(), grid(2)).prop_map(|(name, scan_interval)| PoseConf { name, scan_interval }.into()).boxed()
        ),
        list(
            "Odometry",
            (word(), grid(4)).prop_map(|(name, scan_interval)| WheelsConf { name, scan_interval }.into()).boxed()
        ),
        list(
            "encoder",
            (word(), grid(4)).prop_map(|(name, resolution)| EncoderConf { name, resolution }.into()).boxed()
        ),
        list(
            "RangeScanner",
            (word(), grid(4), grid(4), any::<bool>())
                .prop_map(|(name, a, b, panning)| {
                    let (max_range, min_range, resolution, fov, tilting) = (a, b, a, b, !panning);
                    RangeScannerConf { name, max_range, min_range, resolution, fov, panning, tilting }.into()
                })
                .boxed()
        ),
        list(
            "SONAR",
            (word(), grid(4), grid(4), any::<u32>())
                .prop_map(|(name, a, b, n)| SonarConf {
                    name,
                    max_range: a,
                    min_range: b,
                    scan_interval: a,
                    beam_angle: b,
                    max_angle_of_incidence: a,
                    traces_per_cone: n,
                    number_of_cones: n / 2
                }
                .into())
                .boxed()
        ),
        list(
            "Camera",
            (word(), any::<[i32; 2]>(), grid(4))
                .prop_map(|(name, [x, y], angle)| CameraConf {
                    name,
                    offset_x: x,
                    offset_y: y,
                    resolution_x: y,
                    resolution_y: x,
                    default_fov: angle,
                    min_fov: angle,
                    max_fov: angle,
                    fov: angle
                }
                .into())
                .boxed()
        ),
        list(
            "Actuator",
            (word(), joints())
                .prop_map(|(name, joints)| {
                    let joint = |(link, (kind, [max_torque, min, max])): (usize, (String, [f32; 3]))| JointConf {
                        link,
                        kind,
                        max_torque,
                        min,
                        max,
                    };
                    ActuatorConf { name, joints: (1..).zip(joints).map(joint).collect() }.into()
                })
                .boxed()
        ),
        list(
            "MisPkg",
            (word(), joints())
                .prop_map(|(name, joints)| {
                    let joint = |(link, (kind, [max_torque, min, max])): (usize, (String, [f32; 3]))| MisPkgJoint {
                        link,
                        kind,
                        max_torque,
                        min,
                        max,
                    };
                    MisPkgConf { name, joints: (1..).zip(joints).map(joint).collect() }.into()
                })
                .boxed()
        ),
        list("Gripper", word().prop_map(|name| GripperConf { name }.into()).boxed()),
    ]
}

fn vehicle() -> impl Strategy<Value = Vehicle> {
    prop_oneof![
        (any::<bool>(), proptest::option::of(grid(4)), proptest::option::of(grid(4))).prop_map(
            |(light, front_steer, rear_steer)| Vehicle::Ground(
                GroundSta { light, front_steer, rear_steer },
                Vec::new()
            )
        ),
        proptest::collection::vec((word(), grid(4)), 0..4).prop_map(|joints| Vehicle::Legged { joints }),
        Just(Vehicle::Static),
        Just(Vehicle::Aerial),
    ]
}

fn any_message() -> impl Strategy<Value = Message> {
    prop_oneof![
        (word(), any::<u32>())
            .prop_map(|(level, time_limit)| Message::Nfo(Nfo::Greeting(Greeting { level, time_limit }))),
        poses().prop_map(|poses| Message::Nfo(Nfo::StartPoses(poses))),
        poses().prop_map(|poses| Message::Nfo(Nfo::PathNodes(poses))),
        (word(), vector(4)).prop_map(|(name, location)| Message::Nfo(Nfo::PathNode(PathNode { name, location }))),
        word().prop_map(|text| Message::Nfo(Nfo::Error(text))),
        proptest::collection::vec("[A-Z][A-Za-z_]{0,9}", 0..5).prop_map(|names| Message::Nfo(Nfo::Classes(names))),
        (grid(4), any::<i32>(), vehicle()).prop_map(|(time, battery, vehicle)| Message::Sta(Sta {
            time,
            battery,
            vehicle
        })),
        (reading(), grid(4)).prop_map(|(reading, time)| Message::Sen(reading.at(time))),
        (word(), word(), vector(4), [proptest::option::of(grid(4)), proptest::option::of(grid(4))]).prop_map(
            |(name, steering_type, [mass, max_speed, max_torque], [max_front_steer, max_rear_steer])| {
                let conf = GroundConf { steering_type, mass, max_speed, max_torque, max_front_steer, max_rear_steer };
                Message::Conf(Conf::Robot(RobotConf { name, vehicle: VehicleConf::Ground(conf) }))
            }
        ),
        (grid(2), word(), proptest::collection::vec((grid(4), grid(2)), 0..4)).prop_map(|(time, name, joints)| {
            let joint = |(link, (value, _))| JointSta { link, value, torque: 0.0 };
            Message::Asta(Asta { time, name, joints: (1..).zip(joints).map(joint).collect() })
        }),
        (grid(4), any::<bool>(), word(), any::<bool>(), proptest::option::of((word(), word()))).prop_map(
            |(time, is_tool_changer, name, closed, held)| {
                let (tool_type, tool) = held.unzip();
                Message::Eff(Eff { time, is_tool_changer, name, closed, tool_type, tool })
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
            let vehicle = GroundGeo { dimensions, centre_of_gravity, wheel_radius, wheel_separation, wheel_base };
            Message::Geo(Geo::Robot(RobotGeo { name, vehicle: VehicleGeo::Ground(vehicle) }))
        }),
        (word(), proptest::collection::vec((word(), vector(2), vector(2), word(), 0usize..3, any::<bool>()), 1..4))
            .prop_map(|(type_name, items)| {
                let items = items.into_iter().map(|(name, location, orientation, mount, link, has_tip)| MountedGeo {
                    name,
                    location,
                    orientation,
                    mount,
                    mount_link: Some(link).filter(|&link| link > 0),
                    tip: has_tip.then_some(location),
                });
                Message::Geo(Geo::Items { type_name, items: items.map(ItemGeo::Mounted).collect() })
            }),
    ]
}

proptest! {
    #[test]
    fn reading_gives_back_what_was_written(message in any_message()) {
        prop_assert_eq!(Message::read(&message.write(Dialect::Udk)), Some(message));
    }

    #[test]
    fn any_text_is_read_without_a_panic(text in ".*") {
        Message::read(&text);
    }
}
