//! A segment: some of an index's entries, with all that was learned from all of them.

use super::sink::Sink;
use super::{Failure, failed, seal};
use crate::file::atomic::AtomicFile;
use crate::file::catalogue::Catalogue;
use crate::file::header;
use crate::file::input::BuildError;
use crate::file::open::Opened;
use crate::file::sections::{Section, SectionKind};
use crate::search::blocks::{self, BlockMut, Blocks, LANES};
use crate::search::hash::HashInfo;
use crate::search::learned::LearnedHash;
use crate::search::random::tables::Buckets;
use std::borrow::Cow;
use std::ops::{ControlFlow, Range};

/// What cannot be read as it must have been written.
const DAMAGED: BuildError =
    BuildError::Params("the index is damaged: run `grasp-builder verify` on it, and build it again");

/// Writes the entries `entries` of `index` to `file` and puts it in its place; returns how many
/// bytes it has. `provenance` is added to the index's own, and `proceed` may stop the work.
pub(crate) fn write_segment(
    index: &Opened,
    entries: Range<u32>,
    provenance: Vec<(String, String)>,
    file: AtomicFile,
    proceed: &dyn Fn() -> ControlFlow<()>,
) -> Result<u64, BuildError> {
    if entries.is_empty() {
        return Err(BuildError::Empty);
    }
    if u64::from(entries.end) > index.catalogue.entries {
        return Err(BuildError::Params("a segment has no other entries than its index"));
    }
    let handle = file.handle().map_err(|source| failed(Some(&file), source))?;
    let mut out = Sink::file(handle);
    let bytes = write(index, entries, provenance, &mut out, proceed).map_err(|failure| match failure {
        Failure::Io(source) => failed(Some(&file), source),
        Failure::Build(error) => error,
    })?;
    file.commit()?;
    Ok(bytes)
}

fn write(
    index: &Opened,
    entries: Range<u32>,
    provenance: Vec<(String, String)>,
    out: &mut Sink,
    proceed: &dyn Fn() -> ControlFlow<()>,
) -> Result<u64, Failure> {
    let filled = Filled::new(index, &entries)?;
    out.append(&[0; header::LENGTH])?;
    let mut sections: Vec<Section> = Vec::new();
    for &kind in SectionKind::of(&index.catalogue.descriptor) {
        out.open()?;
        let bytes = section(index, kind, &entries, &filled).ok_or(DAMAGED)?;
        out.append_all(&bytes, &mut |_| match proceed() {
            ControlFlow::Continue(()) => Ok::<(), Failure>(()),
            ControlFlow::Break(()) => Err(BuildError::Stopped.into()),
        })?;
        sections.push(out.close(kind, kind.element(index.catalogue.originals)));
    }
    let own = index.catalogue.clone();
    let catalogue = Catalogue {
        entries: entries.len() as u64,
        hash: own.hash.with_entry_blocks(filled.entry_blocks),
        provenance: own.provenance.into_iter().chain(provenance).collect(),
        sections,
        ..own
    };
    Ok(seal(out, &catalogue, index.network.as_deref())?)
}

/// The bytes of a section of the segment; `None` where the index's own make no sense.
fn section<'a>(
    index: &'a Opened,
    kind: SectionKind,
    entries: &Range<u32>,
    filled: &'a Filled,
) -> Option<Cow<'a, [u8]>> {
    let whole = index.raw(kind);
    let range = entries.start as usize..entries.end as usize;
    let texts = || {
        let offsets = index.file_offsets();
        if offsets.is_empty() { Some(offsets) } else { offsets.get(range.start..range.end.checked_add(1)?) }
    };
    Some(match kind {
        SectionKind::Descriptors
        | SectionKind::Thumbnails
        | SectionKind::SourceHashes
        | SectionKind::Views
        | SectionKind::Stages
        | SectionKind::HandShapes
        | SectionKind::Labels
        | SectionKind::Orientations
        | SectionKind::Objects => {
            // As many bytes an entry as opening has found; none where it is not kept.
            let each = whole.len() / usize::try_from(index.catalogue.entries).ok()?.max(1);
            Cow::Borrowed(whole.get(range.start.checked_mul(each)?..range.end.checked_mul(each)?)?)
        }
        SectionKind::FileOffsets => {
            let offsets = texts()?;
            let start = offsets.first().copied().unwrap_or_default();
            let moved: Option<Vec<u32>> = offsets.iter().map(|offset| offset.checked_sub(start)).collect();
            Cow::Owned(bytemuck::cast_slice(&moved?).to_vec())
        }
        SectionKind::FileText => match texts()? {
            [] => Cow::Borrowed(&[]),
            offsets => Cow::Borrowed(whole.get(*offsets.first()? as usize..*offsets.last()? as usize)?),
        },
        SectionKind::BucketDirectory => Cow::Borrowed(bytemuck::cast_slice(&filled.directory)),
        SectionKind::BucketIds => Cow::Borrowed(bytemuck::cast_slice(&filled.ids)),
        SectionKind::EntryBlocks => Cow::Borrowed(&filled.blocks),
        _ => Cow::Borrowed(whole),
    })
}

