//! One index in several files: segments that are searched, on one machine or on many, as the index
//! that they are.

use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::{AtomicFile, BuildError, Index};
use grasp_terminal::Progress;

use crate::interrupt::{self, Interrupted};
use crate::open_sound::open_sound;
use crate::same_file::is_same_file;

/// A segment that was written.
#[derive(Debug)]
pub struct Segment {
    /// Its file.
    pub path: PathBuf,
    /// Its entries, by their numbers in the index.
    pub entries: Range<u32>,
    /// How many bytes it has.
    pub bytes: u64,
}

/// Writes the index at `path` as `count` segments into the folder `out`: whole hand shapes, where
/// there are as many, in order, as many entries in each as can be. What a run that was killed has
/// left there is removed.
///
/// # Errors
/// When the index is damaged or has fewer entries, another run is writing the same segments, or one
/// cannot be written; then no segment of this index stays, and what was at the place of those that
/// were not begun is as it was.
/// [`Interrupted`] when the user asked to stop.
pub fn split(path: &Path, count: u32, out: &Path, progress: Progress) -> anyhow::Result<Vec<Segment>> {
    let index = open_sound(path)?;
    let is_input = |number: &u32| is_same_file(&out.join(file_name(*number, count)), path);
    if (1..=count).any(|number| is_input(&number)) {
        bail!("a segment would be written over {}: name another folder", path.display());
    }
    split_into(Place::new(out, count)?, path, &index, progress)
}

/// The folder that segments are written into, kept from other runs that write as many there:
/// neither mixes with the other, or removes what it has written.
pub(crate) struct Place<'a> {
    folder: &'a Path,
    count: u32,
    /// The last segment, which is locked.
    last: AtomicFile,
}

impl<'a> Place<'a> {
    /// Makes the folder where there is none, and removes what a run that was killed has left in it.
    ///
    /// # Errors
    /// When it cannot be made, or another run writes as many segments there.
    pub(crate) fn new(folder: &'a Path, count: u32) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        clear(folder);
        let last = AtomicFile::create(&folder.join(file_name(count, count)))?;
        Ok(Self { folder, count, last })
    }
}

/// [`split`], of an index that is open, into a place that is kept already.
pub(crate) fn split_into(
    place: Place<'_>,
    path: &Path,
    index: &Index,
    progress: Progress,
) -> anyhow::Result<Vec<Segment>> {
    let Place { folder, count, last } = place;
    let ends = ends(index, count)?;
    let mut last = Some(last);
    let bar = progress.bar(u64::from(count), "splitting", "segments");
    let mut written = Written::default();
    let mut start = 0;
    for (end, number) in ends.into_iter().zip(1..) {
        let path = folder.join(file_name(number, count));
        let entries = start..end;
        let note = format!("{number} of {count}: entries {} to {} of {}", start, end - 1, index.len());
        let provenance = vec![("segment".to_owned(), note)];
        let file = match last.take_if(|_| number == count) {
            Some(last) => last,
            None => AtomicFile::create(&path)?,
        };
        let bytes = match index.write_segment(entries.clone(), provenance, file, &interrupt::flow) {
            Err(BuildError::Stopped) => return Err(Interrupted.into()),
            other => other.with_context(|| format!("{} was not written", path.display()))?,
        };
        written.0.push(Segment { path, entries, bytes });
        start = end;
        bar.inc(1);
    }
    // Dropped otherwise, all that were written go.
    index.check_unchanged().with_context(|| format!("cannot use the index {}", path.display()))?;
    drop(bar);
    Ok(std::mem::take(&mut written.0))
}

/// Segments on their way. Some of them are no index: dropped before all are there, they go.
#[derive(Default)]
struct Written(Vec<Segment>);

impl Drop for Written {
    fn drop(&mut self) {
        // Nothing can be done about a failure here.
        self.0.iter().for_each(|segment| drop(std::fs::remove_file(&segment.path)));
    }
}

