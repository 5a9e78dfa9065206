//! The arm as messages for viewers: Foxglove's joint states, frames and shapes.
//!
//! ```text
//! table --Rx(foot + q1)--> link1 --l1 along z, Ry(q2)--> link2 --l2 along z--> tip
//! ```
//!
//! At zero both links point up, along z, and the foot angle is 0. A hanging arm has a foot
//! angle of half a turn, and its base is above it. Angles are the estimated ones.

use armbridge_control::arm::{Mounting, Parameters};
use armbridge_link::message::{Record, Settings};
use armbridge_servo::JOINTS;

use super::proto::Severity;
use super::proto::foxglove::{
    Color, CubePrimitive, CylinderPrimitive, FrameTransform, FrameTransforms, JointState,
    JointStates, Log, Pose, Quaternion, SceneEntity, SceneUpdate, Vector3, log,
};
use super::proto::google::protobuf::Timestamp;

/// Thickness of a link in m, as drawn.
const THICKNESS_M: f64 = 0.025;

/// Colours of the table and of both links.
const GREY: Color = rgb(0.45, 0.45, 0.48);
const BLUE: Color = rgb(0.12, 0.47, 0.71);
const ORANGE: Color = rgb(1.0, 0.5, 0.05);

const fn rgb(r: f64, g: f64, b: f64) -> Color {
    Color { r, g, b, a: 1.0 }
}

fn timestamp(at_ns: u64) -> Timestamp {
    Timestamp {
        seconds: (at_ns / 1_000_000_000) as i64,
        nanos: (at_ns % 1_000_000_000) as i32,
    }
}

/// Angles, speeds and torques of both joints.
pub(super) fn joints(at_ns: u64, record: &Record) -> JointStates {
    let joint = |j: usize| JointState {
        name: format!("joint{}", j + 1),
        position: Some(record.output.angle_rad[j].into()),
        velocity: Some(record.output.speed_rad_s[j].into()),
        acceleration: None,
        effort: Some(record.output.torque_nm[j].into()),
    };
    JointStates {
        timestamp: Some(timestamp(at_ns)),
        joints: vec![joint(0), joint(1)],
    }
}

/// Frames of the links at these joint angles.
pub(super) fn transforms(
    at_ns: u64,
    angle_rad: [f32; JOINTS],
    settings: Option<&Settings>,
) -> FrameTransforms {
    let [l1_m, l2_m] = lengths_m(settings);
    let [q1, q2] = angle_rad.map(f64::from);
    let half = [foot_rad(settings) + q1, q2].map(|angle_rad| angle_rad / 2.0);
    let transform = |[parent, child]: [&str; 2], z_m: f64, rotation: Quaternion| FrameTransform {
        timestamp: Some(timestamp(at_ns)),
        parent_frame_id: parent.into(),
        child_frame_id: child.into(),
        translation: Some(along_z(z_m)),
        rotation: Some(rotation),
    };
    let about_x = Quaternion {
        x: half[0].sin(),
        w: half[0].cos(),
        ..Quaternion::default()
    };
    let about_y = Quaternion {
        y: half[1].sin(),
        w: half[1].cos(),
        ..Quaternion::default()
    };
    FrameTransforms {
        transforms: vec![
            transform(["table", "link1"], 0.0, about_x),
            transform(["link1", "link2"], l1_m, about_y),
            transform(["link2", "tip"], l2_m, upright()),
        ],
    }
}

