//! Where light from all around does not come in: between fingers, and where they touch what they
//! hold.

/// Lines through a texel that are looked along, and how far, in texels.
const LINES: usize = 4;
const FAR: [f32; 2] = [2.5, 5.6];
/// How much nearer, or farther, in metres, what lies at a line's end counts at most.
const MOST: f32 = 0.03;
/// A hollow so deep, in metres, is as dark as one can be.
const DEEP: f32 = 0.008;

/// How much is kept away from each texel of a square of `side`, 0 to 255, by the inverses of their
/// distances in metres; 0 where there is nothing.
///
/// A texel lies in a hollow where both ends of a line through it are nearer to the camera, on the
/// mean: what is only slanted does not.
pub(super) fn shut(near: &[f32], side: usize) -> Vec<u8> {
    let lines: Vec<[isize; 2]> = (0..LINES)
        .flat_map(|line| {
            let (sin, cos) = libm::sincosf(line as f32 / LINES as f32 * std::f32::consts::PI);
            FAR.map(|far| [cos * far, sin * far].map(|v| libm::roundf(v) as isize))
        })
        .collect();
    let end = |x: isize, y: isize, away: f32| {
        let inside = |v: isize| usize::try_from(v).ok().filter(|v| *v < side);
        let near = inside(x).zip(inside(y)).map_or(0.0, |(x, y)| near[y * side + x]);
        if near > 0.0 { (away - near.recip()).clamp(-MOST, MOST) } else { -MOST }
    };
    let of = |(at, here): (usize, &f32)| {
        if *here <= 0.0 {
            return 0;
        }
        let (x, y, away) = ((at % side) as isize, (at / side) as isize, here.recip());
        let depth = |[dx, dy]: &[isize; 2]| 0.5 * (end(x + dx, y + dy, away) + end(x - dx, y - dy, away));
        let sum: f32 = lines.iter().map(|line| (depth(line) / DEEP).clamp(0.0, 1.0)).sum();
        (255.0 * (2.0 * sum / lines.len() as f32).min(1.0)) as u8
    };
    near.iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square whose distances are given by place.
    fn shut_by(distance: impl Fn(usize, usize) -> f32) -> Vec<u8> {
        let near: Vec<f32> = (0..32 * 32).map(|at| distance(at % 32, at / 32).recip()).collect();
        shut(&near, 32)
    }

    #[test]
    fn a_groove_is_dark_and_a_slope_is_not() {
        let groove = shut_by(|x, _| if x == 16 { 0.52 } else { 0.5 });
        assert!(groove[16 * 32 + 16] > 150 && groove[16 * 32 + 10] == 0, "{:?}", &groove[16 * 32..][..32]);
        let slope = shut_by(|x, y| 0.4 + 0.002 * (x + y) as f32);
        let inner = (6..26).map(|i| slope[i * 32 + i]).max();
        assert!(inner < Some(10), "{inner:?}");
        assert!(shut(&[0.0; 64], 8).iter().all(|shut| *shut == 0));
    }
}
