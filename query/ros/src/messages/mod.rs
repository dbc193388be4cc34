//! ROS messages as their `.msg` files define them: the fields in their order, which is that of
//! their CDR encoding. What they mean is said there.
//!
//! They are those of ROS 2 Humble and later; `vision_msgs` is version 4, `moveit_msgs` version 2.

pub(crate) mod geometry;
pub(crate) mod moveit;
pub(crate) mod sensor;
pub(crate) mod standard;
pub(crate) mod vision;
pub(crate) mod visualization;

#[cfg(test)]
mod tests;

use ros2_client::MessageTypeName;

/// A message that has a topic of its own.
pub(crate) trait Message {
    /// Its package and its name there.
    const TYPE: (&'static str, &'static str);

    /// Its type as topics are declared with it.
    fn type_name() -> MessageTypeName {
        let (package, name) = Self::TYPE;
        MessageTypeName::new(package, name)
    }
}
