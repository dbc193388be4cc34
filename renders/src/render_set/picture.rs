//! PNG files that say which parameters made them.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufReader, Write};
use std::path::Path;

use crate::scene::Render;

/// Keyword of the text chunk that holds the scene's parameter hash and the view.
const KEYWORD: &str = "grasp-renders";

/// What identifies a render's pixels: the scene's parameters and the view.
pub(super) fn stamp(params_hash: u64, render: &crate::View) -> String {
    format!("{params_hash:016x} {} {} {}", render.azimuth_deg, render.elevation_deg, render.roll_deg)
}

/// The PNG file of a render; the same render gives the same bytes.
pub(super) fn encode(render: &Render, stamp: &str) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let side = u32::try_from(render.side).map_err(io::Error::other)?;
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.add_text_chunk(KEYWORD.to_owned(), stamp.to_owned())?;
    encoder.write_header()?.write_image_data(&render.grey)?;
    Ok(bytes)
}

/// The most bytes that the parts of a render's file may take besides its pixels: far more than its
/// stamp and a row.
const MAX_BESIDES: usize = 1 << 20;

/// The most bytes of pixels that a picture may have to be taken for a render.
const MAX_PIXEL_BYTES: usize = 64 << 20;

/// The picture at `path` behind its header, whoever wrote it. What an unknown file unpacks to is
/// bounded.
fn open(path: &Path) -> Option<png::Reader<BufReader<File>>> {
    let file = BufReader::new(File::open(path).ok()?);
    let mut decoder = png::Decoder::new_with_limits(file, png::Limits { bytes: MAX_BESIDES });
    decoder.set_ignore_iccp_chunk(true);
    decoder.read_info().ok()
}

/// Whether a whole, readable picture with this stamp already lies at `path`.
pub(super) fn is_current(path: &Path, stamp: &str) -> bool {
    let Some(mut reader) = open(path) else {
        return false;
    };
    let matches = |chunk: &png::text_metadata::TEXtChunk| chunk.keyword == KEYWORD && chunk.text == stamp;
    if !reader.info().uncompressed_latin1_text.iter().any(matches) {
        return false;
    }
    let Some(size) = reader.output_buffer_size().filter(|&size| size <= MAX_PIXEL_BYTES) else {
        return false;
    };
    let mut pixels = vec![0; size];
    reader.next_frame(&mut pixels).is_ok() && reader.finish().is_ok()
}

/// Whether a picture carries any stamp of this program.
pub(super) fn is_ours(path: &Path) -> bool {
    open(path).is_some_and(|reader| {
        reader.info().uncompressed_latin1_text.iter().any(|chunk| chunk.keyword == KEYWORD)
    })
}

/// Writes a picture so that a reader finds either the whole of it or what was there before. After a
/// power cut it may be damaged, which [`is_current`] notices.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    replace(path, bytes, |_| Ok(()))
}

/// The same of a file that nobody notices to be damaged: it is on the disk before it has its name.
pub(super) fn write_durably(path: &Path, bytes: &[u8]) -> io::Result<()> {
    replace(path, bytes, File::sync_all)
}

/// Writes beside a file, under a name that every run uses again, and puts that in its place.
fn replace(path: &Path, bytes: &[u8], finish: impl Fn(&File) -> io::Result<()>) -> io::Result<()> {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".part");
    let part = path.with_file_name(name);
    // What a run that was killed has left there, or a link of somebody else's.
    match fs::remove_file(&part) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let written = File::create_new(&part).and_then(|mut file| {
        file.write_all(bytes)?;
        finish(&file)
    });
    let replaced = written.and_then(|()| fs::rename(&part, path));
    if replaced.is_err() {
        // What is wrong is reported; that this stays is not.
        let _ = fs::remove_file(&part);
    }
    replaced
}
