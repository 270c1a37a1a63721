//! Traction of a wheel: eq. (11), `T = mu(v) N`, and the laws that refine it near standstill of the
//! contact; rolling resistance.

use crate::contact::cubic_step;
use crate::drive::coulomb_sign;
use robhaz_model::named;

named! {
    /// Form of the friction law.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum FrictionKind {
        /// T/N is a function of the slip speed, in ADAMS's form.
        #[default]
        Adams = "adams",
        /// The brush model: T/N is a function of the slip ratio, with mu from the slip speed.
        Brush = "brush",
        /// ADAMS's form with a very small v_s: nearly Coulomb's law. Stiff.
        Rigid = "rigid",
    }
}

/// T/N as a function of the slip of a contact.
///
/// Both coefficients belong to all forms: the coefficient mu of a sliding contact is mu_s up to the
/// slip speed v_s, falls in a cubic to mu_d at v_d, and stays mu_d ([`Self::sliding_coefficient`]).
/// A constant mu in the paper's eq. (11), `T = mu N`, holds for a sliding wheel only. The forms
/// differ in the contact that grips:
///
/// - [`FrictionKind::Adams`] and [`FrictionKind::Rigid`]: a cubic from `-mu_s` to `+mu_s` for
///   `|v| <= v_s`.
/// - [`FrictionKind::Brush`]: with the slip ratio kappa ([`Slip::ratio`]) and
///   `a = C |kappa|/(3 mu)`, T/N is `sign(kappa) 3 mu (a - a^2 + a^3/3)` for a < 1 and mu beyond.
///   Source: H. B. Pacejka, *Tyre and Vehicle Dynamics*, ch. 3, with a parabolic distribution of
///   the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionLaw {
    /// Form of the law.
    pub kind: FrictionKind,
    /// Static coefficient mu_s, -.
    pub mu_s: f64,
    /// Dynamic coefficient mu_d, -.
    pub mu_d: f64,
    /// Slip speed up to which mu is mu_s, m/s. In ADAMS's form T/N reaches mu_s there.
    pub v_s: f64,
    /// Slip speed from which mu is mu_d, m/s.
    pub v_d: f64,
    /// Slip stiffness C of the brush model, -: slope of T/N over the slip ratio at zero slip. 5 is
    /// soft ground, 50 a hard wheel on rock. Other forms do not use it.
    pub slip_stiffness: f64,
    /// Coefficient f_r of the rolling resistance, -: 0.01 to 0.05 on firm ground, 0 for none.
    pub rolling: f64,
}

/// Speeds of a contact along its tangent, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slip {
    /// Speed u of the rim: absolute spin times the arm from the contact to the wheel's centre.
    /// Forward positive.
    pub rim: f64,
    /// Speed w of the wheel's centre. Forward positive.
    pub centre: f64,
}

impl Slip {
    /// Speed v_0 below which the slip ratio refers to v_0, m/s.
    pub const SLOWEST: f64 = 0.01;

    /// Slip speed v = u - w, m/s, positive when the rim is faster than the wheel's centre.
    pub fn speed(&self) -> f64 {
        self.rim - self.centre
    }

    /// Slip ratio kappa = (u - w)/max(|u|, |w|, v_0), -. It is finite at standstill.
    pub fn ratio(&self) -> f64 {
        self.speed() / self.reference()
    }

    /// max(|u|, |w|, v_0), m/s.
    fn reference(&self) -> f64 {
        self.rim.abs().max(self.centre.abs()).max(Self::SLOWEST)
    }
}

/// A parameter of a friction law: one that no other law has, or with a default or limits of its own.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// Its symbol in texts.
    pub symbol: &'static str,
    /// Its unit; empty for a number.
    pub unit: &'static str,
    /// Its field.
    pub at: fn(&mut FrictionLaw) -> &mut f64,
    /// Its value where none is given.
    pub default: f64,
    /// The least and the largest value that this law takes, where they are narrower than what such
    /// a parameter may be.
    pub limits: Option<[f64; 2]>,
    /// Whether it also shapes mu(v), so that every law has it.
    pub is_shared: bool,
}

impl Parameter {
    /// Its value in a law.
    pub fn of(&self, law: &FrictionLaw) -> f64 {
        let mut law = *law;
        *(self.at)(&mut law)
    }
}

impl FrictionKind {
    /// The parameters of this law, those that set its steepest slope
    /// ([`FrictionLaw::steepest_slope`]).
    pub const fn parameters(self) -> &'static [Parameter] {
        const V_S: Parameter = Parameter {
            name: "v_s",
            symbol: "v_s",
            unit: "m/s",
            at: |law| &mut law.v_s,
            default: 0.02,
            limits: None,
            is_shared: true,
        };
        match self {
            Self::Adams => &[V_S],
            Self::Brush => &[Parameter {
                name: "slip_stiffness",
                symbol: "C",
                unit: "",
                at: |law| &mut law.slip_stiffness,
                default: 20.0,
                limits: None,
                is_shared: false,
            }],
            // At most a tenth of the default of ADAMS's form.
            Self::Rigid => &[Parameter {
                default: 1e-3,
                limits: Some([0.2e-3, 2e-3]),
                ..V_S
            }],
        }
    }

    /// Whether an explicit step may be cut where the contact is stiff. With a law for implicit
    /// methods all steps would be cut.
    pub const fn bears_cut_steps(self) -> bool {
        match self {
            Self::Adams | Self::Brush => true,
            Self::Rigid => false,
        }
    }

    /// The parameters of all laws.
    pub fn all_parameters() -> impl DoubleEndedIterator<Item = &'static Parameter> {
        Self::ALL.into_iter().flat_map(Self::parameters)
    }
}

