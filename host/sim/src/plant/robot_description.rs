//! Robot descriptions: an arm as MJCF for MuJoCo, and as URDF.
//!
//! Both have the equations of motion of [`Parameters`] exactly: joint 1 about x at the table,
//! joint 2 about y at the end of link 1, centres of mass at half length, viscous friction, Coulomb
//! friction, end stops, the largest torque of the motors.
//!
//! The inertias of Table 1 are mostly those of geared rotors, and no rigid body has them: of the
//! moments of a body, none is larger than the sum of the other two. MJCF has the rotors apart, as
//! `armature`. URDF has not, so its inertias are others with the same equations: link 1 turns about
//! x alone, and its other moments are free; a moment that is added to link 2 about x and z, and
//! taken from link 1 about x, cancels, because `cos^2 q2 + sin^2 q2 = 1`.
//!
//! Left out: static friction beyond Coulomb's, Stribeck's curve, friction that grows with the load
//! on the gears, dead zones, delays, encoders.

use std::fmt::Write;

use armbridge_control::arm::{Mounting, Parameters};
use armbridge_servo::JOINTS;

use super::PlantConfig;

/// Side of the links' drawn boxes in m: that of an AX-12A.
const WIDTH_M: f64 = 0.03;
/// Speed of an AX-12A without load in rad/s: 59 rpm (e-Manual), which URDF asks for.
const SPEED_RAD_S: f64 = 59.0 / 60.0 * 2.0 * core::f64::consts::PI;

/// An arm that a rigid-body simulator cannot have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "URDF cannot have this arm: with rotors of {rotor_kg_m2:.5} kg m² at joint 2, link 1 would \
     have {left_kg_m2:.5} kg m² left about x; write it as mjcf"
)]
pub struct NoRigidBody {
    rotor_kg_m2: f64,
    left_kg_m2: f64,
}

/// A format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RobotFormat {
    /// MuJoCo's.
    Mjcf,
    /// The Unified Robot Description Format.
    Urdf,
}

impl RobotFormat {
    /// Extension of its files.
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Mjcf => "xml",
            Self::Urdf => "urdf",
        }
    }

    /// Describes an arm.
    ///
    /// # Errors
    /// If no rigid bodies have its inertias.
    pub fn describe(self, plant: &PlantConfig) -> Result<String, NoRigidBody> {
        match self {
            Self::Mjcf => Ok(mjcf(plant)),
            Self::Urdf => urdf(plant),
        }
    }
}

/// What both formats have of a joint.
struct JointDescription {
    name: &'static str,
    axis: &'static str,
    damping: f64,
    coulomb_nm: f64,
    stops_rad: [f64; 2],
    torque_nm: f64,
}

fn joints(plant: &PlantConfig) -> [JointDescription; JOINTS] {
    let arm = plant.true_arm();
    let friction = plant.true_friction();
    core::array::from_fn(|joint| {
        let most = [0, 2_000].map(|pwm| plant.torque(joint, pwm).abs());
        JointDescription {
            name: ["joint1", "joint2"][joint],
            axis: ["1 0 0", "0 1 0"][joint],
            damping: [arm.b1, arm.b2][joint],
            coulomb_nm: friction[joint].coulomb_nm,
            stops_rad: plant.stops_rad[joint],
            torque_nm: most[0].max(most[1]),
        }
    })
}

