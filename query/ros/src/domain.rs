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
    /// Reads ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE and ROS_LOCALHOST_ONLY by `variable`. As
    /// in `rcl`, ROS_LOCALHOST_ONLY=1 goes before the range.
    ///
    /// # Errors
    /// Where a variable has no value that it can have, or the range is OFF: a node that finds
    /// nobody sees no picture.
    pub(crate) fn from_environment(variable: impl Fn(&str) -> Option<String>) -> anyhow::Result<Self> {
        let named = variable("ROS_DOMAIN_ID").filter(|number| !number.is_empty());
        let id = match named.map(|number| number.parse::<u16>()) {
            None => 0,
            Some(Ok(id)) if id <= LAST => id,
            Some(_) => bail!("ROS_DOMAIN_ID must be a number from 0 to {LAST}"),
        };
        if variable("ROS_LOCALHOST_ONLY").as_deref() == Some("1") {
            return Ok(Self { id, is_local: true });
        }
        let range = variable("ROS_AUTOMATIC_DISCOVERY_RANGE").unwrap_or_default();
        let is_local = match range.to_ascii_uppercase().as_str() {
            "LOCALHOST" => true,
            "" | "SUBNET" | "SYSTEM_DEFAULT" => false,
            "OFF" => bail!(
                "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF: a node that finds nobody sees no picture; set LOCALHOST or SUBNET"
            ),
            _ => bail!(
                "ROS_AUTOMATIC_DISCOVERY_RANGE is {range}: SUBNET, LOCALHOST, SYSTEM_DEFAULT or OFF is needed"
            ),
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
        assert!(of(&both).unwrap().is_local);
        let range = |range| of(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", range)]);
        assert!(range("LOCALHOST").unwrap().is_local && range("localhost").unwrap().is_local);
        assert!(!range("SUBNET").unwrap().is_local && !range("").unwrap().is_local);
        assert!(range("OFF").is_err() && range("EVERYWHERE").is_err());
        for number in ["233", "-1", "one"] {
            assert!(of(&[("ROS_DOMAIN_ID", number)]).is_err(), "{number}");
        }
    }
}
