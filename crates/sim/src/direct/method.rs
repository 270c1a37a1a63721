//! Radau IIA of order 5: its coefficients, and the polynomial over a step.
//!
//! Source: E. Hairer and G. Wanner, *Solving Ordinary Differential Equations II*, IV.5 and IV.8.

use nalgebra::{Complex, SVector};

/// What belongs to the three stages of a step.
pub(super) type Stages<const M: usize> = [SVector<f64, M>; 3];

/// Nodes of the method besides 1: (4 -+ sqrt 6)/10.
pub(super) const C1: f64 = 0.155_051_025_721_682_2;
pub(super) const C2: f64 = 0.644_948_974_278_317_8;
/// Weights of the method: integrals from the start of a step to each node.
pub(super) const A: [[f64; 3]; 3] = [
    [
        0.196_815_477_223_660_44,
        -0.065_535_425_850_198_39,
        0.023_770_974_348_220_15,
    ],
    [
        0.394_424_314_739_087_3,
        0.292_073_411_665_228_45,
        -0.041_548_752_125_997_93,
    ],
    [
        0.376_403_062_700_467_3,
        0.512_485_826_188_421_6,
        0.111_111_111_111_111_1,
    ],
];
/// Eigenvalues of the inverse of the weights: one real, one pair.
pub(super) const REAL: f64 = 3.637_834_252_744_496;
pub(super) const PAIR: Complex<f64> =
    Complex::new(2.681_082_873_627_752_3, 3.050_430_199_247_410_5);
/// From transformed stages to stages, and back.
pub(super) const T: [[f64; 3]; 3] = [
    [
        9.123_239_487_089_295e-2,
        -0.141_255_295_020_954_2,
        -3.002_919_410_514_742_4e-2,
    ],
    [
        0.241_717_932_707_107,
        0.204_129_352_293_799_93,
        0.382_942_112_757_262,
    ],
    [0.966_048_182_615_093, 1.0, 0.0],
];
pub(super) const T_INVERSE: [[f64; 3]; 3] = [
    [
        4.325_579_890_063_155,
        0.339_199_251_815_809_9,
        0.541_770_539_935_874_9,
    ],
    [
        -4.178_718_591_551_905,
        -0.327_682_820_761_062_4,
        0.476_623_554_500_550_44,
    ],
    [
        -0.502_872_634_945_786_9,
        2.571_926_949_855_605,
        -0.596_039_204_828_224_9,
    ],
];
/// Weights of the stages in the error estimate, which is the difference to a formula of order 3.
pub(super) const ERROR: [f64; 3] = [-10.048_809_399_827_416, 1.382_142_733_160_749, -1.0 / 3.0];

/// Cubic polynomial over a step, as divided differences from the end of the step.
#[derive(Clone, Copy)]
pub(super) struct Cubic<const M: usize>(pub Stages<M>);

impl<const M: usize> Cubic<M> {
    /// From the increments at the three nodes.
    pub fn new(z: &Stages<M>) -> Self {
        let b = (z[1] - z[2]) / (C2 - 1.0);
        let ak = (z[0] - z[1]) / (C1 - C2);
        let c = (ak - b) / (C1 - 1.0);
        let d = c - (ak - z[0] / C1) / C2;
        Self([b, c, d])
    }

    /// Increment from the step's end to `s` steps beyond it; negative within the step.
    #[inline]
    pub fn beyond(&self, s: f64) -> SVector<f64, M> {
        let [b, c, d] = self.0;
        (b + (c + d * (s - (C1 - 1.0))) * (s - (C2 - 1.0))) * s
    }
}

/// Product of the matrix `rows` with three vectors.
pub(super) fn combined<const M: usize>(rows: &[[f64; 3]; 3], v: &Stages<M>) -> Stages<M> {
    rows.map(|[a, b, c]| v[0] * a + v[1] * b + v[2] * c)
}