fn mjcf(plant: &PlantConfig) -> String {
    let arm = plant.true_arm();
    // Of a moment about a joint's axis, the part that a body may have is the link's.
    let body_1x = arm.i1x.min(arm.i1y + arm.i1z);
    let body_2y = arm.i2y.min(arm.i2x + arm.i2z);
    let armature = [arm.i1x - body_1x, arm.i2y - body_2y];
    let inertia = [
        [body_1x, arm.i1y, arm.i1z].map(|moment| moment.max(f64::MIN_POSITIVE)),
        [arm.i2x, body_2y, arm.i2z],
    ];
    let joints = joints(plant);
    let joint = |j: usize| {
        let JointDescription {
            name,
            axis,
            damping,
            coulomb_nm,
            stops_rad: [low, high],
            ..
        } = joints[j];
        let armature = armature[j];
        format!(
            r#"<joint name="{name}" axis="{axis}" range="{low} {high}" damping="{damping}" frictionloss="{coulomb_nm}" armature="{armature}"/>"#
        )
    };
    let body = |j: usize, length: f64, mass: f64| {
        let [x, y, z] = inertia[j];
        let (half, side) = (length / 2.0, WIDTH_M / 2.0);
        format!(
            r#"<inertial pos="0 0 {half}" mass="{mass}" diaginertia="{x} {y} {z}"/>
        <geom type="box" pos="0 0 {half}" size="{side} {side} {half}"/>"#
        )
    };
    let mut text = format!(
        r#"<mujoco model="armbridge">
  <!-- Angles in rad from upright, torques in N m; the actuators are the motors, without their delay. -->
  <compiler angle="radian" autolimits="true" inertiafromgeom="false"/>
  <option timestep="0.001" gravity="0 0 -{g}" integrator="implicitfast"/>
  <default>
    <geom contype="0" conaffinity="0"/>
  </default>
  <worldbody>
    <body name="foot"{foot}>
      <body name="link1">
        {joint1}
        {body1}
        <body name="link2" pos="0 0 {l1}">
          {joint2}
          {body2}
          <site name="tip" pos="0 0 {l2}"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
"#,
        g = arm.g,
        foot = match arm.mounting {
            Mounting::Upright => "",
            Mounting::Hanging => r#" quat="0 1 0 0""#,
        },
        joint1 = joint(0),
        joint2 = joint(1),
        body1 = body(0, arm.l1, arm.m1),
        body2 = body(1, arm.l2, arm.m2),
        l1 = arm.l1,
        l2 = arm.l2,
    );
    for JointDescription {
        name, torque_nm, ..
    } in &joints
    {
        // To a String.
        let _ = writeln!(
            text,
            r#"    <motor name="motor_{name}" joint="{name}" ctrlrange="-{torque_nm} {torque_nm}"/>"#
        );
    }
    text + "  </actuator>\n</mujoco>\n"
}

/// Moments of both links about x, y and z that rigid bodies have, and the same equations.
fn rigid_moments(arm: &Parameters<f64>) -> Result<[[f64; 3]; JOINTS], NoRigidBody> {
    let excess = (arm.i2y - arm.i2x - arm.i2z).max(0.0) / 2.0;
    let left = arm.i1x - excess;
    if left <= 0.0 {
        return Err(NoRigidBody {
            rotor_kg_m2: arm.i2y,
            left_kg_m2: left,
        });
    }
    Ok([[left; 3], [arm.i2x + excess, arm.i2y, arm.i2z + excess]])
}

fn urdf(plant: &PlantConfig) -> Result<String, NoRigidBody> {
    let arm = plant.true_arm();
    let moments = rigid_moments(&arm)?;
    let link = |j: usize, length: f64, mass: f64| {
        let ([x, y, z], half, name) = (moments[j], length / 2.0, j + 1);
        format!(
            r#"  <link name="link{name}">
    <inertial>
      <origin xyz="0 0 {half}"/>
      <mass value="{mass}"/>
      <inertia ixx="{x}" iyy="{y}" izz="{z}" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <visual>
      <origin xyz="0 0 {half}"/>
      <geometry><box size="{WIDTH_M} {WIDTH_M} {length}"/></geometry>
    </visual>
  </link>
"#
        )
    };
    let joints = joints(plant);
    let joint = |j: usize, parent: &str, height: f64| {
        let JointDescription {
            name,
            axis,
            damping,
            coulomb_nm,
            stops_rad: [low, high],
            torque_nm,
        } = joints[j];
        let child = j + 1;
        format!(
            r#"  <joint name="{name}" type="revolute">
    <parent link="{parent}"/>
    <child link="link{child}"/>
    <origin xyz="0 0 {height}"/>
    <axis xyz="{axis}"/>
    <limit lower="{low}" upper="{high}" effort="{torque_nm}" velocity="{SPEED_RAD_S}"/>
    <dynamics damping="{damping}" friction="{coulomb_nm}"/>
  </joint>
"#
        )
    };
    let roll = match arm.mounting {
        Mounting::Upright => 0.0,
        Mounting::Hanging => core::f64::consts::PI,
    };
    Ok(format!(
        r#"<?xml version="1.0"?>
<!-- Angles in rad from upright. Inertias that rotors cannot have are moved between the links: the equations of motion are the same. -->
<robot name="armbridge">
  <link name="table"/>
  <link name="foot"/>
  <joint name="mounting" type="fixed">
    <parent link="table"/>
    <child link="foot"/>
    <origin rpy="{roll} 0 0"/>
  </joint>
{joint1}{link1}{joint2}{link2}</robot>
"#,
        joint1 = joint(0, "foot", 0.0),
        link1 = link(0, arm.l1, arm.m1),
        joint2 = joint(1, "link1", arm.l1),
        link2 = link(1, arm.l2, arm.m2),
    ))
}
