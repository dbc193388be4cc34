//! The sizes of the layers, and where each one's parameters lie.

use grasp_network::{Architecture, ArchitectureError, Layer};
use std::ops::Range;

/// Stages that the second head distinguishes.
pub const STAGES: usize = 3;
/// Values of the third head: the two columns that [`crate::rotation_of`] makes a rotation of.
pub const ROTATION: usize = 6;

/// Where the parameters and statistics of a normalised layer lie: a convolution or the embedding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// Inputs of one output value.
    pub(crate) taps: usize,
    /// Planes, each of which is normalised by itself.
    pub(crate) outputs: usize,
    /// `[taps][outputs]`, in the parameters.
    pub(crate) matrix: Range<usize>,
    /// `[outputs]`, in the parameters.
    pub(crate) scale: Range<usize>,
    /// `[outputs]`, in the parameters.
    pub(crate) shift: Range<usize>,
    /// `[outputs]`, in the statistics.
    pub(crate) mean: Range<usize>,
    /// `[outputs]`, in the statistics.
    pub(crate) variance: Range<usize>,
}

/// An architecture with everything that follows from it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Plan {
    pub(crate) architecture: Architecture,
    pub(crate) convolutions: Vec<Layer>,
    /// Values that enter the embedding.
    pub(crate) features: usize,
    /// The convolutions' in their order, then the embedding's.
    pub(crate) blocks: Vec<Block>,
    /// `[embedding][heads]`, in the parameters.
    pub(crate) heads_matrix: Range<usize>,
    /// `[heads]`, in the parameters.
    pub(crate) heads_bias: Range<usize>,
    /// Trained values.
    pub(crate) parameters: usize,
    /// Means and variances.
    pub(crate) statistics: usize,
}

impl Plan {
    pub(crate) fn new(architecture: &Architecture) -> Result<Self, ArchitectureError> {
        let heads = u64::from(architecture.heads);
        if heads < (2 + STAGES + ROTATION) as u64 {
            let (what, supported) = ("size of the heads", "11 and more can be trained");
            return Err(ArchitectureError { what, value: heads, supported });
        }
        let mut convolutions = architecture.layers()?;
        // The embedding and the heads, dense layers.
        let dense = convolutions.split_off(architecture.convolutions.len());
        let features = dense.first().map_or(0, Layer::inputs);
        let (embedding, heads) = (architecture.embedding as usize, architecture.heads as usize);

        let (mut parameters, mut statistics) = (Cursor(0), Cursor(0));
        let sizes = convolutions.iter().map(|layer| (layer.inputs(), layer.output_planes));
        let blocks = sizes
            .chain([(features, embedding)])
            .map(|(taps, outputs)| Block {
                taps,
                outputs,
                matrix: parameters.next(taps * outputs),
                scale: parameters.next(outputs),
                shift: parameters.next(outputs),
                mean: statistics.next(outputs),
                variance: statistics.next(outputs),
            })
            .collect();
        let heads_matrix = parameters.next(embedding * heads);
        let heads_bias = parameters.next(heads);
        Ok(Self {
            architecture: architecture.clone(),
            convolutions,
            features,
            blocks,
            heads_matrix,
            heads_bias,
            parameters: parameters.0,
            statistics: statistics.0,
        })
    }

    /// Values of one sample's input.
    pub(crate) fn inputs(&self) -> usize {
        (self.architecture.side * self.architecture.side * self.architecture.planes) as usize
    }

    pub(crate) fn embedding(&self) -> usize {
        self.architecture.embedding as usize
    }

    pub(crate) fn heads(&self) -> usize {
        self.architecture.heads as usize
    }

    /// Classes that the first head distinguishes.
    pub(crate) fn classes(&self) -> usize {
        self.heads() - STAGES - ROTATION
    }

    /// The parameters that weight decay applies to: kernels and matrices.
    pub(crate) fn decayed(&self) -> impl Iterator<Item = Range<usize>> {
        self.blocks.iter().map(|block| block.matrix.clone()).chain([self.heads_matrix.clone()])
    }
}

/// Hands out consecutive ranges.
struct Cursor(usize);

impl Cursor {
    fn next(&mut self, length: usize) -> Range<usize> {
        let start = self.0;
        self.0 += length;
        start..self.0
    }
}
