//! A rotation of six values: two columns, made orthonormal by Gram and Schmidt; the third is their
//! cross product (Zhou et al., "On the continuity of rotation representations", 2019).

/// Added to every squared length, so that columns of length 0 have a gradient too.
const EPSILON: f64 = 1e-12;

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a + factor * b`.
fn add(a: Vector, factor: f64, b: Vector) -> Vector {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

fn length(a: Vector) -> f64 {
    (dot(a, a) + EPSILON).sqrt()
}

/// The rotation matrix, row by row, of the six values of the rotation head.
pub fn rotation_of(values: [f32; 6]) -> [[f32; 3]; 3] {
    let Orthonormal { columns: [a, b, c], .. } = Orthonormal::new(values.map(f64::from));
    [0, 1, 2].map(|row| [a[row] as f32, b[row] as f32, c[row] as f32])
}

/// The three columns, with what the way back needs.
pub(crate) struct Orthonormal {
    pub(crate) columns: [Vector; 3],
    /// The second column as it came.
    second: Vector,
    /// The first column's length, and that of what is left of the second.
    lengths: [f64; 2],
}

impl Orthonormal {
    pub(crate) fn new([ax, ay, az, bx, by, bz]: [f64; 6]) -> Self {
        let (first, second) = ([ax, ay, az], [bx, by, bz]);
        let lengths_a = length(first);
        let a = first.map(|v| v / lengths_a);
        let rest = add(second, -dot(a, second), a);
        let lengths_b = length(rest);
        let b = rest.map(|v| v / lengths_b);
        Self { columns: [a, b, cross(a, b)], second, lengths: [lengths_a, lengths_b] }
    }

    /// From the gradient with respect to the columns to that with respect to the six values.
    pub(crate) fn backward(&self, [of_a, of_b, of_c]: [Vector; 3]) -> [f64; 6] {
        let [a, b, _] = self.columns;
        let of_a = add(of_a, 1.0, cross(b, of_c));
        let of_b = add(of_b, 1.0, cross(of_c, a));
        let of_rest = add(of_b, -dot(b, of_b), b).map(|v| v / self.lengths[1]);
        let of_second = add(of_rest, -dot(a, of_rest), a);
        let of_a = add(add(of_a, -dot(a, self.second), of_rest), -dot(a, of_rest), self.second);
        let of_first = add(of_a, -dot(a, of_a), a).map(|v| v / self.lengths[0]);
        let [ax, ay, az] = of_first;
        let [bx, by, bz] = of_second;
        [ax, ay, az, bx, by, bz]
    }
}
