//! Numbers of a text table: one decimal mark in all of it, no thousands separators.
//!
//! `12,345` is 12.345 in a table with decimal commas and 12 345 counts in one with decimal points. The other cells
//! show which: a second mark is an error. Where all marks are the same, a column shows it in which every mark has
//! exactly three digits behind it, beside whole numbers below 1000.

use crate::text_table::decimal;

/// Cells with three digits behind the mark, each other than the one before it, from which on a column with whole
/// numbers from 100 to 999 is one with thousands separators. Of numbers with up to three decimals, without trailing
/// zeros, 0.9^8 = 43 % look so, and then one in a thousand is whole.
const GROUPED: u32 = 8;
/// The same beside whole numbers below 100 alone, such as a zero: 0.9^100 = 3e-5.
const GROUPED_ALONE: u32 = 100;

/// What a cell with a number may be.
pub const NUMBER: &str = "a number with a decimal point or comma and no thousands separators";

/// The decimal mark of a table, as its numbers show it.
#[derive(Clone, Debug, Default)]
pub struct Decimals(Option<Mark>);

/// The first number with a mark.
#[derive(Clone, Debug)]
struct Mark {
    mark: char,
    line: u64,
    cell: String,
}

impl Decimals {
    /// The number of a cell.
    ///
    /// # Errors
    /// What is allowed, where the cell is no number of this table.
    pub fn read(&mut self, cell: &str, line: u64) -> Result<f64, String> {
        let number = decimal(cell).ok_or(NUMBER)?;
        let Some(mark) = cell.chars().find(|c| matches!(c, '.' | ',')) else {
            return Ok(number);
        };
        let first = self.0.get_or_insert_with(|| Mark {
            mark,
            line,
            cell: cell.to_owned(),
        });
        if first.mark == mark {
            return Ok(number);
        }
        let (before, cell) = (first.line, &first.cell);
        Err(format!(
            "one decimal mark in all of the file, and no thousands separators; line {before} has {cell:?}"
        ))
    }
}

/// What the numbers of one column show of thousands separators.
#[derive(Clone, Debug, Default)]
pub struct Grouping {
    /// Line and text of the first cell with three digits behind a mark.
    first: Option<(u64, String)>,
    last: String,
    grouped: u32,
    /// Whether a cell has a mark that separates no thousands.
    has_decimals: bool,
    /// Largest whole number without a mark; `None` without one.
    whole: Option<f64>,
}

impl Grouping {
    /// Takes a cell that is a number.
    pub fn take(&mut self, cell: &str, number: f64, line: u64) {
        if self.has_decimals {
            return;
        }
        if !cell.contains(['.', ',', 'e', 'E']) {
            self.whole = Some(self.whole.map_or(number.abs(), |w| w.max(number.abs())));
        } else if !is_thousands(cell) {
            self.has_decimals = true;
        } else if self.last != cell {
            self.grouped += 1;
            cell.clone_into(&mut self.last);
            self.first.get_or_insert_with(|| (line, cell.to_owned()));
        }
    }

    /// The first cell of a column with thousands separators: line and text. `fine`: its unit is so small that
    /// thousandths of it are not measured.
    pub fn thousands(&self, fine: bool) -> Option<(u64, &str)> {
        let least = match self.whole {
            whole if fine && whole.is_none_or(|whole| whole < 1000.0) => 1,
            Some(whole) if (100.0..1000.0).contains(&whole) => GROUPED,
            Some(whole) if whole < 1000.0 => GROUPED_ALONE,
            _ => return None,
        };
        let (line, cell) = self.first.as_ref()?;
        (!self.has_decimals && self.grouped >= least).then_some((*line, cell))
    }
}

/// What is allowed where [`Grouping::thousands`] finds a cell.
pub const NO_THOUSANDS: &str =
    "numbers without thousands separators: all marks of the column have three digits behind them";

/// Whether a number may have a separator of thousands: one to three digits, a mark, three digits, as `12,345`.
fn is_thousands(cell: &str) -> bool {
    let digits = cell.trim_start_matches(['-', '+', '\u{2212}']);
    let Some((before, after)) = digits.split_once(['.', ',']) else {
        return false;
    };
    let are_digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    (1..=3).contains(&before.len())
        && after.len() == 3
        && !before.starts_with('0')
        && are_digits(before)
        && are_digits(after)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A second mark is refused, with the line of the first.
    #[test]
    fn a_table_has_one_decimal_mark() {
        let mut decimals = Decimals::default();
        assert_eq!(decimals.read("999", 2), Ok(999.0));
        assert_eq!(decimals.read("0.5", 2), Ok(0.5));
        let error = decimals.read("12,345", 3);
        assert!(error.is_err_and(|e| e.contains("line 2 has \"0.5\"")));
        assert_eq!(decimals.read("-1.5e-3", 4), Ok(-1.5e-3));
    }

    /// No thousands separator is taken for a decimal mark.
    #[test]
    fn separators_are_no_numbers() {
        let allowed = |cell| Decimals::default().read(cell, 1).unwrap_err();
        for cell in [
            "1,234.5",
            "1.234,5",
            "1.234.567",
            "-12'345",
            "12 345",
            "12\u{a0}345",
            "1_234",
            "",
        ] {
            assert!(allowed(cell).contains("thousands"), "{cell}");
        }
    }

    /// Counts with separators show themselves; numbers with three decimals do not look so, nor do those of a column
    /// that has other decimals anywhere.
    #[test]
    fn a_column_shows_its_thousands() {
        let column = |cells: &mut dyn Iterator<Item = String>| {
            let mut grouping = Grouping::default();
            for (line, cell) in cells.enumerate() {
                let number = decimal(&cell).unwrap();
                grouping.take(&cell, number, line as u64);
            }
            grouping
        };
        let counts = |k: u32| match k {
            0..1000 => k.to_string(),
            _ => format!("{}.{:03}", k / 1000, k % 1000),
        };
        let grouped = column(&mut (0..300).map(|k| counts(7 * k)));
        assert_eq!(grouped.thousands(false), Some((143, "1.001")));
        let all_above = column(&mut (0..300).map(|k| counts(1000 + 7 * k)));
        assert_eq!(all_above.thousands(false), None);
        let with_zero = column(&mut (0..300).map(|k| counts(if k < 9 { 0 } else { 991 + k })));
        assert!(with_zero.thousands(false).is_some());
        let fixed = column(&mut (0..3000).map(|k| format!("{:.3}", 0.01 * f64::from(k))));
        assert_eq!(fixed.thousands(false), None);
        let trimmed = column(&mut (0..3000).map(|k| format!("{}", f64::from(k) / 1000.0)));
        assert_eq!(trimmed.thousands(false), None);
    }
}
