//! Modules do not import each other in a loop.
//!
//! No module of a loop can be understood, tested or moved without all the others. The check reads
//! the `use crate::` and `super::` paths of every crate, in declarations and in expressions. Its
//! graph has one node for each child of a module, with all that lies below it, and one for the
//! module's own file. A file that only re-exports its children (`pub use`) does not depend on them,
//! and an import through such a re-export counts for the child. Test modules do not count.

mod source;

use crate::support::root;
use source::{inline_paths, names, use_declarations, without_comments, without_tests};
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