/// Shapes of the links.
pub(super) fn scene(at_ns: u64, settings: Option<&Settings>) -> SceneUpdate {
    let [l1_m, l2_m] = lengths_m(settings);
    let entity = |frame: &str| SceneEntity {
        timestamp: Some(timestamp(at_ns)),
        frame_id: frame.into(),
        id: frame.into(),
        frame_locked: true,
        ..SceneEntity::default()
    };
    let link = |frame: &str, length_m: f64, color: Color| SceneEntity {
        cylinders: vec![CylinderPrimitive {
            pose: Some(Pose {
                position: Some(along_z(length_m / 2.0)),
                orientation: Some(upright()),
            }),
            size: Some(Vector3 {
                x: THICKNESS_M,
                y: THICKNESS_M,
                z: length_m,
            }),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: Some(color),
        }],
        ..entity(frame)
    };
    let table = SceneEntity {
        cubes: vec![CubePrimitive {
            pose: Some(Pose {
                position: Some(along_z(-THICKNESS_M * foot_rad(settings).cos())),
                orientation: Some(upright()),
            }),
            size: Some(Vector3 {
                x: 6.0 * THICKNESS_M,
                y: 6.0 * THICKNESS_M,
                z: THICKNESS_M,
            }),
            color: Some(GREY),
        }],
        ..entity("table")
    };
    SceneUpdate {
        deletions: Vec::new(),
        entities: vec![
            table,
            link("link1", l1_m, BLUE),
            link("link2", l2_m, ORANGE),
        ],
    }
}

/// An event as text.
pub(super) fn log(at_ns: u64, severity: Severity, name: String, message: String) -> Log {
    let level = match severity {
        Severity::Debug => log::Level::Debug,
        Severity::Info => log::Level::Info,
        Severity::Warning => log::Level::Warning,
        Severity::Error => log::Level::Error,
    };
    Log {
        timestamp: Some(timestamp(at_ns)),
        level: level.into(),
        message,
        name,
        ..Log::default()
    }
}

fn lengths_m(settings: Option<&Settings>) -> [f64; 2] {
    let arm = settings.map_or_else(Parameters::paper, |settings| settings.setup.arm);
    [arm.l1.into(), arm.l2.into()]
}

/// Rotation of the base about x: half a turn for a hanging arm.
fn foot_rad(settings: Option<&Settings>) -> f64 {
    match settings.map_or(Mounting::Upright, |settings| settings.setup.arm.mounting) {
        Mounting::Upright => 0.0,
        Mounting::Hanging => core::f64::consts::PI,
    }
}

fn along_z(z: f64) -> Vector3 {
    Vector3 {
        z,
        ..Vector3::default()
    }
}

fn upright() -> Quaternion {
    Quaternion {
        w: 1.0,
        ..Quaternion::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rotated vector.
    fn turned(by: Quaternion, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let by = nalgebra::Quaternion::new(by.w, by.x, by.y, by.z);
        let by = nalgebra::UnitQuaternion::from_quaternion(by);
        (by * nalgebra::Vector3::new(x, y, z)).into()
    }

    /// Position of the tip, relative to the table.
    fn tip_m(angle_rad: [f32; JOINTS], settings: &Settings) -> [f64; 3] {
        let frames = transforms(0, angle_rad, Some(settings)).transforms;
        frames.iter().rev().fold([0.0; 3], |at, frame| {
            let [x, y, z] = turned(frame.rotation.unwrap(), at);
            let by = frame.translation.unwrap();
            [x + by.x, y + by.y, z + by.z]
        })
    }

    fn is_near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
    }

    #[test]
    fn a_hanging_arm_is_drawn_below_its_base() {
        const TURNED: [f32; JOINTS] = [core::f32::consts::FRAC_PI_2, 0.0];

        let mut settings = Settings::default();
        assert!(is_near(tip_m([0.0; JOINTS], &settings), [0.0, 0.0, 0.195]));
        let table_m = |settings: &Settings| {
            let scene = scene(0, Some(settings));
            let pose = scene.entities[0].cubes[0].pose.unwrap();
            pose.position.unwrap().z
        };
        assert!(table_m(&settings) < 0.0);

        settings.setup.arm.mounting = Mounting::Hanging;
        assert!(is_near(tip_m([0.0; JOINTS], &settings), [0.0, 0.0, -0.195]));
        assert!(table_m(&settings) > 0.0);
        // Turned by a right angle, it points the other way than an upright one.
        assert!(is_near(tip_m(TURNED, &settings), [0.0, 0.195, 0.0]));
        settings.setup.arm.mounting = Mounting::Upright;
        assert!(is_near(tip_m(TURNED, &settings), [0.0, -0.195, 0.0]));
    }
}
