//! Where the parts of a hash lie in the file.

use crate::file::sections::SectionKind;
use crate::search::build::OwnedHash;

/// The bytes of one of the hash's sections; none for a section that is another's.
pub(super) fn section(hash: &OwnedHash, kind: SectionKind) -> &[u8] {
    match hash {
        OwnedHash::Random { normals, offsets, tables, .. } => match kind {
            SectionKind::PlaneNormals => bytemuck::cast_slice(normals),
            SectionKind::PlaneOffsets => bytemuck::cast_slice(offsets),
            SectionKind::BucketDirectory => bytemuck::cast_slice(&tables.directory),
            SectionKind::BucketIds => bytemuck::cast_slice(&tables.ids),
            _ => &[],
        },
        OwnedHash::Learned(fitted) => match kind {
            SectionKind::Axes => bytemuck::cast_slice(&fitted.axes.projection),
            SectionKind::GroupCentres => &fitted.groups,
            SectionKind::GroupDirectory => bytemuck::cast_slice(&fitted.group_directory),
            SectionKind::BucketCentres => &fitted.centres,
            SectionKind::BucketDirectory => bytemuck::cast_slice(&fitted.bucket_directory),
            SectionKind::EntryBlocks => &fitted.entries,
            _ => &[],
        },
    }
}
