//! Modules do not import each other in a loop.
//!
//! No module of a loop can be understood, tested or moved without all the others. The check reads
//! the `use crate::` and `super::` paths of every crate, in declarations and in expressions. Its
//! graph has one node for each child of a module, with all that lies below it, and one for the
//! module's own file. A file that only re-exports its children (`pub use`) does not depend on them,
//! and an import through such a re-export counts for the child. Test modules do not count.

use crate::support::root;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A module by its path from the crate's root, which is empty.
type Module = Vec<String>;

/// No crate has modules that import each other in a loop.
#[test]
fn modules_do_not_import_each_other_in_a_loop() {
    let mut failures = Vec::new();
    let mut count = 0;
    for entry in std::fs::read_dir(root().join("crates")).unwrap() {
        let folder = entry.unwrap().path();
        let name = folder.file_name().unwrap().to_str().unwrap().to_owned();
        let sources = sources(&folder.join("src"));
        count += sources.len();
        let loops = loops(&sources).into_iter();
        failures.extend(loops.map(|found| format!("{name}: {found}")));
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    // The estimator alone has more than 30.
    assert!(count > 100, "only {count} modules found");
}

/// Sensitivity: the check finds loops between files, between folders, through re-exports, in
/// expressions, and between a module and its parent. It ignores re-exports of children, tests,
/// comments and string literals.
#[test]
fn the_check_finds_loops() {
    let check = |files: &[(&str, &str)]| {
        let files = files.iter();
        loops(
            &files
                .map(|(path, text)| (names(path), (*text).to_owned()))
                .collect(),
        )
    };
    let direct = [
        ("", "mod a; mod b;"),
        ("a", "use crate::b::B;"),
        ("b", "fn f() { super::a::g(); }"),
    ];
    assert_eq!(check(&direct), ["a, b"]);
    let of_three = [
        ("", "mod a; mod b; mod c; mod d;"),
        ("a", "use crate::{b::{B, X as Y}, d::D};"),
        ("b", "use super::c::C;"),
        ("c", "use crate::a;"),
        ("d", ""),
    ];
    assert_eq!(check(&of_three), ["a, b, c"]);
    // `x` imports from `y` and `y::inner` from `x`: a loop of folders, though no two files import
    // each other.
    let folders = [
        ("", "mod x; mod y;"),
        ("x", "mod one; mod two; pub use two::Two;"),
        ("x::one", "use crate::y::Inner;"),
        ("x::two", ""),
        ("y", "mod inner; pub(crate) use inner::{Inner, other};"),
        ("y::inner", "use crate::x::Two;"),
    ];
    assert_eq!(check(&folders), ["x, y"]);
    let through_the_parent = [
        ("", "mod a; mod b; pub use a::A; pub use b::B;"),
        ("a", "use crate::B;"),
        ("b", "use crate::A;"),
    ];
    assert_eq!(check(&through_the_parent), ["a, b"]);
    let with_the_parent = [
        ("", "mod a; use a::A; pub struct Own(A);"),
        ("a", "use super::Own;"),
    ];
    assert_eq!(check(&with_the_parent), ["(own file), a"]);

    let none = [
        (
            "",
            "mod a; mod b; #[cfg(test)] mod tests; pub use a::{A, C}; pub use b::B;",
        ),
        (
            "a",
            "// use crate::b::B;\nconst A: &str = \"use crate::b::B;\"; /* crate::b */",
        ),
        (
            "b",
            "use crate::A; #[cfg(test)] mod tests { use crate::tests::x; fn f() {} }",
        ),
        ("tests", "use crate::b::B; use crate::a::A;"),
    ];
    assert_eq!(check(&none), [""; 0]);
}

/// The text of every module below a folder `src`, programs included.
fn sources(src: &Path) -> BTreeMap<Module, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![(src.to_owned(), Module::new())];
    while let Some((folder, path)) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let file = entry.unwrap().path();
            let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
            let mut module = path.clone();
            if !["lib", "main", "mod"].contains(&name.as_str()) {
                module.push(name);
            }
            if file.is_dir() {
                folders.push((file, module));
            } else if file.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&file).unwrap();
                found
                    .entry(module)
                    .or_insert_with(String::new)
                    .push_str(&text);
            }
        }
    }
    found
}

