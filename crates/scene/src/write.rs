//! A TOML file being written: every choice with its unit, from the declarations of the keys.

/// The text of the file.
#[derive(Default)]
pub(crate) struct Out(pub String);

impl Out {
    /// A line.
    pub fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    /// The heading of a table.
    pub fn head(&mut self, head: &str, comment: &str) {
        self.line("");
        self.line(&with_comment(head, comment));
    }

    /// A key with its value.
    pub fn key(&mut self, name: &str, value: &str, comment: &str) {
        self.line(&with_comment(&format!("{name} = {value}"), comment));
    }
}

fn with_comment(text: &str, comment: &str) -> String {
    match comment {
        "" => text.to_owned(),
        _ => format!("{text} # {comment}"),
    }
}

/// A text in quotes, as TOML writes it.
pub(crate) fn quote(value: &str) -> String {
    toml::Value::String(value.to_owned()).to_string()
}

/// A count with a space between groups of three digits.
pub(crate) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}
