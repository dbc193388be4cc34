//! Opening: the header, the catalogue and every section's range are checked. Of the sections, none
//! but the network's bytes are read.

use super::bytes::Bytes;
use super::catalogue::Catalogue;
use super::corruption::Corruption;
use super::error::OpenError;
use super::header::Header;
use super::layout::Layout;
use super::sections::SectionKind;
use super::wire;
use crate::descriptor::{DescriptorKind, DescriptorModel};
use crate::search::ReadAhead as _;
use grasp_network::Network;
use std::sync::Arc;
use xxhash_rust::xxh3::xxh3_64;

/// A file whose catalogue has been read and whose sections lie where they should.
#[derive(Debug)]
pub(crate) struct Opened {
    pub(crate) bytes: Bytes,
    pub(crate) header: Header,
    pub(crate) catalogue: Catalogue,
    layout: Layout,
    /// Behind a learned descriptor.
    pub(crate) network: Option<Arc<Network>>,
}

impl Opened {
    pub(crate) fn new(bytes: Bytes) -> Result<Self, OpenError> {
        let header = Header::read(&bytes)?;
        // The header's check has found the catalogue inside the file, so inside usize.
        let archive = bytes
            .get(header.catalogue_offset as usize..)
            .ok_or(Corruption::Catalogue("lies beyond the file"))?;
        // What is checked and then read is a copy: while a file is mapped, another program may
        // write to it.
        let archive = &*Bytes::private_copy(archive)?;
        if xxh3_64(archive) != header.catalogue_hash {
            return Err(Corruption::CatalogueHash.into());
        }
        // Its hash is right, so it is whole: something else wrote it.
        let catalogue = wire::read(archive, header.version).ok_or(Corruption::CatalogueForm)?;
        let layout = Layout::check(&catalogue, header.catalogue_offset)?;
        // Every search reads these, and they lie together before the catalogue.
        let searched = layout.range(SectionKind::BucketDirectory).start..header.catalogue_offset as usize;
        bytes.will_need(bytes.get(searched).unwrap_or(&[]));
        let network = network(&catalogue, bytes.get(layout.range(SectionKind::Network)).unwrap_or(&[]))?;
        Ok(Self { bytes, header, catalogue, layout, network })
    }

    /// The bytes of a section.
    pub(crate) fn raw(&self, kind: SectionKind) -> &[u8] {
        self.bytes.get(self.layout.range(kind)).unwrap_or(&[])
    }
}

/// The network that the descriptor names.
fn network(catalogue: &Catalogue, bytes: &[u8]) -> Result<Option<Arc<Network>>, OpenError> {
    let DescriptorKind::Learned { network: fingerprint, dim } = catalogue.descriptor.kind else {
        return Ok(None);
    };
    let network = Network::from_bytes(bytes).map_err(Corruption::Network)?;
    if network.fingerprint() != fingerprint || network.architecture().embedding != dim {
        return Err(Corruption::OtherNetwork.into());
    }
    let network = Arc::new(network);
    DescriptorModel::learned(Arc::clone(&network)).map_err(Corruption::Descriptor)?;
    Ok(Some(network))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::input::{IndexParams, NewEntry};
    use crate::{ClassInfo, IndexWriter};
    use grasp_network::Architecture;

    fn bytes_of(side: u32, embedding: u32) -> Vec<u8> {
        let architecture =
            Architecture { side, planes: 2, convolutions: Vec::new(), embedding, heads: 3, masks: None };
        let count = architecture.parameters().expect("a small network");
        Network::from_weights(architecture, vec![0.1; count]).expect("a network").to_bytes()
    }

    /// The catalogue of an index whose descriptors a network of this fingerprint made.
    fn catalogue(network: u64, dim: u32) -> Catalogue {
        let params = IndexParams {
            classes: vec![ClassInfo { name: "one".into(), cutkosky: 1 }],
            hand_shapes: vec!["mean".into()],
            stages: vec!["grasp".into()],
            ..IndexParams::default()
        };
        let descriptor = vec![0.5; params.descriptor.dim()];
        let mut writer = IndexWriter::new(params).expect("the parameters are sound");
        writer.push(NewEntry { descriptor, ..NewEntry::default() }).expect("the entry fits");
        let bytes = writer.finish_bytes().expect("the index is built");
        let mut catalogue = Opened::new(Bytes::copy(&bytes)).expect("it opens").catalogue;
        catalogue.descriptor.kind = DescriptorKind::Learned { network, dim };
        catalogue
    }

    /// Pictures would be described by one network and compared with descriptors of another.
    #[test]
    fn a_network_that_the_descriptors_do_not_name_is_refused() {
        let own = bytes_of(48, 5);
        let fingerprint = Network::from_bytes(&own).expect("a network").fingerprint();
        let read = |fingerprint, dim, bytes: &[u8]| network(&catalogue(fingerprint, dim), bytes);
        let found = read(fingerprint, 5, &own).expect("its own").map(|network| network.fingerprint());
        assert_eq!(found, Some(fingerprint));
        for (fingerprint, dim) in [(fingerprint ^ 1, 5), (fingerprint, 4)] {
            let refused = read(fingerprint, dim, &own).expect_err("it is another");
            assert!(matches!(refused, OpenError::Corrupt(Corruption::OtherNetwork)), "{refused}");
        }
        let other = bytes_of(24, 5);
        let fingerprint = Network::from_bytes(&other).expect("a network").fingerprint();
        let refused = read(fingerprint, 5, &other).expect_err("it takes other pictures");
        assert!(matches!(refused, OpenError::Corrupt(Corruption::Descriptor(_))), "{refused}");
    }
}
