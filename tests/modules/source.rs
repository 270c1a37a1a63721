//! What the text of a Rust file imports, without comments and tests.

/// The source without comments, string literals and character literals.
pub fn without_comments(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |n| n + 2)
        } else if c == '"' {
            text_length(rest)
        } else if let Some(hashes) = raw_text(rest) {
            let end = format!("\"{}", "#".repeat(hashes));
            let open = hashes + 2;
            rest[open..]
                .find(&end)
                .map_or(rest.len(), |n| open + n + end.len())
        } else if c == '\'' {
            character_length(rest)
        } else {
            0
        };
        if skipped == 0 {
            out.push(c);
            rest = &rest[c.len_utf8()..];
        } else {
            out.push(' ');
            rest = &rest[skipped..];
        }
    }
    out
}

/// Number of `#` at the start of a raw string literal `r#"..."#`.
fn raw_text(text: &str) -> Option<usize> {
    let hashes = text.strip_prefix('r')?;
    let count = hashes.len() - hashes.trim_start_matches('#').len();
    hashes[count..].starts_with('"').then_some(count)
}

/// Length of a string literal.
fn text_length(text: &str) -> usize {
    let mut escaped = true; // the opening quote
    for (n, c) in text.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return n + 1,
            _ => {}
        }
    }
    text.len()
}

/// Length of a character literal; 0 for a lifetime.
fn character_length(text: &str) -> usize {
    let inner = &text[1..];
    let close = match inner.strip_prefix('\\') {
        Some(escape) => escape
            .char_indices()
            .skip(1)
            .find(|(_, c)| *c == '\'')
            .map(|(n, _)| n + 1),
        None => inner
            .chars()
            .next()
            .map(char::len_utf8)
            .filter(|n| inner[*n..].starts_with('\'')),
    };
    close.map_or(0, |n| n + 2)
}

/// The source without test items, and the names of test modules in files of their own.
pub fn without_tests(text: &str) -> (String, Vec<String>) {
    const MARK: &str = "#[cfg(test)]";
    let (mut out, mut files) = (String::new(), Vec::new());
    let mut rest = text;
    while let Some(start) = rest.find(MARK) {
        out.push_str(&rest[..start]);
        let item = &rest[start + MARK.len()..];
        let end = item_end(item);
        let words: Vec<_> = item[..end].split_whitespace().collect();
        if let ["mod", name] | ["pub", "mod", name] | ["pub(crate)", "mod", name] = words[..] {
            files.extend(name.strip_suffix(';').map(str::to_owned));
        }
        rest = &item[end..];
    }
    out.push_str(rest);
    (out, files)
}

/// Length of an item: up to its semicolon or closing brace. A `use` of several names ends with its
/// semicolon.
fn item_end(text: &str) -> usize {
    let is_use = text.trim_start().starts_with("use ")
        || text.contains(" use ") && {
            let first = text.find('{').unwrap_or(text.len());
            text[..first].contains(" use ")
        };
    let mut depth = 0;
    for (n, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => {
                depth -= 1;
                if depth == 0 && !is_use {
                    return n + 1;
                }
            }
            ';' if depth == 0 => return n + 1,
            _ => {}
        }
    }
    text.len()
}

/// An imported name: its path, its local name, and whether it is visible elsewhere.
type Use = (Vec<String>, String, bool);

/// The `use` declarations, one for each name, and the source without them.
pub fn use_declarations(text: &str) -> (Vec<Use>, String) {
    let (mut uses, mut plain, mut left) = (Vec::new(), String::new(), text);
    while let Some(start) = next_use(left) {
        let before = &left[..start];
        let end = left[start..].find(';').map_or(left.len(), |n| start + n);
        let head = before.trim_end();
        let public = head.ends_with("pub")
            || head.ends_with(')') && {
                let open = head.rfind('(').unwrap_or(0);
                head[..open].trim_end().ends_with("pub")
            };
        expand(&left[start + "use".len()..end], &[], public, &mut uses);
        plain.push_str(before);
        left = &left[end..];
    }
    plain.push_str(left);
    (uses, plain)
}

/// Position of the next word `use`.
fn next_use(text: &str) -> Option<usize> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut places = text.match_indices("use").map(|(n, _)| n);
    places.find(|n| {
        let before = text[..*n].chars().next_back();
        let after = text[n + 3..].chars().next();
        !before.is_some_and(is_name) && after.is_some_and(char::is_whitespace)
    })
}

/// Expands a tree such as `a::{b, c::{d as e}}`.
fn expand(tree: &str, prefix: &[String], public: bool, uses: &mut Vec<Use>) {
    let tree = tree.trim();
    if let Some(open) = tree.find('{') {
        let mut path = prefix.to_vec();
        path.extend(names(&tree[..open]));
        let inner = tree[open + 1..].strip_suffix('}').unwrap_or_default();
        for part in split_top(inner) {
            expand(part, &path, public, uses);
        }
        return;
    }
    let (path, alias) = tree.split_once(" as ").unwrap_or((tree, ""));
    let mut full = prefix.to_vec();
    full.extend(names(path));
    if full.last().is_some_and(|name| name == "self") && full.len() > 1 {
        full.pop();
    }
    let own = full.last().cloned().unwrap_or_default();
    let alias = if alias.is_empty() {
        own
    } else {
        alias.trim().to_owned()
    };
    if !full.is_empty() {
        uses.push((full, alias, public));
    }
}

/// The names of a path `a::b::`.
pub fn names(path: &str) -> Vec<String> {
    let parts = path.split("::").map(str::trim);
    parts.filter(|p| !p.is_empty()).map(str::to_owned).collect()
}

/// Parts between the commas outside braces.
fn split_top(text: &str) -> Vec<&str> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0, 0);
    for (n, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[start..n]);
                start = n + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts.retain(|part| !part.trim().is_empty());
    parts
}

/// Paths in expressions and types that start with `crate` or `super`.
pub fn inline_paths(text: &str) -> Vec<Vec<String>> {
    let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = text.split(|c| !is_path(c));
    words
        .filter(|word| word.starts_with("crate::") || word.starts_with("super::"))
        .map(names)
        .collect()
}