/// The buckets, with the segment's entries alone, by its own numbers.
struct Filled {
    directory: Vec<u32>,
    /// Of a random hash.
    ids: Vec<u32>,
    /// Of a learned hash.
    blocks: Vec<u8>,
    entry_blocks: u32,
}

impl Filled {
    fn new(index: &Opened, entries: &Range<u32>) -> Result<Self, BuildError> {
        let directory = index.bucket_directory();
        let mut filled = Self { directory: vec![0], ids: Vec::new(), blocks: Vec::new(), entry_blocks: 0 };
        let own = |id: u32| entries.contains(&id).then(|| id - entries.start);
        match index.catalogue.hash {
            HashInfo::Random(hash) => {
                let buckets = Buckets { directory, ids: index.bucket_ids() };
                for bucket in 0..directory.len().saturating_sub(1) as u32 {
                    filled.ids.extend(buckets.get(bucket).iter().filter_map(|&id| own(id)));
                    // A directory that goes back and forth would hand out the same ids for ever.
                    if filled.ids.len() > buckets.ids.len() {
                        return Err(DAMAGED);
                    }
                    filled.directory.push(filled.ids.len() as u32);
                }
                // Each table has every entry once.
                let are_whole = filled.ids.len() == hash.tables as usize * entries.len();
                are_whole.then_some(filled).ok_or(DAMAGED)
            }
            HashInfo::Learned(hash) => {
                let all = index.entry_blocks(&hash);
                let mut entered = 0;
                for bounds in directory.windows(2) {
                    let [start, end] = *bounds else { continue };
                    entered += filled.put(all.run(start, end), &hash, own);
                    if entered > entries.len() {
                        return Err(DAMAGED);
                    }
                    filled.directory.push(filled.entry_blocks);
                }
                (entered == entries.len()).then_some(filled).ok_or(DAMAGED)
            }
        }
    }

    /// Adds to the blocks those entries of a bucket that are the segment's `own`, and returns how
    /// many these are.
    fn put(&mut self, bucket: Blocks<'_>, hash: &LearnedHash, own: impl Fn(u32) -> Option<u32>) -> usize {
        let (axes, bits) = (hash.axes as usize, hash.code_bits);
        let stride = blocks::entry_stride(axes, bits);
        let mut entered = 0;
        let mut start = 0;
        for block in bucket.iter() {
            for at in 0..LANES {
                let Some(id) = own(block.id(at)) else { continue };
                if entered % LANES == 0 {
                    start = self.blocks.len();
                    self.blocks.resize(start + stride, 0);
                    self.entry_blocks += 1;
                }
                if let Some(into) = self.blocks.get_mut(start..) {
                    BlockMut::new(into, axes, bits).copy(entered % LANES, &block, at, id);
                }
                entered += 1;
            }
        }
        if let Some(last) = self.blocks.get_mut(start..).filter(|_| entered > 0) {
            let unused = entered.next_multiple_of(LANES) - entered;
            let mut last = BlockMut::new(last, axes, bits);
            (LANES - unused..LANES).for_each(|lane| last.put_nothing(lane));
        }
        entered
    }
}
