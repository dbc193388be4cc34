//! [`Index::vote`]: reads what the index holds of the neighbours, and has [`crate::vote`] count it.

use crate::descriptor::NETWORK_STAGES;
use crate::index::Index;
use crate::rotation::turned_orientation;
use crate::search::Neighbour;
use crate::vote::{self, Ballot, ClassScore, Joined, Look, Vote, VoteOptions};

/// Cutkosky's numbers of the grasps that networks are trained on, in the order of their heads.
const NETWORK_CLASSES: [u8; 6] = [1, 2, 4, 9, 10, 12];

impl Index {
    /// What the neighbours say. Neighbours that are not in the index, or whose entry makes no
    /// sense, have no vote.
    pub fn vote(&self, neighbours: &[Neighbour], options: &VoteOptions) -> Vote {
        self.vote_of_looks(&[Look { neighbours, opinion: None, turn_deg: 0.0 }], options)
    }

    /// What the neighbours of several looks at one picture say together, and the opinions of the
    /// network that looked, for the class and for the orientation, to which all neighbours of the
    /// first class contribute. Opinions count where the index has the classes that networks are
    /// trained on, Cutkosky's 1, 2, 4, 9, 10 and 12.
    pub fn vote_of_looks(&self, looks: &[Look<'_>], options: &VoteOptions) -> Vote {
        let (catalogue, sigma) = (self.catalogue(), self.width(options));
        let count = catalogue.classes.len();
        let trained_on = catalogue.classes.iter().map(|class| class.cutkosky).eq(NETWORK_CLASSES);
        let has_opinions = trained_on && !options.has_own_width();
        let each = 1.0 / looks.len().max(1) as f64;
        let (mut shares, mut joined) = (vec![0.0; count], Joined::new(count));
        let (mut kernel_mass, mut ballots, mut stages) = (0.0, Vec::new(), None);
        let mut rotations = Vec::new();
        for look in looks {
            let own: Vec<Ballot> = look.neighbours.iter().filter_map(|n| self.ballot(n)).collect();
            let voters = own.iter().map(|ballot| (ballot.class, ballot.distance));
            let of_look = vote::shares(voters, count, sigma);
            // Another width than the calibrated one makes other shares.
            let probable = match options.has_own_width() {
                true => of_look.clone(),
                false => catalogue.calibration.probabilities(&of_look),
            };
            let opinion = look.opinion.filter(|opinion| has_opinions && opinion.classes.len() == count);
            joined.add(&probable, opinion.map(|opinion| opinion.classes.as_slice()));
            if let Some(opinion) = opinion {
                let stages = stages.get_or_insert([0.0; NETWORK_STAGES.len()]);
                stages.iter_mut().zip(opinion.stages).for_each(|(sum, own)| *sum += each * own);
                let rotation = opinion.rotation.iter();
                rotations.extend(rotation.map(|own| turned_orientation(-look.turn_deg, own)));
            }
            shares.iter_mut().zip(of_look).for_each(|(sum, share)| *sum += each * share);
            kernel_mass += each * vote::kernel_mass(own.iter().map(|ballot| ballot.distance), sigma);
            ballots.extend(own.into_iter().map(|ballot| ballot.turned(-look.turn_deg)));
        }
        let classes = self.scored(shares, joined.probabilities(!options.has_own_width()));
        let first = classes.first().map_or(0, |score| score.class);
        let orientation = vote::estimate(&ballots, &rotations, first, sigma, options.euler_mean);
        Vote { classes, stages, kernel_mass, orientation }
    }

    /// The width of the kernel that neighbours are weighed by.
    fn width(&self, options: &VoteOptions) -> f64 {
        let catalogue = self.catalogue();
        match (options.sigma, options.sigma_scale) {
            (Some(sigma), _) => sigma,
            (None, Some(scale)) => scale * catalogue.sigma.mean_distance,
            (None, None) if options.literal_sigma => catalogue.sigma.literal,
            (None, None) => catalogue.calibration.sigma_scale * catalogue.sigma.mean_distance,
        }
    }

    /// The classes with their shares and probabilities, the most probable first.
    fn scored(&self, shares: Vec<f64>, probabilities: Vec<f64>) -> Vec<ClassScore> {
        let classes = (0..=u16::MAX).zip(&self.catalogue().classes);
        let scores = classes.zip(shares.into_iter().zip(probabilities));
        let mut classes: Vec<ClassScore> = scores
            .map(|((class, info), (share, probability))| ClassScore {
                class,
                name: info.name.clone(),
                cutkosky: info.cutkosky,
                probability,
                share,
            })
            .collect();
        ClassScore::rank(&mut classes);
        classes
    }

    fn ballot(&self, neighbour: &Neighbour) -> Option<Ballot> {
        let class = *self.labels().get(neighbour.id as usize)?;
        let orientation = match self.catalogue().kept.orientations {
            true => Some(self.orientation(neighbour.id)?),
            false => None,
        };
        let distance = f64::from(neighbour.distance);
        let counts = (class as usize) < self.catalogue().classes.len() && distance.is_finite();
        counts.then_some(Ballot { class, distance, orientation })
    }
}
