//! No circle between the files of a crate, nor between its folders: by the paths that their code
//! names, tests left out.
//!
//! A folder's `mod.rs` may declare and re-export its parts. Whoever names what it re-exports names
//! the part; a part that names what its own `mod.rs` defines is in a circle with it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// All crates.
const CRATES: [&str; 21] = [
    "builder",
    "builder/train",
    "index",
    "index/about",
    "index/bounded",
    "index/canonical",
    "index/labels",
    "index/log",
    "index/network",
    "index/picture",
    "index/plot",
    "index/program",
    "index/terminal",
    "query",
    "query/answer",
    "query/python",
    "query/recognise",
    "query/robot",
    "query/ros",
    "query/serve",
    "renders",
];

type Module = Vec<String>;
type Graph = BTreeMap<Module, BTreeSet<Module>>;

/// Each module with its code, without tests and comments.
fn modules(folder: &Path, module: &Module, found: &mut BTreeMap<Module, String>) {
    for path in std::fs::read_dir(folder).expect("the folder is there").map(|entry| entry.unwrap().path()) {
        let stem = path.file_stem().unwrap().to_str().expect("a name").to_owned();
        let own = if ["mod", "lib", "main"].contains(&&*stem) { vec![] } else { vec![stem.clone()] };
        let inner = [module.clone(), own].concat();
        if path.is_dir() {
            modules(&path, &inner, found);
        } else if stem != "tests" && path.extension().is_some_and(|end| end == "rs") {
            let text = std::fs::read_to_string(&path).expect("it can be read");
            let code = text.split("mod tests {").next().unwrap_or_default();
            let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default().trim());
            let code = without_visibility(&lines.collect::<Vec<_>>().join(" "));
            found.entry(inner).or_default().push_str(&(code + ";"));
        }
    }
}

