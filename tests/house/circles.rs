//! No circle between the files of a crate, nor between its folders: by the paths that their code
//! names, tests left out.
//!
//! A folder's `mod.rs` may declare and re-export its parts; a part that names its own `mod.rs` is
//! in a circle with it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Crates without circles. One is added when its last circle is gone.
const CRATES: [&str; 1] = ["index"];

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
            found.entry(inner).or_default().push_str(&lines.collect::<Vec<_>>().join(" "));
        }
    }
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

/// The modules that the code of one names.
fn named(module: &Module, code: &str, all: &BTreeMap<Module, String>) -> BTreeSet<Module> {
    let mut paths = Vec::new();
    for statement in code.split(';').filter_map(|part| part.rsplit_once("use ")) {
        expand("", statement.1, &mut paths);
    }
    let is_path = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
    let words = code.split(|letter: char| !is_path(letter)).filter(|word| !word.ends_with("::"));
    paths.extend(words.filter(|word| word.contains("::")).map(str::to_owned));
    let resolve = |path: &String| {
        let mut place = if path.starts_with("crate") { vec![] } else { module.clone() };
        for part in path.split("::").filter(|part| !["crate", "self"].contains(part)) {
            if part == "super" {
                drop(place.pop())
            } else {
                place.push(part.split(' ').next().unwrap().to_owned())
            }
        }
        (0..=place.len()).rev().map(|length| place[..length].to_vec()).find(|prefix| all.contains_key(prefix))
    };
    paths.iter().filter_map(resolve).filter(|other| other != module).collect()
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
        let files: Graph =
            all.iter().map(|(module, code)| (module.clone(), named(module, code, &all))).collect();
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
