//! Where in the network the node is: as the environment says, as for any node of ROS.

use std::net::Ipv4Addr;

use anyhow::bail;
use ros2_client::dds::rustdds::{DomainParticipant, DomainParticipantBuilder};

/// What the environment says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Domain {
    /// Its number, 0 to 232.
    id: u16,
    /// Only this machine is spoken to.
    is_local: bool,
}

impl Domain {
    /// Reads ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE and ROS_LOCALHOST_ONLY by `variable`.
    ///
    /// # Errors
    /// Where the number is none, or there is no such domain.
    pub(crate) fn from_environment(variable: impl Fn(&str) -> Option<String>) -> anyhow::Result<Self> {
        let named = variable("ROS_DOMAIN_ID").filter(|number| !number.is_empty());
        let id = match named.map(|number| number.parse::<u16>()) {
            None => 0,
            Some(Ok(id)) if id <= LAST => id,
            Some(_) => bail!("ROS_DOMAIN_ID must be a number from 0 to {LAST}"),
        };
        let range = variable("ROS_AUTOMATIC_DISCOVERY_RANGE");
        let is_local = match range.as_deref() {
            Some(range) => range.eq_ignore_ascii_case("LOCALHOST"),
            None => variable("ROS_LOCALHOST_ONLY").as_deref() == Some("1"),
        };
        Ok(Self { id, is_local })
    }

    /// Enters the domain.
    ///
    /// # Errors
    /// Where the network does not allow it.
    pub(crate) fn enter(self) -> anyhow::Result<DomainParticipant> {
        let builder = DomainParticipantBuilder::new(self.id);
        let builder = if self.is_local { builder.with_only_networks([Ipv4Addr::LOCALHOST]) } else { builder };
        builder
            .build()
            .map_err(|error| anyhow::anyhow!("cannot enter the domain {} (ROS_DOMAIN_ID): {error}", self.id))
    }

    /// Its number.
    pub(crate) fn id(self) -> u16 {
        self.id
    }
}

/// DDS derives ports from the number, and has no more of them.
const LAST: u16 = 232;

#[cfg(test)]
mod tests {
    use super::*;

    fn of(variables: &[(&str, &str)]) -> anyhow::Result<Domain> {
        Domain::from_environment(|name| {
            variables.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn the_domain_is_the_environments() {
        assert_eq!(of(&[]).unwrap(), Domain { id: 0, is_local: false });
        let local = [("ROS_DOMAIN_ID", "42"), ("ROS_LOCALHOST_ONLY", "1")];
        assert_eq!(of(&local).unwrap(), Domain { id: 42, is_local: true });
        let both = [("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"), ("ROS_LOCALHOST_ONLY", "1")];
        assert!(!of(&both).unwrap().is_local);
        assert!(of(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")]).unwrap().is_local);
        for number in ["233", "-1", "one"] {
            assert!(of(&[("ROS_DOMAIN_ID", number)]).is_err(), "{number}");
        }
    }
}
