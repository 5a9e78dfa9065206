//! Imports within the crates of `shared`: neither files nor folders import each other in circles.
//!
//! The order of the crates is Cargo's to check.
//!
//! A reader of lines finds the imports: `use` declarations, and paths that begin with
//! `crate`, `super` or a child module. Comments, strings, and what only tests compile do
//! not count. A name that its module only re-exports counts as an import of the file that
//! defines it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The crates that are read.
const CRATES: [&str; 4] = ["servo", "control", "link", "board"];

/// The paths in a module's code, each with whether it is re-exported, by the module's own
/// path. That of the crate is empty.
type Sources = BTreeMap<String, Vec<(String, bool)>>;

/// Reads the files of this folder, the module of which has this path.
fn read(folder: &Path, parent: &str, sources: &mut Sources) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().expect("a name").to_string_lossy();
        let module = match &*stem {
            "tests" => continue,
            "mod" | "lib" => parent.to_owned(),
            name => join(parent, name),
        };
        if path.is_dir() {
            read(&path, &module, sources);
        } else {
            let text = fs::read_to_string(&path).expect("text");
            sources.insert(module, paths(&code(&text)));
        }
    }
}

fn parent(module: &str) -> &str {
    module.rsplit_once("::").map_or("", |(parent, _)| parent)
}

fn join(parent: &str, name: &str) -> String {
    [parent, name].join("::").trim_matches(':').to_owned()
}

/// The code without comments, strings and items for tests, as one line.
fn code(text: &str) -> String {
    let (mut code, mut lines) = (" ".to_owned(), text.lines());
    while let Some(line) = lines.next() {
        if line.trim() == "#[cfg(test)]" {
            let item = lines.find(|line| !line.contains("#[")).expect("an item");
            let end = item.replace(item.trim_start(), "}");
            if !item.ends_with([';', '}']) {
                lines.find(|line| line.starts_with(&end));
            }
            continue;
        }
        let line = line.split("//").next().unwrap_or_default();
        for part in line.split('"').step_by(2) {
            code.push_str(part);
            code.push(' ');
        }
    }
    code.replace("pub(in crate::", "pub(in ")
}

/// The paths in some code.
fn paths(code: &str) -> Vec<(String, bool)> {
    let mut paths = Vec::new();
    for statement in code.split(';') {
        let (before, tree) = statement.rsplit_once(" use ").unwrap_or((statement, ""));
        let words = before.split(|c: char| !c.is_alphanumeric() && !"_:".contains(c));
        let inline = words.filter(|word| word.contains("::"));
        paths.extend(inline.map(|path| (path.to_owned(), false)));
        let is_exported = before.trim_end().ends_with("pub") || before.trim_end().ends_with(')');
        paths.extend(expand(tree).into_iter().map(|path| (path, is_exported)));
    }
    paths
}

/// The paths of a tree of imports.
fn expand(tree: &str) -> Vec<String> {
    let Some((prefix, rest)) = tree.split_once('{') else {
        let name = tree.split(" as ").next().unwrap_or_default();
        return vec![name.trim().to_owned()];
    };
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in rest.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        match c {
            _ if depth < 0 => break,
            ',' if depth == 0 => parts.push(String::new()),
            c => parts.last_mut().expect("a part").push(c),
        }
    }
    let paths = parts.iter().flat_map(|part| expand(part));
    paths
        .map(|path| format!("{}{path}", prefix.trim()))
        .collect()
}

/// The path from the crate on; `None` if it leads elsewhere.
fn absolute(module: &str, path: &str, sources: &Sources) -> Option<String> {
    let (first, rest) = path.split_once("::").unwrap_or((path, ""));
    let parent = parent(module);
    match first {
        "crate" => Some(rest.to_owned()),
        "self" => Some(join(module, rest)),
        "super" if rest.starts_with("super") => absolute(parent, rest, sources),
        "super" => Some(join(parent, rest)),
        child => sources
            .contains_key(&join(module, child))
            .then(|| join(module, path)),
    }
}

/// The module that defines what is at this path.
fn definition(path: &str, sources: &Sources) -> String {
    let mut module = path;
    while !sources.contains_key(module) {
        module = parent(module);
    }
    let name = folder(path[module.len()..].trim_start_matches(':'));
    let mut exports = sources[module]
        .iter()
        .filter(|(_, is_exported)| *is_exported);
    exports
        .find(|(path, _)| !name.is_empty() && path.rsplit("::").next() == Some(name))
        .and_then(|(path, _)| absolute(module, path, sources))
        .map_or_else(|| module.to_owned(), |path| definition(&path, sources))
}

/// Imports between the files of a crate: importing module, imported module.
fn imports(name: &str) -> BTreeSet<(String, String)> {
    let mut sources = Sources::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    read(&root.join(name).join("src"), "", &mut sources);
    let mut imports = BTreeSet::new();
    for (module, paths) in &sources {
        let paths = paths
            .iter()
            .filter_map(|(path, _)| absolute(module, path, &sources));
        imports.extend(paths.map(|path| (module.clone(), definition(&path, &sources))));
    }
    imports.retain(|(from, to)| from != to && !from.is_empty() && !to.is_empty());
    imports
}

/// The first name of a path.
fn folder(path: &str) -> &str {
    path.split("::").next().unwrap_or_default()
}

/// The imports of these that are in a circle.
fn circles(mut imports: BTreeSet<(String, String)>) -> BTreeSet<(String, String)> {
    let mut before = 0;
    while before != imports.len() {
        before = imports.len();
        let begins: BTreeSet<_> = imports.iter().map(|(from, _)| from.clone()).collect();
        let ends: BTreeSet<_> = imports.iter().map(|(_, to)| to.clone()).collect();
        // Nothing leads to its beginning, or on from its end.
        imports.retain(|(from, to)| ends.contains(from) && begins.contains(to));
    }
    imports
}

#[test]
fn no_file_and_no_folder_imports_itself_by_way_of_others() {
    let mut found = 0;
    for name in CRATES {
        let files = imports(name);
        found += files.len();
        let folders = files
            .iter()
            .map(|(from, to)| (folder(from).to_owned(), folder(to).to_owned()));
        let folders: BTreeSet<_> = folders.filter(|(from, to)| from != to).collect();
        let (files, folders) = (circles(files), circles(folders));
        assert!(files.is_empty(), "{name}, files in circles: {files:#?}");
        assert!(
            folders.is_empty(),
            "{name}, folders in circles: {folders:#?}"
        );
    }
    assert!(found > 400, "only {found} imports are found");
}
