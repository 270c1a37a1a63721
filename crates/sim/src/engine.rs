//! The interface of the engines.

use crate::balance::Balance;
use crate::error::PlantError;
use crate::truth::Truth;
use robhaz_model::WheelCommand;

/// An engine: it integrates the motion and evaluates the truth once per period.
pub(crate) trait Engine: Send {
    /// Mean integration step since the start, s.
    fn mean_step(&self) -> f64;

    /// Sets the commands of the wheels from the next instant on.
    fn command(&mut self, commands: [WheelCommand; 3]);

    /// Writes the truth at the current time to `instant`. The simulation then advances by one
    /// period. A return value would be copied several times, and it has 1.1 kB.
    fn next_instant(&mut self, instant: &mut Instant) -> Result<(), PlantError>;
}

/// The truth at one instant, with the energies that [`Truth`] does not contain.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Instant {
    pub truth: Truth,
    /// Elastic energy of all contacts, J.
    pub contact_energy: f64,
    /// Work of the motors since the start. The other integrals are zero unless
    /// [`PlantSetup::balance`](crate::PlantSetup::balance) is set.
    pub balance: Balance,
}
