//! Data of each model beside those of `armbridge_servo::protocol2::model`: initial values and
//! ranges of its control table, and its motor.
//!
//! From the e-Manual's control tables and specifications. The velocity limit of the XM430-W350 is
//! that of the revision of 2018.

use armbridge_servo::protocol2::model::Model;

/// Initial values of the gains: velocity I and P, position D, I and P.
pub(super) type Gains = [i32; 5];

/// Where the indirect addresses and data are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct IndirectBlock {
    /// First indirect address.
    pub(super) addresses: u16,
    /// First byte of indirect data.
    pub(super) data: u16,
    /// Number of both.
    pub(super) count: u16,
}

/// PWM slope of the models that have one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slope {
    /// Initial value of the register.
    pub(super) initial: i32,
    /// Unit of the register in mV/ms.
    pub(super) mv_per_ms: f64,
}

/// Data of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Specification {
    number: u16,
    /// Largest code of the baud rate.
    pub(super) baud_max: i32,
    /// Lowest and highest supply limit, and the initial lower limit, in 0.1 V.
    pub(super) supply_decivolt: [i32; 3],
    /// Initial and largest velocity limit, in 0.229 rpm.
    pub(super) velocity_limit: [i32; 2],
    /// Initial shutdown mask.
    pub(super) shutdown: i32,
    pub(super) gains: Gains,
    pub(super) slope: Option<Slope>,
    pub(super) indirect: &'static [IndirectBlock],
    /// Position counts times gain of a count of PWM: 128 by the e-Manual ("Position PID Gain");
    /// 256 by recordings of an XL330 (the data of Rhoban/bam), which this follows for the smaller
    /// frame.
    pub(super) position_p_divisor: f64,
    /// Current at standstill and the recommended supply, in A.
    pub(super) stall_a: f64,
    /// Mass in g.
    pub(super) mass_g: f64,
}

const X430_BLOCKS: &[IndirectBlock] = &[
    IndirectBlock {
        addresses: 168,
        data: 224,
        count: 28,
    },
    IndirectBlock {
        addresses: 578,
        data: 634,
        count: 28,
    },
];
const X330_BLOCKS: &[IndirectBlock] = &[IndirectBlock {
    addresses: 168,
    data: 208,
    count: 20,
}];

/// What the models of the larger frame have in common: the XM430-W210.
const X430: Specification = Specification {
    number: 1030,
    baud_max: 7,
    supply_decivolt: [95, 160, 95],
    velocity_limit: [330, 1023],
    shutdown: 52,
    gains: [1_920, 100, 0, 0, 800],
    slope: None,
    indirect: X430_BLOCKS,
    position_p_divisor: 128.0,
    stall_a: 2.3,
    mass_g: 82.0,
};

/// What the models of the smaller frame have in common: the XL330-M288.
const X330: Specification = Specification {
    number: 1200,
    baud_max: 6,
    supply_decivolt: [31, 70, 35],
    velocity_limit: [445, 2_047],
    shutdown: 53,
    gains: [1_600, 180, 0, 0, 400],
    slope: Some(Slope {
        initial: 140,
        mv_per_ms: 1.977,
    }),
    indirect: X330_BLOCKS,
    position_p_divisor: 256.0,
    stall_a: 1.47,
    mass_g: 18.0,
};

const SPECIFICATIONS: [Specification; 6] = [
    Specification {
        number: 1020,
        velocity_limit: [350, 1_023],
        ..X430
    },
    X430,
    Specification {
        number: 1060,
        supply_decivolt: [60, 140, 60],
        velocity_limit: [265, 1_023],
        gains: [1_000, 100, 4_000, 0, 640],
        stall_a: 1.3,
        mass_g: 57.2,
        ..X430
    },
    Specification {
        number: 1190,
        velocity_limit: [1_620, 2_047],
        gains: [400, 40, 0, 400, 400],
        ..X330
    },
    X330,
    Specification {
        number: 1220,
        supply_decivolt: [55, 140, 55],
        velocity_limit: [320, 2_047],
        shutdown: 52,
        gains: [1_200, 40, 0, 0, 900],
        slope: Some(Slope {
            initial: 255,
            mv_per_ms: 3.955,
        }),
        stall_a: 0.8,
        mass_g: 23.0,
        ..X330
    },
];

/// That of a model; of an unknown one that of the XM430-W210.
pub(super) fn find(model: &Model) -> &'static Specification {
    let mut all = SPECIFICATIONS.iter();
    all.find(|specification| specification.number == model.number)
        .unwrap_or(&X430)
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_servo::protocol2::model::MODELS;

    #[test]
    fn every_model_has_one() {
        for model in &MODELS {
            let specification = find(model);
            assert_eq!(specification.number, model.number);
            if let Some(current) = model.current {
                let torque_nm = specification.stall_a * f64::from(current.nm_per_a);
                assert!((torque_nm - f64::from(model.stall_nm)).abs() < 1e-3);
            }
        }
    }
}
