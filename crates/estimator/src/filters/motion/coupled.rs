//! Two motion filters as one: those of both sides of a whole rover. What a measurement of both ties
//! together is their covariance, which each filter keeps while it takes its own measurements.
//!
//! A side's own measurements do not correct the other side's states: these are considered (Schmidt),
//! which keeps what is stated right and loses little, since what ties the sides are errors that last.

use super::filter::{Guests, MotionFilter};
use crate::deviation::GATE;
use crate::filters::{Innovation, Projection};
use crate::state::{COUNT, RESISTANCE, TORQUE_GAIN};

/// A measurement of states of both sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointMeasurement<const K: usize> {
    /// Measured minus predicted.
    pub innovation: f64,
    /// Of each side: states, each with the derivative by it.
    pub rows: [[(usize, f64); K]; 2],
    /// Deviation of its error at one sample.
    pub sigma: f64,
    /// Variance of the white noise that is as uncertain over many samples ([`GaussMarkov::white`]).
    pub white: f64,
}

impl MotionFilter {
    /// The covariance with the other side, as that side's filter has it.
    pub fn guests_of_other(&self) -> Guests {
        let mut turned = [[0.0; COUNT]; COUNT];
        if let Some(guests) = &self.guests {
            for (i, row) in guests.iter().enumerate() {
                for (column, entry) in turned.iter_mut().zip(row) {
                    column[i] = *entry;
                }
            }
        }
        turned
    }

    /// Couples two filters that start: what resists the spin is common to all six wheels.
    pub fn couple(&mut self) {
        let mut guests = [[0.0; COUNT]; COUNT];
        let state = RESISTANCE.of(0);
        guests[state][state] = self.filter.p[state][state];
        self.guests = Some(guests);
    }

    /// Whether it is that of one side of a whole rover.
    pub fn is_coupled(&self) -> bool {
        self.guests.is_some()
    }

    /// Takes over the covariance with the other side.
    pub fn set_guests(&mut self, guests: Guests) {
        self.guests = Some(guests);
    }

    /// The guests' part of a correction with the row `h`, the covariances `ph` and the variance `s`.
    pub(super) fn correct_guests(&mut self, h: &[(usize, f64)], ph: &[f64; COUNT], s: f64) {
        let Some(guests) = &mut self.guests else {
            return;
        };
        let mut with = [0.0; COUNT];
        for &(state, value) in h {
            if let Some(row) = guests.get(state) {
                for (with, entry) in with.iter_mut().zip(row) {
                    *with += value * entry;
                }
            }
        }
        for (i, (row, ph)) in guests.iter_mut().zip(ph).enumerate() {
            if TORQUE_GAIN.all().contains(&i) {
                continue;
            }
            let gain = ph / s;
            for (entry, with) in row.iter_mut().zip(&with) {
                *entry -= gain * with;
            }
        }
    }

    /// Corrects both sides by a measurement of both: `left` keeps the covariance of both. One beyond its gate
    /// shows what the equations do not hold for, and corrects nothing. Returns the innovation with its predicted
    /// variance.
    pub fn correct_both<const K: usize>(
        left: &mut Self,
        right: &mut Self,
        measurement: &JointMeasurement<K>,
    ) -> Innovation {
        let rows = &measurement.rows;
        let mut projections = [
            left.filter.project(&rows[0]),
            right.filter.project(&rows[1]),
        ];
        let mut variance = projections[0].variance + projections[1].variance;
        if let Some(guests) = &left.guests {
            let [of_left, of_right] = &mut projections;
            for (ph, row) in of_left.ph.iter_mut().zip(guests) {
                for (k, value) in rows[1] {
                    *ph += row.get(k).map_or(0.0, |entry| entry * value);
                }
            }
            for (k, value) in rows[0] {
                if let Some(row) = guests.get(k) {
                    for (ph, entry) in of_right.ph.iter_mut().zip(row) {
                        *ph += entry * value;
                    }
                    for (other, of_other) in rows[1] {
                        variance += 2.0 * value * of_other * row.get(other).copied().unwrap_or(0.0);
                    }
                }
            }
        }
        let found = Innovation {
            value: measurement.innovation,
            variance: variance + measurement.sigma * measurement.sigma,
        };
        let s = variance + measurement.white;
        if found.inflated(GATE) == Some(found.variance) && s > 0.0 {
            Self::apply_both(left, right, &projections, found.value, s);
        }
        found
    }

    fn apply_both(
        left: &mut Self,
        right: &mut Self,
        [of_left, of_right]: &[Projection<COUNT>; 2],
        innovation: f64,
        s: f64,
    ) {
        left.filter.apply(&of_left.ph, innovation, s);
        right.filter.apply(&of_right.ph, innovation, s);
        let guests = left.guests.get_or_insert([[0.0; COUNT]; COUNT]);
        for (i, (row, a)) in guests.iter_mut().zip(&of_left.ph).enumerate() {
            let gain = a / s;
            // Considered states keep what they have among themselves.
            let considered = TORQUE_GAIN.all();
            let kept = considered.contains(&i);
            for (k, (entry, b)) in row.iter_mut().zip(&of_right.ph).enumerate() {
                if !(kept && considered.contains(&k)) {
                    *entry -= gain * b;
                }
            }
        }
    }
}
