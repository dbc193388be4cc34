//! Names of the node and of its topics, as ROS resolves and remaps them.

use anyhow::bail;

/// `-r [NODE:]FROM:=TO`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Remap {
    /// The node that it is for; all where there is none.
    pub(crate) node: Option<String>,
    pub(crate) from: String,
    pub(crate) to: String,
}

impl Remap {
    /// Whether it is for the node of this name.
    pub(crate) fn is_for(&self, node: &str) -> bool {
        self.node.as_ref().is_none_or(|named| named == node)
    }
}

/// The node's name, and how its topics are called.
#[derive(Clone, Debug)]
pub(crate) struct Names {
    namespace: String,
    node: String,
    remaps: Vec<Remap>,
}

impl Names {
    /// The names of a node in a namespace, which may lack its leading slash.
    ///
    /// # Errors
    /// Where one of them is no name.
    pub(crate) fn new(namespace: &str, node: &str, remaps: Vec<Remap>) -> anyhow::Result<Self> {
        let namespace = format!("/{}", namespace.trim_matches('/'));
        if namespace != "/" {
            check(&namespace)?;
        }
        if !is_token(node) {
            bail!("{node:?} is no name of a node: letters, digits and single underscores make one");
        }
        Ok(Self { namespace, node: node.to_owned(), remaps })
    }

    /// The node's own name.
    pub(crate) fn node(&self) -> &str {
        &self.node
    }

    /// The node's namespace, with a leading slash.
    pub(crate) fn namespace(&self) -> &str {
        &self.namespace
    }

    /// The node's full name.
    pub(crate) fn node_path(&self) -> String {
        below(&self.namespace, &self.node)
    }

    /// The full name of a topic that the node calls `name`, after remapping.
    ///
    /// # Errors
    /// Where a remapping leads to something that is no name.
    pub(crate) fn topic(&self, name: &str) -> anyhow::Result<String> {
        self.remapped(name)?.map_or_else(|| self.full(name), Ok)
    }

    /// What a remapping makes of the topic that the node calls `name`, where there is one for it.
    ///
    /// # Errors
    /// As [`Self::topic`].
    pub(crate) fn remapped(&self, name: &str) -> anyhow::Result<Option<String>> {
        let own = self.full(name)?;
        for remap in &self.remaps {
            if remap.is_for(&self.node) && self.full(&remap.from)? == own {
                return self.full(&remap.to).map(Some);
            }
        }
        Ok(None)
    }

    /// A full name: `~` is the node, and a name without a leading slash lies in its namespace.
    fn full(&self, name: &str) -> anyhow::Result<String> {
        let path = match (name.strip_prefix('~'), name.starts_with('/')) {
            (Some(rest), _) => below(&self.node_path(), rest.trim_start_matches('/')),
            (None, true) => name.to_owned(),
            (None, false) => below(&self.namespace, name),
        };
        check(&path)?;
        Ok(path)
    }
}

fn below(folder: &str, name: &str) -> String {
    format!("{}/{name}", folder.trim_end_matches('/'))
}

/// What stands beside a topic: `/camera/image` has `/camera/NAME` beside it.
pub(crate) fn beside(topic: &str, name: &str) -> String {
    let folder = topic.rsplit_once('/').map_or("", |(folder, _)| folder);
    below(folder, name)
}

/// Checks a full name.
fn check(path: &str) -> anyhow::Result<()> {
    let is_sound = path.strip_prefix('/').is_some_and(|parts| parts.split('/').all(is_token));
    if is_sound {
        return Ok(());
    }
    bail!(
        "{path:?} is no name: its parts, between slashes, are of letters, digits and single underscores, and begin with no \
         digit"
    );
}

fn is_token(part: &str) -> bool {
    let is_letter = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let begins = part.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
    begins && part.chars().all(is_letter) && !part.contains("__")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(namespace: &str, remaps: &[(&str, &str)]) -> Names {
        let remap =
            |&(from, to): &(&str, &str)| Remap { node: None, from: from.to_owned(), to: to.to_owned() };
        Names::new(namespace, "grasp", remaps.iter().map(remap).collect()).unwrap()
    }

    #[test]
    fn names_lie_in_the_namespace_below_the_node_or_where_they_say() {
        let names = names("/arm", &[]);
        assert_eq!(names.topic("image").unwrap(), "/arm/image");
        assert_eq!(names.topic("~/pose").unwrap(), "/arm/grasp/pose");
        assert_eq!(names.topic("/image").unwrap(), "/image");
        assert_eq!(super::tests::names("/", &[]).topic("image").unwrap(), "/image");
    }

    #[test]
    fn a_remapping_is_found_however_it_is_written() {
        for from in ["image", "/arm/image"] {
            let names = names("arm", &[(from, "/camera/image_raw")]);
            assert_eq!(names.topic("image").unwrap(), "/camera/image_raw");
            assert_eq!(names.topic("camera_info").unwrap(), "/arm/camera_info");
        }
        let names = names("arm", &[("~/pose", "hand")]);
        assert_eq!(names.topic("~/pose").unwrap(), "/arm/hand");
        assert_eq!(names.remapped("image").unwrap(), None);
    }

    #[test]
    fn a_remapping_for_another_node_is_not_ours() {
        let remap = Remap { node: Some("other".into()), from: "image".into(), to: "/x".into() };
        let names = Names::new("/", "grasp", vec![remap]).unwrap();
        assert_eq!(names.topic("image").unwrap(), "/image");
    }

    #[test]
    fn what_is_no_name_is_an_error() {
        for name in ["", "a//b", "/a/", "1a", "a__b", "a b", "/"] {
            assert!(names("/", &[("image", name)]).topic("image").is_err(), "{name:?}");
        }
        assert!(Names::new("/a//b", "grasp", Vec::new()).is_err());
        assert!(Names::new("/", "a/b", Vec::new()).is_err());
    }

    #[test]
    fn the_description_of_a_camera_lies_beside_its_pictures() {
        assert_eq!(beside("/camera/image_raw", "camera_info"), "/camera/camera_info");
        assert_eq!(beside("/image", "camera_info"), "/camera_info");
    }
}