/// Code without the paths of `pub(in ...)`, which name nothing that is used.
fn without_visibility(code: &str) -> String {
    let mut parts = code.split("pub(in ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |code, part| code + "pub" + part.split_once(')').map_or(part, |(_, rest)| rest))
}

/// The paths of a `use` tree.
fn expand(prefix: &str, tree: &str, paths: &mut Vec<String>) {
    let Some((head, group)) = tree.split_once('{') else {
        return paths.push(format!("{prefix}{}", tree.trim()));
    };
    let (mut depth, mut start) = (0, 0);
    let group = &group[..group.rfind('}').unwrap_or(group.len())];
    for (at, letter) in group.char_indices().chain([(group.len(), ',')]) {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        if letter == ',' && depth == 0 {
            expand(&format!("{prefix}{}", head.trim()), group[start..at].trim(), paths);
            start = at + 1;
        }
    }
}

/// The paths that the `use` statements of some code name.
fn used(code: &str) -> Vec<String> {
    let mut paths = Vec::new();
    for (_, tree) in code.split(';').filter_map(|part| part.rsplit_once("use ")) {
        expand("", tree, &mut paths);
    }
    paths
}

/// A path from the crate's root; `None` where it leads into another crate.
fn absolute(module: &Module, path: &str, all: &BTreeMap<Module, String>) -> Option<Module> {
    let path = path.split(" as ").next().unwrap_or_default().trim();
    let first = path.split("::").next().unwrap_or_default().to_owned();
    let is_own = all.contains_key(&[module.clone(), vec![first.clone()]].concat());
    if !is_own && !["crate", "super", "self"].contains(&&*first) {
        return None;
    }
    let mut place = if first == "crate" { vec![] } else { module.clone() };
    for part in path.split("::").filter(|part| !["crate", "self"].contains(part)) {
        if part == "super" {
            drop(place.pop());
        } else {
            place.push(part.to_owned());
        }
    }
    Some(place)
}

/// What each module has imported or re-exports, by the name that it has there.
type Imports = BTreeMap<Module, BTreeMap<String, Module>>;

fn imports(all: &BTreeMap<Module, String>) -> Imports {
    let of = |module: &Module, code: &String| {
        let named = used(code).into_iter().filter_map(|path| {
            let name = path.rsplit("::").next()?.rsplit(" as ").next()?.trim().to_owned();
            Some((name, absolute(module, &path, all)?))
        });
        (module.clone(), named.collect())
    };
    all.iter().map(|(module, code)| of(module, code)).collect()
}

/// The module that defines what a path names: imports are followed, a few times at most.
fn defining(path: &Module, all: &BTreeMap<Module, String>, imports: &Imports, times: u32) -> Module {
    let lengths = (0..=path.len()).rev();
    let module = lengths.map(|length| path[..length].to_vec()).find(|prefix| all.contains_key(prefix));
    let module = module.unwrap_or_default();
    let target = path.get(module.len()).and_then(|name| imports.get(&module)?.get(name));
    match target {
        Some(target) if target != path && times > 0 => {
            let rest = &path[module.len() + 1..];
            defining(&[target, rest].concat(), all, imports, times - 1)
        }
        _ => module,
    }
}

/// The modules that the code of one names.
fn named(module: &Module, code: &str, all: &BTreeMap<Module, String>, imports: &Imports) -> BTreeSet<Module> {
    let mut paths = used(code);
    let is_path = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
    let words = code.split(|letter: char| !is_path(letter)).filter(|word| !word.ends_with("::"));
    paths.extend(words.filter(|word| word.contains("::")).map(str::to_owned));
    let absolute = paths.iter().filter_map(|path| absolute(module, path, all));
    absolute.map(|path| defining(&path, all, imports, 8)).filter(|other| other != module).collect()
}

/// What is left when all that names nothing that is left is taken away, again and again, and all
/// that nothing names.
fn circles(mut graph: Graph) -> Graph {
    loop {
        let count = graph.len();
        let named: BTreeSet<Module> = graph.values().flatten().cloned().collect();
        graph.retain(|module, others| !others.is_empty() && named.contains(module));
        let left: BTreeSet<Module> = graph.keys().cloned().collect();
        graph.values_mut().for_each(|others| others.retain(|other| left.contains(other)));
        if graph.len() == count {
            return graph;
        }
    }
}

#[test]
fn no_circle_between_files_or_folders() {
    for name in CRATES {
        let mut all = BTreeMap::new();
        modules(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src"), &vec![], &mut all);
        let imports = imports(&all);
        let files: Graph =
            all.iter().map(|(module, code)| (module.clone(), named(module, code, &all, &imports))).collect();
        assert_eq!(circles(files.clone()), Graph::new(), "files of {name}");
        for depth in 1..5 {
            let cut = |module: &Module| module[..depth].to_vec();
            let is_deep = |module: &&Module| module.len() >= depth;
            let mut folders = Graph::new();
            for (module, others) in files.iter().filter(|(module, _)| is_deep(module)) {
                let others = others.iter().filter(is_deep).map(cut).filter(|other| *other != cut(module));
                folders.entry(cut(module)).or_default().extend(others);
            }
            assert_eq!(circles(folders), Graph::new(), "folders of {name}");
        }
    }
}

#[test]
fn a_circle_is_found_through_what_a_folder_re_exports() {
    let code = [("a", "pub use b::X; mod b; mod c;"), ("a::b", "use super::Y;"), ("a::c", "use super::X;")];
    let module = |path: &str| path.split("::").map(str::to_owned).collect::<Module>();
    let graph = |y: &str| {
        let mut all: BTreeMap<Module, String> =
            code.iter().map(|(path, code)| (module(path), (*code).to_owned())).collect();
        all.get_mut(&module("a")).unwrap().push_str(y);
        let imports = imports(&all);
        all.iter().map(|(at, code)| (at.clone(), named(at, code, &all, &imports))).collect::<Graph>()
    };
    // Y of the folder itself, then of its part c.
    assert!(circles(graph("struct Y;")).contains_key(&module("a")));
    let between = circles(graph("pub use c::Y;"));
    assert_eq!(between.keys().cloned().collect::<Vec<_>>(), [module("a::b"), module("a::c")]);
}
