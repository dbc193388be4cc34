//! One number for all of a hand that decides how its trials end.

use std::collections::BTreeMap;

use grasp_canonical::{Canonical, Encoder};

use super::hand::{RobotGrasp, RobotHand, Travel, Value};

impl RobotHand {
    /// A number that differs where two hands do, but for the windows that were measured with them,
    /// what is only drawn or said, and the widest object: a wider one is not tried at all.
    pub fn fingerprint(&self) -> u64 {
        Encoder::new().value(self).hash()
    }
}

impl Canonical for RobotHand {
    fn encode(&self, to: &mut Encoder) {
        let Self {
            name,
            about: _,
            model,
            wrist_link,
            wrist_from_palm,
            wrist_from_palm_xyzw,
            palm_radius,
            palm_height,
            finger: _,
            chain: _,
            touch_links,
            max_contact_force,
            approach,
            retreat,
            limits,
            map,
            instead: _,
            grasp,
        } = self;
        to.text(name).u8(u8::from(model.is_some())).text(model.as_deref().unwrap_or_default());
        to.text(wrist_link).f64s(wrist_from_palm).f64(*palm_radius).count(touch_links.len());
        for link in touch_links {
            to.text(link);
        }
        to.f64(*max_contact_force).value(approach).value(retreat);
        encode_map(to, limits, |to, [least, most]| {
            to.f64(*least).f64(*most);
        });
        encode_map(to, map, |to, grasp| {
            to.text(grasp);
        });
        encode_map(to, grasp, |to, grasp| grasp.encode(to));
        // At the end, and only where they are there: hands without them keep their numbers.
        if let Some(xyzw) = wrist_from_palm_xyzw {
            to.u8(1).f64s(xyzw);
        }
        if let Some(height) = palm_height {
            to.u8(2).f64(*height);
        }
    }
}

impl Canonical for RobotGrasp {
    fn encode(&self, to: &mut Encoder) {
        let Self {
            about: _,
            standoff,
            middle,
            table_clearance,
            table_reach,
            widest: _,
            breakaway,
            open,
            closed,
            window: _,
        } = self;
        to.value(standoff).value(middle).f64(*table_clearance).f64(*table_reach);
        // Where the widest object once stood, of hands that had none.
        to.option(None::<&f64>);
        to.u8(u8::from(*breakaway));
        for posture in [open, closed] {
            encode_map(to, posture, |to, value| value.encode(to));
        }
    }
}

impl Canonical for Travel {
    fn encode(&self, to: &mut Encoder) {
        let Self { distance, least } = *self;
        to.f64(distance).f64(least);
    }
}

impl Canonical for Value {
    fn encode(&self, to: &mut Encoder) {
        match self {
            Self::Fixed(value) => to.u8(0).f64(*value),
            Self::ByWidth(points) => to.u8(1).count(points.len()).f64s(points.as_flattened()),
        };
    }
}

/// Appends a map: its length, and each key with its value in the order of the keys.
fn encode_map<T>(to: &mut Encoder, map: &BTreeMap<String, T>, encode: impl Fn(&mut Encoder, &T)) {
    to.count(map.len());
    for (key, value) in map {
        encode(to.text(key), value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_decides_no_trial_changes_no_fingerprint() {
        let hand = RobotHand::built_in("barrett").unwrap();
        let mut other = hand.clone();
        other.about.push('!');
        other.finger.clear();
        other.grasp.values_mut().for_each(|grasp| {
            grasp.window.clear();
            grasp.widest = None;
        });
        assert_eq!(other.fingerprint(), hand.fingerprint());
        other.palm_radius += 1e-3;
        assert_ne!(other.fingerprint(), hand.fingerprint());
    }

    #[test]
    fn the_encoding_is_pinned() {
        let text = r#"
            name = "two"
            about = "a gripper for this test"
            wrist_link = "wrist"
            wrist_from_palm = [0.0, 0.0, -0.1]
            touch_links = ["left", "right"]
            max_contact_force = 20.0
            approach = { distance = 0.1, least = 0.05 }
            retreat = { distance = 0.2, least = 0.1 }
            limits = { jaw = [0.0, 0.08] }
            map = { pinch = "squeeze" }

            [grasp.squeeze]
            about = "a squeeze"
            standoff = 0.02
            table_clearance = 0.01
            open = { jaw = 0.08 }
            closed = { jaw = [[0.01, 0.005], [0.08, 0.07]] }
        "#;
        let hand: RobotHand = toml::from_str(text).unwrap();
        assert_eq!(format!("{:016x}", hand.fingerprint()), "040df8b136bafcd5");
    }
}
