//! The container: a header, a JSON document and one block of numbers (glTF 2.0, section 4.4). Only
//! what a skinned mesh needs is read, and nothing is believed: every range is checked before it is
//! used, every count before it is stored.

use std::cell::Cell;

use serde::Deserialize;

use super::error::HandModelError;
use super::fault::{ModelFault, Unsupported};
use super::few::few;

/// Bytes of the JSON document: a hand's has some ten thousand.
const LONGEST_DOCUMENT: usize = 16 << 20;
/// Rows that one accessor may have: more than the largest mesh taken has vertices.
const MOST_ROWS: usize = 4_000_000;
/// Rows that are read of a file altogether: every node may name the same large accessor.
const MOST_ROWS_READ: usize = 8 * MOST_ROWS;
const MAGIC: &[u8] = b"glTF";
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;
/// Extensions that change how a surface looks, or how numbers are stored in ways that are read here
/// anyway.
const HARMLESS: [&str; 4] = ["KHR_mesh_quantization", "KHR_materials_", "KHR_texture_", "EXT_texture_"];

/// The JSON document, as far as it is used.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    asset: Asset,
    #[serde(default, deserialize_with = "few")]
    extensions_required: Vec<String>,
    #[serde(default, deserialize_with = "few")]
    pub(super) nodes: Vec<Node>,
    #[serde(default, deserialize_with = "few")]
    pub(super) skins: Vec<Skin>,
    #[serde(default, deserialize_with = "few")]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default, deserialize_with = "few")]
    accessors: Vec<Accessor>,
    #[serde(default, deserialize_with = "few")]
    buffer_views: Vec<BufferView>,
    #[serde(default, deserialize_with = "few")]
    buffers: Vec<Buffer>,
}

#[derive(Debug, Deserialize)]
struct Asset {
    version: String,
}

#[derive(Debug, Deserialize)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    #[serde(default, deserialize_with = "few")]
    pub(super) children: Vec<usize>,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    #[serde(deserialize_with = "few")]
    pub(super) joints: Vec<usize>,
    pub(super) inverse_bind_matrices: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    #[serde(deserialize_with = "few")]
    pub(super) primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: std::collections::BTreeMap<String, usize>,
    pub(super) indices: Option<usize>,
    /// 4, or nothing: triangles.
    pub(super) mode: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    #[serde(default)]
    normalized: bool,
    count: usize,
    #[serde(rename = "type")]
    kind: String,
    sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Debug, Deserialize)]
struct Buffer {
    uri: Option<String>,
}

/// A file taken apart.
#[derive(Debug)]
pub(super) struct Glb<'a> {
    pub(super) document: Document,
    numbers: &'a [u8],
    /// Rows that have been read.
    read: Cell<usize>,
}

impl<'a> Glb<'a> {
    /// Takes a file apart; the numbers are read when they are asked for.
    pub(super) fn parse(file: &'a [u8]) -> Result<Glb<'a>, HandModelError> {
        let word = |at: usize| -> Option<u32> {
            Some(u32::from_le_bytes(file.get(at..at.checked_add(4)?)?.try_into().ok()?))
        };
        if file.get(..4) != Some(MAGIC) {
            return Err(HandModelError::NotGlb);
        }
        let version = word(4).unwrap_or_default();
        if version != 2 {
            return Err(ModelFault::Version(version).into());
        }
        let expected = word(8).unwrap_or_default() as usize;
        if expected > file.len() {
            return Err(ModelFault::Truncated { expected, found: file.len() }.into());
        }
        let chunk = |at: usize, kind: u32| -> Option<&'a [u8]> {
            let (size, found) = (word(at)? as usize, word(at.checked_add(4)?)?);
            let start = at.checked_add(8)?;
            let body = file.get(start..start.checked_add(size)?)?;
            (found == kind).then_some(body)
        };
        let json = chunk(12, JSON).ok_or(ModelFault::NoDocument)?;
        if json.len() > LONGEST_DOCUMENT {
            return Err(Unsupported::TooFine { what: "bytes of description", most: LONGEST_DOCUMENT }.into());
        }
        let document: Document = serde_json::from_slice(json)?;
        // Parts start at multiples of four, the JSON document after 20 bytes.
        let numbers = chunk(20 + json.len().next_multiple_of(4), BIN).unwrap_or_default();
        let glb = Glb { document, numbers, read: Cell::new(0) };
        glb.check()?;
        Ok(glb)
    }

    fn check(&self) -> Result<(), HandModelError> {
        let document = &self.document;
        if !document.asset.version.starts_with("2.") {
            return Err(ModelFault::AssetVersion(document.asset.version.clone()).into());
        }
        let known = |name: &String| HARMLESS.iter().any(|harmless| name.starts_with(harmless));
        if let Some(name) = document.extensions_required.iter().find(|name| !known(name)) {
            return Err(Unsupported::Extension(name.clone()).into());
        }
        if let Some(uri) = document.buffers.iter().find_map(|buffer| buffer.uri.as_ref()) {
            return Err(Unsupported::Outside(uri.chars().take(40).collect()).into());
        }
        Ok(())
    }

