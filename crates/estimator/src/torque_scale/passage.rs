//! When the middle wheel comes to where the front wheel was.

/// Cells from the front wheel to the middle one, and in memory: the distance in x changes with the
/// posture.
/// Definition.
const CELLS_BETWEEN: f64 = 24.0;
const CELLS: i64 = 40;
/// Largest number of a cell: ten million kilometres.
/// Guard.
const LARGEST: f64 = 1e12;

/// Motion and forces of a robot whose wheels roll, at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rolling {
    /// Power of the ground on each wheel, and of the damping of its module, W.
    pub power: [f64; 3],
    /// Power of the damping of all, W.
    pub damping: f64,
    /// Speed of Q, m/s: forward.
    pub speed: f64,
    /// Front and middle axle ahead of Q, m.
    pub axles: [f64; 2],
    /// Potential energy of the robot with its front and its middle axle at height 0, J.
    pub energy: [f64; 2],
    /// Kinetic energy of the robot, J.
    pub kinetic: f64,
}

impl Rolling {
    /// The mean of both sides of a rover: its body rises by the mean of what they rise by.
    pub fn mean(&self, other: &Self) -> Self {
        let of = |a: f64, b: f64| 0.5 * (a + b);
        let [p, q] = [self.power, other.power];
        let [a, b] = [self.axles, other.axles];
        let [e, f] = [self.energy, other.energy];
        Self {
            power: [0, 1, 2].map(|i| of(p[i], q[i])),
            damping: of(self.damping, other.damping),
            speed: of(self.speed, other.speed),
            axles: [0, 1].map(|i| of(a[i], b[i])),
            energy: [0, 1].map(|i| of(e[i], f[i])),
            kinetic: of(self.kinetic, other.kinetic),
        }
    }
}

/// Work and energy up to one sample, or between two passages of one place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Passed {
    /// Of each wheel: see [`Rolling::power`], J.
    pub work: [f64; 3],
    /// Potential energy of the robot, and what the damping took, J.
    pub energy: f64,
    /// Kinetic energy of the robot, J.
    pub kinetic: f64,
}

/// Records of the leading wheel (the front one on the way forward, the middle one on the way back)
/// at equal distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Passage {
    /// Distance between cells, m. Not part of the state.
    spacing: f64,
    /// What was when the leading wheel was at a place.
    records: [Passed; CELLS as usize],
    /// Number of the newest record, and how many without a gap there are; -1 before a way begins.
    newest: i64,
    count: i64,
    /// Last cell of the trailing wheel.
    trailing: i64,
    /// Whether the robot drives backwards.
    backwards: bool,
    /// Work of each wheel and of the damping, J, and place of Q, m.
    work: [f64; 3],
    damped: f64,
    place: f64,
}

impl Passage {
    /// Passages that share a part of the way: one a cell.
    /// Definition.
    pub const OVERLAP: f64 = CELLS_BETWEEN;

    /// For axles at a distance of `between`, m.
    pub fn new(between: f64) -> Self {
        Self {
            spacing: between / CELLS_BETWEEN,
            records: [Passed::default(); CELLS as usize],
            newest: 0,
            count: -1,
            trailing: 0,
            backwards: false,
            work: [0.0; 3],
            damped: 0.0,
            place: 0.0,
        }
    }

    /// The way ends: what was before is of no use.
    pub fn interrupt(&mut self) {
        self.count = -1;
        (self.work, self.damped, self.place) = ([0.0; 3], 0.0, 0.0);
    }

    /// Takes a sample, `dt` seconds after the last; `None` where the wheels do not simply roll.
    /// Returns what lies between two passages of a place where there is a new one.
    pub fn update(&mut self, rolling: Option<&Rolling>, dt: f64) -> Option<Passed> {
        let Some(rolling) = rolling else {
            self.interrupt();
            return None;
        };
        let [a, b, c] = self.work;
        if (rolling.speed < 0.0) != self.backwards || !(a + b + c + self.place).is_finite() {
            self.backwards = rolling.speed < 0.0;
            self.interrupt();
        }
        for (work, power) in self.work.iter_mut().zip(rolling.power) {
            *work += power * dt;
        }
        self.damped += rolling.damping * dt;
        self.place += rolling.speed * dt;
        // Of the leading and the trailing wheel.
        let mut places = rolling.axles.map(|axle| self.place + axle);
        let mut energy = rolling.energy.map(|energy| energy + self.damped);
        if self.backwards {
            places.swap(0, 1);
            energy.swap(0, 1);
        }
        let (lead_cell, trail_cell) = (self.cell(places[0])?, self.cell(places[1])?);
        if self.count < 0 || lead_cell - self.newest > CELLS || lead_cell < self.newest - CELLS {
            (self.newest, self.count, self.trailing) = (lead_cell, 0, trail_cell);
        }
        while self.newest < lead_cell {
            self.newest += 1;
            self.count = (self.count + 1).min(CELLS);
            if let Some(record) = self.records.get_mut(index(self.newest)) {
                *record = Passed {
                    work: self.work,
                    energy: energy[0],
                    kinetic: rolling.kinetic,
                };
            }
        }
        if trail_cell <= self.trailing {
            return None;
        }
        self.trailing = trail_cell;
        let known = trail_cell <= self.newest && trail_cell > self.newest - self.count;
        let record = self.records.get(index(trail_cell)).filter(|_| known)?;
        Some(Passed {
            work: [0, 1, 2].map(|i| self.work[i] - record.work[i]),
            energy: energy[1] - record.energy,
            kinetic: rolling.kinetic - record.kinetic,
        })
    }

    /// Number of the cell at a place (m), growing in the direction of the drive.
    fn cell(&self, place: f64) -> Option<i64> {
        let ahead = if self.backwards { -place } else { place };
        let cell = libm::floor(ahead / self.spacing);
        (cell.abs() < LARGEST).then_some(cell as i64)
    }
}

/// Where the record of a cell is.
fn index(cell: i64) -> usize {
    cell.rem_euclid(CELLS) as usize
}
