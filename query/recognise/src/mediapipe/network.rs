//! One network, run by the crate `rten`.

use std::fmt::Display;
use std::sync::Arc;

use rten::{Dimension, Model, NodeId, RunOptions, ThreadPool, ValueOrView, ValueView};
use thiserror::Error;

/// What is wrong with a network.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum NetworkFault {
    /// It is no network that can be read; what `rten` says.
    #[error("it is no whole ONNX file: {0}")]
    Unreadable(String),
    /// It has not one input, but so many.
    #[error("it has {0} inputs, one is expected")]
    Inputs(usize),
    /// It takes something else than squares of this many pixels.
    #[error("it takes {found}, {expected:?} are expected")]
    Input {
        /// The input's shape, as a person reads it.
        found: String,
        /// One picture's rows, columns and colours.
        expected: [usize; 4],
    },
    /// It answers with something else.
    #[error("it answers with {found:?} values, {expected:?} are expected")]
    Answers {
        /// How many values each of its answers has.
        found: Vec<usize>,
        /// How many they should have.
        expected: Vec<usize>,
    },
    /// It answers with other numbers.
    #[error("it answers with integers, not with fractions")]
    Integers,
    /// It cannot be computed; what `rten` says.
    #[error("it cannot be computed: {0}")]
    Uncomputable(String),
}

/// A network that takes a square of colours.
pub(super) struct Network {
    model: Model,
    input: NodeId,
    outputs: Vec<NodeId>,
    side: usize,
    threads: Arc<ThreadPool>,
}

impl Network {
    /// Reads an ONNX file that takes `side` by `side` pixels and answers with values of these
    /// numbers, in this order, and is computed by these threads. It is run once: a file that cannot
    /// be is found out here.
    ///
    /// # Errors
    /// Where it is no such network.
    pub(super) fn from_onnx(
        bytes: Vec<u8>,
        side: usize,
        sizes: &[usize],
        threads: &Arc<ThreadPool>,
    ) -> Result<Self, NetworkFault> {
        let model = Model::load(bytes).map_err(|error| NetworkFault::Unreadable(error.to_string()))?;
        let outputs = model.output_ids().to_vec();
        let &[input] = model.input_ids() else {
            return Err(NetworkFault::Inputs(model.input_ids().len()));
        };
        let expected = [1, side, side, 3];
        let found = model.input_shape(0).unwrap_or_default();
        if !found.iter().eq(expected.map(Dimension::Fixed).iter()) {
            return Err(NetworkFault::Input { found: shape(&found), expected });
        }
        let network = Self { model, input, outputs, side, threads: Arc::clone(threads) };
        let answer = network.run(&vec![0.0; 3 * side * side])?;
        let found: Vec<usize> = answer.iter().map(Vec::len).collect();
        if found == sizes {
            Ok(network)
        } else {
            Err(NetworkFault::Answers { found, expected: sizes.to_vec() })
        }
    }

    /// What it answers to `side` by `side` pixels of red, green and blue, 0 to 1, row by row.
    ///
    /// # Errors
    /// Where it cannot be computed.
    pub(super) fn run(&self, pixels: &[f32]) -> Result<Vec<Vec<f32>>, NetworkFault> {
        let uncomputable = |error: &dyn Display| NetworkFault::Uncomputable(error.to_string());
        let shape = [1, self.side, self.side, 3];
        let input = ValueView::from_shape(shape, pixels).map_err(|error| uncomputable(&error))?;
        let inputs = vec![(self.input, ValueOrView::from(input))];
        let options = RunOptions::default().with_thread_pool(Some(Arc::clone(&self.threads)));
        let answer = self.model.run(inputs, &self.outputs, Some(options));
        let answer = answer.map_err(|error| uncomputable(&error))?;
        let values = answer.into_iter().map(|value| {
            let tensor = value.into_tensor::<f32>().ok_or(NetworkFault::Integers)?;
            Ok(tensor.into_data())
        });
        values.collect()
    }
}

/// A shape as a person reads it.
fn shape(dimensions: &[Dimension]) -> String {
    let sides: Vec<String> = dimensions
        .iter()
        .map(|dimension| match dimension {
            Dimension::Fixed(size) => size.to_string(),
            Dimension::Symbolic(name) => name.clone(),
        })
        .collect();
    format!("[{}]", sides.join(", "))
}
