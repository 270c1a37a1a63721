//! What the tests found.

use crate::check::Change;
use serde::Serialize;

/// Result of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The readings are what the estimator takes them for.
    Ok,
    /// The log does not show it.
    CannotTell,
    /// The readings are not what the estimator takes them for.
    Fault,
}

/// A figure of a finding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// What it is, such as "delay".
    pub name: &'static str,
    /// Its value in `unit`.
    pub value: f64,
    /// Unit; "-" of a ratio or a count.
    pub unit: &'static str,
}

/// What one test found of one channel or group of channels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The test, such as "sign and unit".
    pub test: &'static str,
    /// The channels.
    pub channel: String,
    /// Its verdict.
    pub verdict: Verdict,
    /// The figure behind the verdict, in words with its unit.
    pub figure: String,
    /// The numbers of the figure, for scripts.
    pub numbers: Vec<Quantity>,
    /// What to do; `None` where nothing is.
    pub remedy: Option<String>,
    /// What corrects a fault: further tests see the readings with it.
    #[serde(skip)]
    pub(crate) changes: Vec<Change>,
}

impl Finding {
    /// The readings are right, unless [`Self::cannot_tell`] or [`Self::fault`] follows.
    pub fn ok(test: &'static str, channel: impl ToString, figure: impl Into<String>) -> Self {
        Self {
            test,
            channel: channel.to_string(),
            verdict: Verdict::Ok,
            figure: figure.into(),
            numbers: Vec::new(),
            remedy: None,
            changes: Vec::new(),
        }
    }

    /// With a number of the figure and its unit.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: f64, unit: &'static str) -> Self {
        self.numbers.push(Quantity { name, value, unit });
        self
    }

    /// With the shares that the readings explain as they are, and otherwise wired.
    #[must_use]
    pub(crate) fn explained(self, own: f64, otherwise: f64) -> Self {
        let own = self.with("explained", own, "-");
        own.with("explained otherwise", otherwise, "-")
    }

    /// The log does not show it. `remedy` says which log would.
    #[must_use]
    pub fn cannot_tell(mut self, remedy: impl Into<String>) -> Self {
        (self.verdict, self.remedy) = (Verdict::CannotTell, Some(remedy.into()));
        self
    }

    /// The readings are wrong. `remedy` says what to do.
    #[must_use]
    pub fn fault(mut self, remedy: impl Into<String>) -> Self {
        (self.verdict, self.remedy) = (Verdict::Fault, Some(remedy.into()));
        self
    }

    /// If it is a fault, and something else may explain it as well, `or` in words: the log cannot tell, and nothing is
    /// changed for it.
    #[must_use]
    pub(crate) fn unless(mut self, may_be: bool, or: &str) -> Self {
        if !(may_be && self.is_fault()) {
            return self;
        }
        self.changes.clear();
        let remedy = self.remedy.take().unwrap_or_default();
        self.cannot_tell(format!("{remedy}; or {or}"))
    }

    /// Drops numbers that are not finite. A finding whose text has one becomes "cannot tell".
    fn finite(mut self) -> Self {
        self.numbers.retain(|number| number.value.is_finite());
        let of_words = |text: &String| {
            let mut words = text.split(|c: char| !c.is_alphanumeric());
            words.any(|word| ["NaN", "inf"].contains(&word))
        };
        if of_words(&self.figure) || self.remedy.as_ref().is_some_and(of_words) {
            "the log has no readings for it at the same times".clone_into(&mut self.figure);
            let remedy = self.remedy.take().filter(|remedy| !of_words(remedy));
            let remedy =
                remedy.unwrap_or_else(|| "record its readings together, on a drive".to_owned());
            return self.cannot_tell(remedy);
        }
        self
    }

    /// Whether it is a fault.
    pub fn is_fault(&self) -> bool {
        self.verdict == Verdict::Fault
    }

    /// The number of that name.
    pub(crate) fn number(&self, name: &str) -> Option<f64> {
        let found = self.numbers.iter().find(|number| number.name == name);
        found.map(|number| number.value)
    }

    /// With what corrects the readings.
    pub(crate) fn change(mut self, changes: impl IntoIterator<Item = Change>) -> Self {
        self.changes.extend(changes);
        self
    }
}

/// All findings of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The worst verdict, but for [`Verdict::CannotTell`]: a log without a fault is `Ok`.
    pub verdict: Verdict,
    /// In the order of the tests.
    pub findings: Vec<Finding>,
}

