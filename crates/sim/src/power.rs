//! `x^n` for one exponent n: the spring of the contact law, evaluated for each contact in each
//! record and stage.

/// Binary digits of x that choose a node: 32 nodes for each power of two.
const DIGITS: u32 = 5;
/// Least and greatest x of the table as powers of two: 15 um and 16 mm. Penetrations are between
/// them.
const RANGE: [i32; 2] = [-16, -6];
/// Degree of the series.
const DEGREE: usize = 7;

/// `x^n` for one exponent n.
///
/// Between a node a and its neighbours `x^n = a^n (1 + e)^n` with `e = (x - a)/a`, at most 1/64,
/// and the binomial series in e. Its terms beyond the seventh are below 1e-17 for exponents up
/// to 5. The node is that of x alone, so the value does not depend on earlier ones.
#[derive(Clone, Debug)]
pub(crate) struct Power {
    exponent: f64,
    /// Binomial coefficients of the exponent from the second on.
    series: [f64; DEGREE],
    /// 1/a and a^n of each node.
    nodes: Vec<[f64; 2]>,
}

/// The leading digits of a positive number, which grow with it.
fn key(x: f64) -> u64 {
    x.to_bits() >> (f64::MANTISSA_DIGITS - 1 - DIGITS)
}

/// The middle of all numbers with these leading digits.
fn node(key: u64) -> f64 {
    f64::from_bits(((key << 1) | 1) << (f64::MANTISSA_DIGITS - 2 - DIGITS))
}

/// The key of the first node.
fn first_key() -> u64 {
    key(2.0_f64.powi(RANGE[0]))
}

impl Power {
    /// For an exponent.
    pub fn new(exponent: f64) -> Self {
        let mut series = [0.0; DEGREE];
        let (mut coefficient, mut k) = (1.0, 0.0);
        for entry in &mut series {
            coefficient *= (exponent - k) / (k + 1.0);
            k += 1.0;
            *entry = coefficient;
        }
        let keys = first_key()..key(2.0_f64.powi(RANGE[1]));
        let nodes = keys.map(node).map(|a| [1.0 / a, a.powf(exponent)]);
        Self {
            exponent,
            series,
            nodes: nodes.collect(),
        }
    }

    /// `x^n` for x > 0.
    #[inline]
    pub fn of(&self, x: f64) -> f64 {
        let key = key(x);
        let index = usize::try_from(key.wrapping_sub(first_key())).unwrap_or(usize::MAX);
        let Some([per_node, power]) = self.nodes.get(index) else {
            return x.powf(self.exponent);
        };
        let e = (x - node(key)) * per_node;
        let [c1, c2, c3, c4, c5, c6, c7] = self.series;
        // Two chains of products instead of one: half the time.
        let square = e * e;
        let odd = c1 + square * (c3 + square * (c5 + square * c7));
        let even = c2 + square * (c4 + square * c6);
        power + power * (e * odd + square * even)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equivalence: the powers are those of the library to four times their last digit, over all
    /// penetrations and beyond the table, also at nodes and between them.
    #[test]
    fn powers_are_those_of_the_library() {
        let mut largest = 0.0_f64;
        for exponent in [1.0, 1.5, 2.1, 3.0, 4.6, 5.0] {
            let power = Power::new(exponent);
            let mut x = 1e-9;
            while x < 0.2 {
                let error = power.of(x) / x.powf(exponent) - 1.0;
                largest = largest.max(error.abs());
                x *= 1.000_37;
            }
            let ends = [node(first_key()), 2.0_f64.powi(-9), 1.0 / 3.0];
            for x in ends.into_iter().flat_map(|x| [x, x.next_down()]) {
                let error = power.of(x) / x.powf(exponent) - 1.0;
                largest = largest.max(error.abs());
            }
        }
        println!("largest error {largest:e}");
        assert!(largest < 4.0 * f64::EPSILON, "{largest:e}");
    }
}
