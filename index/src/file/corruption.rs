//! What is not as it was when an index was written.

use grasp_network::ReadError;
use thiserror::Error;

use super::sections::SectionKind;
use crate::descriptor::ParamsError;

/// What is wrong with a file that begins as an index does.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Corruption {
    /// Bytes of the header have changed.
    #[error("the header does not match its hash")]
    Header,
    /// The header names another place for the catalogue than the file's end.
    #[error("the catalogue should start at a multiple of {alignment} and end with the file")]
    CataloguePlace {
        /// In bytes.
        alignment: u64,
    },
    /// Bytes of the catalogue have changed.
    #[error("the catalogue does not match its hash")]
    CatalogueHash,
    /// Something else has written the catalogue.
    #[error("the catalogue is not of the form that this version reads")]
    CatalogueForm,
    /// The catalogue contradicts itself.
    #[error("the catalogue {0}")]
    Catalogue(&'static str),
    /// The parameters of the descriptors are impossible.
    #[error(transparent)]
    Descriptor(#[from] ParamsError),
    /// A section is not where, or as long as, the catalogue's numbers say.
    #[error("the section {kind:?} {what}")]
    Section {
        /// The section.
        kind: SectionKind,
        /// What is wrong with it.
        what: &'static str,
    },
    /// The network that described the pictures cannot be read.
    #[error("the network of its descriptors: {0}")]
    Network(ReadError),
    /// It is another one than the descriptors name.
    #[error("its network is another than its descriptors were made by")]
    OtherNetwork,
}
