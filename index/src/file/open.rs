//! Opening: the header, the catalogue and every section's range are checked; no section's bytes are read.

use super::bytes::Bytes;
use super::catalogue::Catalogue;
use super::error::OpenError;
use super::header::Header;
use super::layout::Layout;
use super::sections::SectionKind;
use super::version2::CatalogueOfVersion2;
use crate::search::ReadAhead as _;
use bytemuck::AnyBitPattern;
use rkyv::rancor::Error as ArchiveError;
use xxhash_rust::xxh3::xxh3_64;

/// A file whose catalogue has been read and whose sections lie where they should.
#[derive(Debug)]
pub(crate) struct Opened {
    pub(crate) bytes: Bytes,
    pub(crate) header: Header,
    pub(crate) catalogue: Catalogue,
    layout: Layout,
}

impl Opened {
    pub(crate) fn new(bytes: Bytes) -> Result<Self, OpenError> {
        let header = Header::read(&bytes)?;
        // The header's check has found the catalogue inside the file, so inside usize.
        let archive = bytes
            .get(header.catalogue_offset as usize..)
            .ok_or_else(|| OpenError::corrupt("the catalogue lies beyond the file"))?;
        if xxh3_64(archive) != header.catalogue_hash {
            return Err(OpenError::corrupt("the catalogue does not match its hash"));
        }
        // Its hash is right, so it is whole: something else wrote it.
        let unreadable =
            |_: ArchiveError| OpenError::corrupt("the catalogue is not of the form that this version reads");
        let catalogue = match header.version {
            2 => version_2(archive),
            _ => rkyv::from_bytes::<Catalogue, ArchiveError>(archive),
        };
        let catalogue = catalogue.map_err(unreadable)?;
        let layout = Layout::check(&catalogue, header.catalogue_offset)?;
        // Every search reads these, and they lie together before the catalogue.
        let searched = layout.range(SectionKind::BucketDirectory).start..header.catalogue_offset as usize;
        bytes.will_need(bytes.get(searched).unwrap_or(&[]));
        Ok(Self { bytes, header, catalogue, layout })
    }

    /// The bytes of a section.
    pub(crate) fn raw(&self, kind: SectionKind) -> &[u8] {
        self.bytes.get(self.layout.range(kind)).unwrap_or(&[])
    }

    /// A section as the numbers it holds. `T` must be of the section's element type.
    pub(crate) fn array<T: AnyBitPattern>(&self, kind: SectionKind) -> &[T] {
        // Sections start at multiples of 64 and their lengths were checked: this cannot fail.
        bytemuck::try_cast_slice(self.raw(kind)).unwrap_or(&[])
    }

    /// String `at` of a table of text; `None` where the bounds make no sense or the bytes are no text.
    pub(crate) fn text(&self, offsets: SectionKind, text: SectionKind, at: usize) -> Option<&str> {
        let offsets: &[u32] = self.array(offsets);
        let (start, end) = (*offsets.get(at)?, *offsets.get(at.checked_add(1)?)?);
        std::str::from_utf8(self.raw(text).get(start as usize..end as usize)?).ok()
    }
}

/// Validated as [`rkyv::from_bytes`] always does.
fn version_2(archive: &[u8]) -> Result<Catalogue, ArchiveError> {
    rkyv::from_bytes::<CatalogueOfVersion2, ArchiveError>(archive).map(Catalogue::from)
}