impl Report {
    /// The report of findings.
    pub fn new(findings: Vec<Finding>) -> Self {
        let findings = findings.into_iter().map(Finding::finite);
        let findings: Vec<Finding> = findings.collect();
        let fault = findings.iter().any(Finding::is_fault);
        Self {
            verdict: if fault { Verdict::Fault } else { Verdict::Ok },
            findings,
        }
    }

    /// The findings that are faults.
    pub fn faults(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|f| f.is_fault())
    }

    /// One line a finding, faults last; below it what to do. What is right is only counted, unless `all` are listed.
    pub fn text(&self, all: bool) -> String {
        let mut text = String::new();
        let is_listed = |finding: &&Finding| all || finding.verdict != Verdict::Ok;
        // Stable: within a verdict the order of the tests.
        let mut findings: Vec<&Finding> = self.findings.iter().filter(is_listed).collect();
        findings.sort_by_key(|finding| finding.verdict);
        let width = |of: fn(&Finding) -> usize| findings.iter().map(|f| of(f)).max().unwrap_or(0);
        let (tests, channels) = (width(|f| f.test.len()), width(|f| f.channel.len()));
        for finding in findings {
            let (test, channel, figure) = (finding.test, &finding.channel, &finding.figure);
            let verdict = match finding.verdict {
                Verdict::Ok => "ok",
                Verdict::CannotTell => "cannot tell",
                Verdict::Fault => "FAULT",
            };
            text += &format!("{verdict:<11}  {test:<tests$}  {channel:<channels$}  {figure}\n");
            for line in finding.remedy.iter().flat_map(|remedy| remedy.lines()) {
                text += &format!("{:<11}  -> {line}\n", "");
            }
        }
        let of = |verdict| self.findings.iter().filter(move |f| f.verdict == verdict);
        let [ok, unknown, faults] =
            [Verdict::Ok, Verdict::CannotTell, Verdict::Fault].map(|verdict| of(verdict).count());
        let (tests, is_hidden) = (self.findings.len(), !all && ok > 0);
        let listed = if is_hidden { " (-v lists them)" } else { "" };
        text + &format!(
            "{tests} tests: {ok} ok{listed}, {unknown} that this log cannot tell, {faults} with a fault"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A figure that is no number is none: the log cannot tell, and numbers that are none are left out.
    #[test]
    fn no_finding_has_a_figure_that_is_no_number() {
        let of = |value: f64| Finding::ok("zero", "pin", format!("mean {value:.2} deg"));
        let findings =
            [f64::NAN, f64::INFINITY, -f64::INFINITY].map(|x| of(x).with("mean", x, "deg"));
        let fault = of(1.0).fault(format!("add {:.2} to its offset", f64::NAN));
        let right = of(1.0).with("mean", 1.0, "deg");
        let report = Report::new([&findings[..], &[fault, right.clone()]].concat());
        let text = report.text(true);
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        let (last, others) = report.findings.split_last().unwrap();
        assert_eq!(*last, right);
        for finding in others {
            assert_eq!(finding.verdict, Verdict::CannotTell, "{finding:?}");
            assert!(finding.numbers.is_empty(), "{finding:?}");
        }
    }

    /// One fault makes a report faulty; a test that cannot tell does not. Remedies stand below
    /// their lines.
    #[test]
    fn a_fault_decides() {
        let mut findings = vec![
            Finding::ok("stuck", "gyro 1", "0 s"),
            Finding::ok("delay", "gyro 1", "no motion").cannot_tell("drive"),
        ];
        assert_eq!(Report::new(findings.clone()).verdict, Verdict::Ok);
        findings.push(Finding::ok("sign", "torque 1", "-1").fault("turn it"));
        let report = Report::new(findings);
        assert_eq!(
            (report.verdict, report.faults().count()),
            (Verdict::Fault, 1)
        );
        let text = report.text(true);
        assert!(
            text.contains("FAULT        sign   torque 1  -1\n             -> turn it\n"),
            "{text}"
        );
        let counts = "3 tests: 1 ok, 1 that this log cannot tell, 1 with a fault";
        assert!(text.starts_with("ok ") && text.ends_with(counts), "{text}");
        let short = report.text(false);
        assert!(short.starts_with("cannot tell"), "{short}");
        assert!(short.contains("1 ok (-v lists them), 1 that"), "{short}");
    }
}