/// Groups of modules that import each other in a loop, one line of text per group.
fn loops(sources: &BTreeMap<Module, String>) -> Vec<String> {
    let mut texts = BTreeMap::new();
    let mut tests = BTreeSet::new();
    for (module, text) in sources {
        let (text, test_files) = without_tests(&without_comments(text));
        texts.insert(module.clone(), text);
        tests.extend(test_files.into_iter().map(|name| below(module, &name)));
    }
    texts.retain(|module, _| !tests.iter().any(|test| module.starts_with(test)));
    let crate_ = Crate::new(&texts);

    // For each parent, who imports whom among its children; `None` is its own file.
    let mut graphs: BTreeMap<Module, BTreeSet<Edge>> = BTreeMap::new();
    for (from, imports) in &crate_.imports {
        for to in imports {
            let common = from.iter().zip(to).take_while(|(a, b)| a == b).count();
            let graph = graphs.entry(from[..common].to_vec()).or_default();
            let (a, b) = (from.get(common).cloned(), to.get(common).cloned());
            if a != b {
                graph.insert((a, b));
            }
        }
    }
    let mut found = Vec::new();
    for (parent, edges) in &graphs {
        let nodes: BTreeSet<_> = edges.iter().flat_map(|(a, b)| [a, b]).collect();
        let reached: BTreeMap<_, _> = nodes.iter().map(|n| (*n, reachable(n, edges))).collect();
        let mut done = BTreeSet::new();
        for node in nodes {
            let group: BTreeSet<_> = (reached[node].iter().copied())
                .filter(|other| reached[*other].contains(node))
                .collect();
            if group.len() > 1 && !done.contains(node) {
                let name = |n: &Option<String>| n.clone().unwrap_or("(own file)".to_owned());
                let names: Vec<_> = group.iter().map(|n| name(n)).collect();
                let prefix = parent.iter().map(|p| format!("{p}::")).collect::<String>();
                found.push(format!("{prefix}{}", names.join(", ")));
            }
            done.extend(group);
        }
    }
    found
}

/// A child of a module by its name; `None` for the module's own file.
type Node = Option<String>;
/// From the importing child to the imported one.
type Edge = (Node, Node);

/// All nodes that a node leads to.
fn reachable<'e>(node: &Node, edges: &'e BTreeSet<Edge>) -> BTreeSet<&'e Node> {
    let mut found = BTreeSet::new();
    let mut open = vec![node];
    while let Some(node) = open.pop() {
        for (_, to) in edges.iter().filter(|(from, _)| from == node) {
            if found.insert(to) {
                open.push(to);
            }
        }
    }
    found
}

/// The imports of a crate's modules.
struct Crate {
    modules: BTreeSet<Module>,
    /// Names that a module re-exports, with their full paths.
    exports: BTreeMap<Module, Vec<(String, Module)>>,
    /// Modules that a module imports from.
    imports: BTreeMap<Module, BTreeSet<Module>>,
}

impl Crate {
    fn new(texts: &BTreeMap<Module, String>) -> Self {
        let mut found = Self {
            modules: texts.keys().cloned().collect(),
            exports: BTreeMap::new(),
            imports: BTreeMap::new(),
        };
        let mut paths = Vec::new();
        for (module, text) in texts {
            let (uses, rest) = use_declarations(text);
            for (path, alias, public) in uses {
                let Some(path) = found.absolute(module, &path) else {
                    continue;
                };
                let re_export = public && path.len() > module.len() && path.starts_with(module);
                if public {
                    let exports = found.exports.entry(module.clone()).or_default();
                    exports.push((alias, path.clone()));
                }
                if !re_export {
                    paths.push((module.clone(), path));
                }
            }
            for path in inline_paths(&rest) {
                if let Some(path) = found.absolute(module, &path) {
                    paths.push((module.clone(), path));
                }
            }
        }
        for (module, path) in paths {
            let target = found.home(path);
            if target != module {
                found.imports.entry(module).or_default().insert(target);
            }
        }
        found
    }

    /// A path from the root of the crate; `None` for other crates.
    fn absolute(&self, module: &Module, path: &[String]) -> Option<Module> {
        let mut base = module.clone();
        let mut path = path.iter().peekable();
        match path.peek()?.as_str() {
            "crate" => {
                base.clear();
                path.next();
            }
            "self" => drop(path.next()),
            "super" => {
                while path.next_if(|p| *p == "super").is_some() {
                    base.pop();
                }
            }
            child if self.modules.contains(&below(module, child)) => {}
            _ => return None,
        }
        base.extend(path.cloned());
        Some(base)
    }

    /// The module that holds the item of a path, through re-exports.
    fn home(&self, mut path: Module) -> Module {
        // No chain of re-exports is longer.
        for _ in 0..10 {
            let deepest = (0..=path.len()).rev().map(|n| &path[..n]);
            let module = deepest.into_iter().find(|p| self.modules.contains(*p));
            let module = module.unwrap_or_default().to_vec();
            let Some(item) = path.get(module.len()) else {
                return module;
            };
            let exports = self.exports.get(&module).into_iter().flatten();
            match exports
                .into_iter()
                .find(|(name, to)| name == item && *to != path)
            {
                Some((_, to)) => path = to.clone(),
                None => return module,
            }
        }
        path
    }
}

fn below(module: &[String], child: &str) -> Module {
    let mut path = module.to_vec();
    path.push(child.to_owned());
    path
}

/// The source without comments, string literals and character literals.
fn without_comments(text: &str) -> String {
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
fn without_tests(text: &str) -> (String, Vec<String>) {
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
fn use_declarations(text: &str) -> (Vec<Use>, String) {
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
fn names(path: &str) -> Vec<String> {
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
fn inline_paths(text: &str) -> Vec<Vec<String>> {
    let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = text.split(|c| !is_path(c));
    words
        .filter(|word| word.starts_with("crate::") || word.starts_with("super::"))
        .map(names)
        .collect()
}
