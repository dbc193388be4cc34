//! The sizes of the layers, and where each one's parameters lie.

use crate::affine::Affine;
use crate::dense::DenseShape;
use grasp_network::{Architecture, ArchitectureError, Layer, Masks};
use std::ops::Range;

/// Stages that the second head distinguishes.
pub const STAGES: usize = 3;
/// Values of the third head: the two columns that [`crate::rotation_of`] makes a rotation of.
pub const ROTATION: usize = 6;

/// Joints whose places can be learned.
const MOST_JOINTS: usize = 256;

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

/// The masks: a dense layer at each pixel of a convolution's output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MaskPlan {
    pub(crate) masks: Masks,
    /// The convolution, counted from 0.
    pub(crate) convolution: usize,
    /// Pixels a side of the convolution's output.
    pub(crate) side: usize,
    pub(crate) layer: Affine,
}

impl MaskPlan {
    /// Values of one sample's masks.
    pub(crate) fn values(&self) -> usize {
        self.side * self.side * self.layer.shape.outputs
    }
}

/// How parameters are moved in training.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Treatment {
    /// Each by itself, and with weight decay or without.
    Plain {
        /// Whether weight decay applies.
        is_decayed: bool,
    },
    /// As a matrix whose rows have so many columns.
    Matrix {
        /// Values of a row.
        columns: usize,
    },
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
    pub(crate) head: Affine,
    pub(crate) masks: Option<MaskPlan>,
    /// Three values a joint, off the embedding; trained by, and no part of the network.
    pub(crate) joints: Option<Affine>,
    /// Trained values.
    pub(crate) parameters: usize,
    /// Means and variances.
    pub(crate) statistics: usize,
}

impl Plan {
    pub(crate) fn new(architecture: &Architecture, joints: usize) -> Result<Self, ArchitectureError> {
        let heads = u64::from(architecture.heads);
        if heads < (2 + STAGES + ROTATION) as u64 {
            let (what, supported) = ("size of the heads", "11 and more can be trained");
            return Err(ArchitectureError { what, value: heads, supported });
        }
        if joints > MOST_JOINTS {
            let supported = "at most 256 are supported";
            return Err(ArchitectureError { what: "number of joints", value: joints as u64, supported });
        }
        let mut convolutions = architecture.layers()?;
        // The embedding, the heads and the masks.
        let others = convolutions.split_off(architecture.convolutions.len());
        let features = others.first().map_or(0, Layer::inputs);
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
        let mut affine = |inputs, outputs| Affine {
            shape: DenseShape { inputs, outputs },
            matrix: parameters.next(inputs * outputs),
            bias: parameters.next(outputs),
        };
        let head = affine(embedding, heads);
        let masks = architecture.masks.zip(others.get(2)).map(|(masks, layer)| MaskPlan {
            masks,
            convolution: masks.convolution as usize,
            side: layer.output_side,
            layer: affine(layer.inputs(), layer.output_planes),
        });
        let joints = (joints > 0).then(|| affine(embedding, 3 * joints));
        Ok(Self {
            architecture: architecture.clone(),
            convolutions,
            features,
            blocks,
            head,
            masks,
            joints,
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

    /// Values of one sample's masks; 0 without any.
    pub(crate) fn mask_values(&self) -> usize {
        self.masks.as_ref().map_or(0, MaskPlan::values)
    }

    /// Joints whose places are learned.
    pub(crate) fn joints(&self) -> usize {
        self.joints.as_ref().map_or(0, |layer| layer.shape.outputs / 3)
    }

    /// The masks, where they are read from this convolution.
    pub(crate) fn masks_of(&self, convolution: usize) -> Option<&MaskPlan> {
        self.masks.as_ref().filter(|masks| masks.convolution == convolution)
    }

    /// Classes that the first head distinguishes.
    pub(crate) fn classes(&self) -> usize {
        self.heads() - STAGES - ROTATION
    }

    /// How the parameters are moved in training, in their order: so many in this way.
    pub(crate) fn treatments(&self) -> Vec<(usize, Treatment)> {
        let mut treatments = Vec::new();
        let mut next = |range: &Range<usize>, treatment| treatments.push((range.len(), treatment));
        for (at, block) in self.blocks.iter().enumerate() {
            // Of few inputs, as the first layer has, nothing is gained by orthogonal steps.
            let treatment = match at {
                0 => Treatment::Plain { is_decayed: true },
                _ => Treatment::Matrix { columns: block.outputs },
            };
            next(&block.matrix, treatment);
            next(&block.scale, Treatment::Plain { is_decayed: false });
            next(&block.shift, Treatment::Plain { is_decayed: false });
        }
        let masks = self.masks.as_ref().map(|masks| &masks.layer);
        for layer in std::iter::once(&self.head).chain(masks).chain(&self.joints) {
            next(&layer.matrix, Treatment::Plain { is_decayed: true });
            next(&layer.bias, Treatment::Plain { is_decayed: false });
        }
        treatments
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
