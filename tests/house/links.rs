//! Whoever follows a link of the documentation arrives: the file is there, and the heading in it.
//! Every page of `docs` can be reached from README.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use std::{fs, iter};

use grasp_tests::workspace;

/// All pages in Markdown below a folder, without what was built or installed.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the folder can be read").map(|entry| entry.unwrap().path());
    let is_foreign = |path: &Path| {
        path.file_name().is_some_and(|name| ["target", ".git", "node_modules"].iter().any(|n| name == *n))
    };
    let below = entries.filter(|path| !is_foreign(path) && !path.is_symlink()).flat_map(|path| {
        let is_page = path.extension().is_some_and(|end| end == "md");
        if path.is_dir() { pages(&path) } else { iter::once(path).filter(|_| is_page).collect() }
    });
    below.collect()
}

/// A page without its blocks of code.
fn prose(page: &Path) -> String {
    let text = fs::read_to_string(page).expect("the page can be read");
    text.split("\n```").step_by(2).collect::<Vec<_>>().join("\n")
}

/// The names by which GitHub lets the headings of a page be linked to.
fn anchors(page: &Path) -> BTreeSet<String> {
    let text = prose(page);
    let headings = text
        .lines()
        .filter_map(|line| line.trim_start_matches('#').strip_prefix(' ').filter(|_| line.starts_with('#')));
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    headings
        .map(|heading| heading.to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-"))
        .collect()
}

/// Where a page links to within the project: files, as paths without `..`, and headings in them.
fn links(page: &Path) -> Vec<(PathBuf, Option<String>)> {
    let text = prose(page);
    let linked = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let shown = text.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let own = linked.chain(shown).filter(|link| !link.contains("://"));
    own.map(|link| {
        let (file, heading) =
            link.split_once('#').map_or((link, None), |(file, heading)| (file, Some(heading)));
        let path = if file.is_empty() { page.to_owned() } else { page.parent().unwrap().join(file) };
        let mut plain = PathBuf::new();
        for part in path.components() {
            match part {
                Component::ParentDir => drop(plain.pop()),
                part => plain.push(part),
            }
        }
        (plain, heading.map(str::to_owned))
    })
    .collect()
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let pages = pages(workspace());
    let mut followed = 0;
    for page in &pages {
        for (file, heading) in links(page) {
            assert!(file.exists(), "{} links to {}, which is not there", page.display(), file.display());
            if let Some(heading) = heading {
                let known = anchors(&file);
                assert!(known.contains(&heading), "{} links to #{heading}: {known:?}", page.display());
                followed += 1;
            }
        }
    }
    assert!(followed > 20, "{followed}");
}

#[test]
fn every_page_is_reached_from_the_readme() {
    let linked: BTreeSet<_> =
        links(&workspace().join("README.md")).into_iter().map(|(file, _)| file).collect();
    let missing: Vec<_> =
        pages(&workspace().join("docs")).into_iter().filter(|page| !linked.contains(page)).collect();
    assert_eq!(missing, Vec::<PathBuf>::new());
}
