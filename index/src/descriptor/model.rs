//! All that it takes to describe a hand image.

use super::planes::{PLANES, PLANES_SIDE};
use super::{DescriptorKind, DescriptorParams, ParamsError};
use grasp_network::Network;
use std::sync::Arc;

/// Parameters of a descriptor and, where it is learned, the network that computes it: describers
/// are made of it, one a thread. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct DescriptorModel {
    params: DescriptorParams,
    network: Option<Arc<Network>>,
}

impl DescriptorModel {
    /// A descriptor that parameters alone determine.
    ///
    /// # Errors
    /// [`ParamsError`], where they are out of range or those of a learned descriptor, for which
    /// there is [`Self::learned`].
    pub fn new(params: DescriptorParams) -> Result<Self, ParamsError> {
        params.validate()?;
        match params.kind {
            DescriptorKind::Learned { network, .. } => Err(ParamsError::Network(network)),
            _ => Ok(Self { params, network: None }),
        }
    }

    /// The descriptor that a network computes.
    ///
    /// # Errors
    /// [`ParamsError::Input`], where the network takes other pictures than
    /// [`planes`](super::planes()) makes.
    pub fn learned(network: Arc<Network>) -> Result<Self, ParamsError> {
        let (side, planes) = (network.architecture().side, network.architecture().planes);
        if (side as usize, planes as usize) != (PLANES_SIDE, PLANES) {
            return Err(ParamsError::Input { side, planes });
        }
        Ok(Self { params: DescriptorParams::learned(&network), network: Some(network) })
    }

    /// What an open index has: both were checked together.
    pub(crate) fn of_index(params: DescriptorParams, network: Option<Arc<Network>>) -> Self {
        Self { params, network }
    }

    /// The parameters.
    pub fn params(&self) -> &DescriptorParams {
        &self.params
    }

    /// The network of a learned descriptor.
    pub fn network(&self) -> Option<&Arc<Network>> {
        self.network.as_ref()
    }
}