impl Default for FrictionLaw {
    /// ADAMS's form with mu_s = 0.8, mu_d = 0.7, v_s = 0.02 m/s, v_d = 0.10 m/s; C = 20 for the
    /// brush model.
    fn default() -> Self {
        Self::of(FrictionKind::default())
    }
}

impl FrictionLaw {
    /// The law of a form with its default parameters.
    pub fn of(kind: FrictionKind) -> Self {
        let mut law = Self {
            kind,
            mu_s: 0.8,
            mu_d: 0.7,
            v_s: 0.0,
            v_d: 0.10,
            slip_stiffness: 0.0,
            rolling: 0.0,
        };
        // Its own come last; before them the default of the first law that declares one.
        for parameter in FrictionKind::all_parameters()
            .rev()
            .chain(kind.parameters())
        {
            *(parameter.at)(&mut law) = parameter.default;
        }
        law
    }

    /// T/N, -, with the sign of the slip.
    #[inline]
    pub fn coefficient(&self, slip: &Slip) -> f64 {
        let v = slip.speed();
        match self.kind {
            FrictionKind::Adams | FrictionKind::Rigid => {
                if v.abs() <= self.v_s {
                    cubic_step(v, -self.v_s, -self.mu_s, self.v_s, self.mu_s)
                } else {
                    self.sliding_coefficient(v).copysign(v)
                }
            }
            FrictionKind::Brush => {
                let mu = self.sliding_coefficient(v);
                let a = self.slip_stiffness * slip.ratio().abs() / (3.0 * mu);
                // Without friction a is infinite, or NaN without slip; then T/N = mu = 0.
                let coefficient = if a < 1.0 {
                    3.0 * mu * a * (1.0 - a * (1.0 - a / 3.0))
                } else {
                    mu
                };
                coefficient.copysign(v)
            }
        }
    }

    /// Moment `f_r r N` of the ground that resists a forward spin, N m, negative for a backward one, for a normal force (N), wheel radius r (m) and
    /// absolute spin (rad/s), at each contact. At standstill its sign is smoothed like that of the
    /// gear friction: [`coulomb_sign`].
    ///
    /// The traction T is not part of it: a wheel that rolls freely has T = 0 and is braked by this
    /// moment alone.
    #[inline]
    pub fn rolling_moment(&self, normal_force: f64, wheel_radius: f64, spin: f64) -> f64 {
        if self.rolling > 0.0 {
            self.rolling * wheel_radius * normal_force * coulomb_sign(spin)
        } else {
            0.0
        }
    }

    /// Coefficient mu of a contact that slides at the slip speed `v` (m/s, any sign), -: mu_s up to
    /// v_s, mu_d from v_d on, a cubic between them.
    #[inline]
    pub fn sliding_coefficient(&self, v: f64) -> f64 {
        cubic_step(v.abs(), self.v_s, self.mu_s, self.v_d, self.mu_d)
    }

    /// Slip speed beyond which the contact slides, m/s, at this slip: there T/N is at the limit of
    /// friction.
    ///
    /// In ADAMS's form it is v_s. In the brush model it is where a = 1,
    /// `3 mu max(|u|, |w|, v_0)/C`.
    #[inline]
    pub fn slip_limit(&self, slip: &Slip) -> f64 {
        match self.kind {
            FrictionKind::Adams | FrictionKind::Rigid => self.v_s,
            FrictionKind::Brush => {
                let mu = self.sliding_coefficient(slip.speed());
                3.0 * mu * slip.reference() / self.slip_stiffness
            }
        }
    }

    /// Largest slope of T/N over the slip speed, s/m: that at zero slip, `3 mu_s/(2 v_s)` in
    /// ADAMS's form, `C/v_0` in the brush model at standstill.
    pub fn steepest_slope(&self) -> f64 {
        match self.kind {
            FrictionKind::Adams | FrictionKind::Rigid => 1.5 * self.mu_s / self.v_s,
            FrictionKind::Brush => self.slip_stiffness / Slip::SLOWEST,
        }
    }

    /// The law at x (m). The first stretch that contains x replaces the coefficients; form, slip
    /// speeds and slip stiffness stay.
    #[inline]
    pub fn at(&self, stretches: &[Stretch], x: f64) -> Self {
        match stretches.iter().find(|s| s.from <= x && x < s.to) {
            Some(stretch) => Self {
                mu_s: stretch.mu_s,
                mu_d: stretch.mu_d,
                ..*self
            },
            None => *self,
        }
    }
}

/// A stretch of the terrain with its own friction coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// x at which it starts, m.
    pub from: f64,
    /// x at which it ends, m. The end does not belong to it.
    pub to: f64,
    /// Static coefficient mu_s, -.
    pub mu_s: f64,
    /// Dynamic coefficient mu_d, -.
    pub mu_d: f64,
}

#[cfg(test)]
mod tests;