/// Removes from `folder` what a run that was killed has left of segments on their way. What another
/// program is writing is locked, and stays.
fn clear(folder: &Path) {
    let Ok(entries) = folder.read_dir() else { return };
    for name in entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()) {
        let on_its_way = name.strip_prefix('.').and_then(|name| name.strip_suffix(".part"));
        if let Some(name) = on_its_way.filter(|name| is_segment(name)) {
            // Taken over, as a run of as many segments would, and dropped.
            drop(AtomicFile::create(&folder.join(name)));
        }
    }
}

/// Whether [`file_name`] makes such names.
fn is_segment(name: &str) -> bool {
    let numbers = name.strip_suffix(".idx").and_then(|name| name.split_once("-of-"));
    let numbers = numbers.and_then(|(number, count)| Some((number.parse().ok()?, count.parse().ok()?)));
    numbers.is_some_and(|(number, count)| name == file_name(number, count))
}

/// The name of a segment's file; in the order of the names are the entries.
#[must_use]
pub fn file_name(number: u32, count: u32) -> String {
    let width = count.to_string().len();
    format!("{number:0width$}-of-{count}.idx")
}

/// Where each segment ends: where another hand shape begins, if there are as many, next to its even
/// share.
fn ends(index: &Index, count: u32) -> anyhow::Result<Vec<u32>> {
    let entries = index.len() as u32;
    let mut begins = Vec::new();
    if index.catalogue().kept.labels {
        let hand = |id| index.entry(id).map(|entry| entry.hand_shape);
        let mut last = hand(0)?;
        for id in 1..entries {
            let hand = hand(id)?;
            if std::mem::replace(&mut last, hand) != hand {
                begins.push(id);
            }
        }
    }
    if begins.len() + 1 < count as usize {
        begins = (1..entries).collect();
    }
    if begins.len() + 1 < count as usize {
        bail!("{entries} entries make {entries} segments at most, not {count}");
    }
    Ok(evenly(&begins, entries, count))
}

/// Of the places `begins`, ascending, those next to the even shares of `entries`, and the end.
fn evenly(begins: &[u32], entries: u32, count: u32) -> Vec<u32> {
    let mut ends = Vec::with_capacity(count as usize);
    let mut from = 0;
    for number in 1..count {
        let wanted = (u64::from(number) * u64::from(entries) / u64::from(count)) as u32;
        // Each segment after this one needs a place of its own.
        let most = begins.len() - (count - 1 - number) as usize;
        let free = begins.get(from..most).unwrap_or(&[]);
        let after = free.partition_point(|&begin| begin < wanted).min(free.len().saturating_sub(1));
        let before = after.saturating_sub(1);
        let distance = |at: usize| free.get(at).map_or(u32::MAX, |begin| begin.abs_diff(wanted));
        let at = if distance(before) <= distance(after) { before } else { after };
        ends.extend(free.get(at));
        from += at + 1;
    }
    ends.push(entries);
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_even_and_none_is_empty() {
        assert_eq!(evenly(&[100, 200, 300], 400, 4), [100, 200, 300, 400]);
        assert_eq!(evenly(&[100, 200, 300], 400, 2), [200, 400]);
        assert_eq!(evenly(&[390, 391, 392], 400, 4), [390, 391, 392, 400]);
        assert_eq!(evenly(&[1, 2, 3], 400, 3), [2, 3, 400]);
        assert_eq!(evenly(&[], 5, 1), [5]);
        for count in 1..=9 {
            let begins: Vec<u32> = (1..9).collect();
            let ends = evenly(&begins, 9, count);
            assert_eq!(ends.len(), count as usize);
            assert!(ends.windows(2).all(|pair| pair[0] < pair[1]), "{ends:?}");
        }
    }

    #[test]
    fn names_sort_as_segments_do() {
        assert_eq!([file_name(3, 4), file_name(3, 12)], ["3-of-4.idx", "03-of-12.idx"]);
        assert!(is_segment("3-of-4.idx") && is_segment("03-of-12.idx"));
        assert!(
            ["3-of-12.idx", "a-of-4.idx", "3-of-4", "grasp.idx", "+3-of-4.idx"]
                .iter()
                .all(|name| !is_segment(name))
        );
    }
}