    /// The rows of an accessor whose type is `kind`, which has `N` numbers a row. Numbers that are
    /// stored as whole ones are scaled where the file says so.
    pub(super) fn rows<const N: usize>(
        &self,
        accessor: usize,
        kind: &str,
    ) -> Result<Vec<[f64; N]>, HandModelError> {
        let Some(found) = self.document.accessors.get(accessor) else {
            return Err(ModelFault::NoAccessor(accessor).into());
        };
        if found.kind != kind {
            let (found, wanted) = (found.kind.clone(), kind.to_owned());
            return Err(ModelFault::AccessorType { accessor, found, wanted }.into());
        }
        if found.sparse.is_some() {
            return Err(Unsupported::Sparse(accessor).into());
        }
        if found.count > MOST_ROWS {
            let rows = found.count;
            return Err(ModelFault::AccessorRows { accessor, rows, most: MOST_ROWS }.into());
        }
        self.read.set(self.read.get().saturating_add(found.count));
        if self.read.get() > MOST_ROWS_READ {
            return Err(Unsupported::TooFine { what: "rows of numbers", most: MOST_ROWS_READ }.into());
        }
        let component = Component::of(found.component_type, found.normalized)
            .ok_or(ModelFault::NumberType { accessor, kind: found.component_type })?;
        let outside = || ModelFault::AccessorOutside(accessor);
        let view = found.buffer_view.and_then(|view| self.document.buffer_views.get(view));
        let view = view.filter(|view| view.buffer == 0).ok_or_else(outside)?;
        let end = view.byte_offset.checked_add(view.byte_length).ok_or_else(outside)?;
        let bytes = self.numbers.get(view.byte_offset..end).ok_or_else(outside)?;
        let bytes = bytes.get(found.byte_offset..).ok_or_else(outside)?;
        let row = N * component.size;
        let stride = view.byte_stride.unwrap_or(row);
        if stride < row {
            return Err(ModelFault::RowsOverlap(accessor).into());
        }
        // The last row need not be as long as the stride.
        let needed = found.count.saturating_sub(1).checked_mul(stride).and_then(|n| n.checked_add(row));
        if found.count > 0 && needed.is_none_or(|needed| needed > bytes.len()) {
            return Err(outside().into());
        }
        let rows = bytes.chunks(stride).take(found.count);
        Ok(rows
            .map(|bytes| {
                let mut row = [0.0; N];
                for (value, bytes) in row.iter_mut().zip(bytes.chunks_exact(component.size)) {
                    *value = component.read(bytes);
                }
                row
            })
            .collect())
    }
}

/// How one number is stored.
#[derive(Debug, Clone, Copy)]
struct Component {
    size: usize,
    signed: bool,
    float: bool,
    /// What stands for 1.
    one: f64,
}

impl Component {
    /// By glTF's number of the type.
    fn of(kind: u32, normalized: bool) -> Option<Component> {
        let (size, signed, float) = match kind {
            5120 => (1, true, false),
            5121 => (1, false, false),
            5122 => (2, true, false),
            5123 => (2, false, false),
            5125 => (4, false, false),
            5126 => (4, true, true),
            _ => return None,
        };
        let bits = 8 * size - usize::from(signed);
        let one = if normalized && !float { ((1u64 << bits) - 1) as f64 } else { 1.0 };
        Some(Component { size, signed, float, one })
    }

    /// The number in `size` bytes, little-endian.
    fn read(self, bytes: &[u8]) -> f64 {
        let raw = bytes.iter().rev().fold(0u32, |raw, &byte| raw << 8 | u32::from(byte));
        if self.float {
            return f64::from(f32::from_bits(raw));
        }
        if !self.signed {
            return f64::from(raw) / self.one;
        }
        let unused = 32 - 8 * self.size as u32;
        (f64::from((raw << unused) as i32 >> unused) / self.one).max(if self.one > 1.0 {
            -1.0
        } else {
            f64::MIN
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_read_and_scaled() {
        let read = |kind, normalized, bytes: &[u8]| {
            Component::of(kind, normalized).expect("a type of number").read(bytes)
        };
        assert_eq!(read(5120, false, &[0x80]), -128.0);
        assert_eq!(read(5120, true, &[0x80]), -1.0);
        assert_eq!(read(5121, true, &[255]), 1.0);
        assert_eq!(read(5122, true, &[0xff, 0x7f]), 1.0);
        assert_eq!(read(5123, false, &[0xff, 0xff]), 65535.0);
        assert_eq!(read(5125, false, &[0, 0, 0, 0x80]), 2_147_483_648.0);
        assert_eq!(read(5126, false, &(-1.5f32).to_le_bytes()), -1.5);
        assert!(Component::of(5124, false).is_none());
    }
}
