//! "Did you mean": the nearest of the allowed names.

/// Longest name that is compared, characters: the time of a comparison grows with the length.
const LONGEST: usize = 64;

/// The allowed name that a misspelt one most likely means: few letters differ, or the start is the
/// same.
pub(crate) fn nearest<'a>(found: &str, allowed: &[&'a str]) -> Option<&'a str> {
    /// Least Jaro-Winkler similarity, 0 to 1; it gives the start more weight.
    const ALIKE: f64 = 0.85;
    if found.len() > LONGEST {
        return None;
    }
    let found = found.to_lowercase();
    // Three letters in ten may be wrong, but never all of them.
    let tolerance = (found.chars().count() * 3 / 10).max(1);
    let typing_error = allowed
        .iter()
        .map(|name| {
            let lower = name.to_lowercase();
            (strsim::damerau_levenshtein(&found, &lower), *name)
        })
        .filter(|(distance, name)| *distance <= tolerance && *distance < name.chars().count())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name);
    let alike = || {
        let likeness = |name: &&str| strsim::jaro_winkler(&found, &name.to_lowercase());
        let best = allowed
            .iter()
            .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))?;
        (likeness(best) > ALIKE).then_some(*best)
    };
    typing_error.or_else(alike)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_find_their_word() {
        let words = ["speed", "torque_limit", "kp", "ki"];
        assert_eq!(nearest("torqe_limit", &words), Some("torque_limit"));
        assert_eq!(nearest("Speed", &words), Some("speed"));
        assert_eq!(nearest("kx", &words), Some("kp"));
        assert_eq!(nearest("torqe", &words), Some("torque_limit"));
        assert_eq!(nearest("gravity", &words), None);
        assert_eq!(nearest("", &words), None);
        assert_eq!(nearest("b", &["A", "B"]), Some("B"));
        assert_eq!(nearest("C", &["A", "B"]), None);
    }
}
