//! Colours as video has them: Y'CbCr of ITU-R BT.601.

use crate::size::check_size;

/// Which of their 256 values samples use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Range {
    /// 16 is black, 235 white.
    Limited,
    /// All of them.
    Full,
}

impl Range {
    /// Luma where black is 0 and white 255.
    pub(crate) fn brightness(self, y: u8) -> f32 {
        match self {
            Self::Full => f32::from(y),
            Self::Limited => (f32::from(y) - 16.0) * 255.0 / 219.0,
        }
    }

    /// Red, green and blue of luma and of the differences of blue and red.
    pub(crate) fn rgb(self, y: u8, difference: [u8; 2]) -> [u8; 3] {
        let scale = if self == Self::Full { 1.0 } else { 255.0 / 224.0 };
        let [cb, cr] = difference.map(|value| (f32::from(value) - 128.0) * scale);
        let y = self.brightness(y);
        // A conversion to an integer type saturates.
        [y + 1.402 * cr, y - 0.344_136 * cb - 0.714_136 * cr, y + 1.772 * cb].map(|value| value.round() as u8)
    }
}

/// A frame as most cameras give it uncompressed, YUYV (V4L2's `YUYV`, 4:2:2 packed, limited range),
/// as a binary PNM. `stride` are the bytes from one row to the next.
///
/// `None` where the rows do not hold `width` pixels, some are missing, or the frame is larger than
/// a picture may be. The last row may end with its last pixel.
pub fn yuyv_to_pnm(width: usize, height: usize, stride: usize, frame: &[u8]) -> Option<Vec<u8>> {
    let [columns, rows] = [width, height].map(|side| u32::try_from(side).ok());
    check_size(columns?, rows?).ok()?;
    let row_bytes = 4 * width.div_ceil(2);
    let needed = stride.checked_mul(height - 1)?.checked_add(row_bytes)?;
    if stride < row_bytes || frame.len() < needed {
        return None;
    }
    let mut pnm = format!("P6\n{width} {height}\n255\n").into_bytes();
    pnm.reserve_exact(3 * width * height);
    for row in frame.chunks(stride).take(height) {
        let end = pnm.len() + 3 * width;
        for &[first, cb, second, cr] in row[..row_bytes].as_chunks().0 {
            for luma in [first, second] {
                pnm.extend(Range::Limited.rgb(luma, [cb, cr]));
            }
        }
        // The second half of an odd row's last pair is no pixel.
        pnm.truncate(end);
    }
    Some(pnm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_pairs_become_pixels() {
        // Black and white, then red and its half of an odd row; six bytes behind each row.
        let row = [16, 128, 235, 128, 81, 90, 81, 240, 9, 9, 9, 9, 9, 9];
        let frame = [row, row].concat();
        let pnm = yuyv_to_pnm(3, 2, 14, &frame[..22]).unwrap();
        let (head, pixels) = pnm.split_at(pnm.len() - 18);
        assert_eq!(head, b"P6\n3 2\n255\n");
        assert_eq!(pixels[..6], [0, 0, 0, 255, 255, 255]);
        assert!(pixels[6] > 250 && pixels[7] < 5 && pixels[8] < 5, "{pixels:?}");
        assert_eq!(pixels[..9], pixels[9..]);
    }

    #[test]
    fn frames_that_are_too_short_are_none() {
        assert!(yuyv_to_pnm(4, 2, 8, &[0; 16]).is_some());
        assert!(yuyv_to_pnm(4, 2, 8, &[0; 15]).is_none());
        assert!(yuyv_to_pnm(4, 2, 6, &[0; 16]).is_none(), "rows that overlap");
        assert!(yuyv_to_pnm(0, 2, 8, &[0; 16]).is_none());
        assert!(yuyv_to_pnm(usize::MAX, 2, usize::MAX, &[0; 16]).is_none());
        assert!(yuyv_to_pnm(4, 2, usize::MAX, &[0; 16]).is_none());
    }
}
