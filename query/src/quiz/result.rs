//! How the person did, and how the program did on the same pictures.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use grasp_terminal::text::counted;
use serde::Serialize;

use super::choices::CHOICES;
use super::pictures::Shown;
use crate::evaluate::confusion::{Confusion, Share};
use crate::experiment::paper::Published;

/// Both scores. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct QuizResult {
    /// Pictures that the person answered.
    pub n: usize,
    /// All pictures of the quiz.
    pub total: usize,
    /// What the order came from.
    pub seed: u64,
    /// The person.
    pub person: Score,
    /// The program, where there was an index.
    pub machine: Option<Score>,
    /// Pictures that both named alike, rightly or wrongly.
    pub alike: Option<Share>,
    /// What the paper reports of its own person and program.
    pub paper: Published,
}

/// One of the two.
#[derive(Clone, Debug, Serialize)]
pub struct Score {
    /// Pictures and right answers.
    pub share: Share,
    /// Where the true share lies, with 95 % confidence.
    pub interval: [f64; 2],
    /// The same by stage.
    pub per_stage: BTreeMap<String, Share>,
    /// Which class was taken for which.
    pub confusion: Confusion,
}

impl QuizResult {
    /// Sums up pictures with what the person said, as places in [`CHOICES`], of `total` pictures.
    pub fn new<'a>(given: impl Iterator<Item = (&'a Shown, &'a usize)>, total: usize, seed: u64) -> Self {
        let answered: Vec<(&Shown, Option<&str>)> =
            given.map(|(shown, choice)| (shown, CHOICES.get(*choice).map(|choice| choice.grasp))).collect();
        let machine: Vec<(&Shown, Option<&str>)> = answered
            .iter()
            .filter_map(|(shown, _)| Some((*shown, shown.machine.as_ref()?.as_deref())))
            .collect();
        // Either every picture was shown to the program or none.
        let has_machine = !machine.is_empty();
        let alike = answered.iter().zip(&machine).filter(|(person, machine)| person.1 == machine.1).count();
        Self {
            n: answered.len(),
            total,
            seed,
            person: Score::new(&answered),
            machine: has_machine.then(|| Score::new(&machine)),
            alike: has_machine.then_some(Share { n: machine.len(), right: alike }),
            paper: Published::all(),
        }
    }

    /// The table for a person.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = self.write_text(&mut text);
        text
    }

    fn write_text(&self, text: &mut String) -> std::fmt::Result {
        let pictures = counted(self.total, ["picture", "pictures"]);
        writeln!(text, "{} of {pictures} answered (seed {})", self.n, self.seed)?;
        if self.n == 0 {
            return Ok(());
        }
        for (name, score) in [("person", Some(&self.person)), ("machine", self.machine.as_ref())] {
            let Some(score) = score else { continue };
            let [low, high] = score.interval.map(|bound| 100.0 * bound);
            write!(
                text,
                "{name:<8} {:>5.1} % right ({low:.0}..{high:.0} with 95 % confidence)",
                100.0 * score.share.top1()
            )?;
            for (stage, share) in &score.per_stage {
                write!(text, "  {stage} {:.0} % of {}", 100.0 * share.top1(), share.n)?;
            }
            writeln!(text)?;
        }
        if let Some(alike) = self.alike {
            writeln!(text, "both named {:.1} % alike", 100.0 * alike.top1())?;
        }
        let percent = |share: Share| 100.0 * share.top1();
        if let Some(human) = self.paper.human_top1 {
            writeln!(
                text,
                "in the paper, of its own 36 pictures: person {:.0} %, machine {:.0} %",
                percent(human),
                percent(self.paper.top1)
            )?;
        }
        for (name, score) in [("person", Some(&self.person)), ("machine", self.machine.as_ref())] {
            if let Some(score) = score {
                writeln!(text, "\n{name} (rows: labelled; columns: answered)")?;
                score.confusion.write_text(text)?;
            }
        }
        Ok(())
    }
}

impl Score {
    fn new(answers: &[(&Shown, Option<&str>)]) -> Self {
        let mut confusion = Confusion::new(CHOICES.iter().map(|choice| choice.grasp.to_owned()).collect());
        let mut per_stage: BTreeMap<String, Share> = BTreeMap::new();
        for (shown, answer) in answers {
            confusion.add(&shown.labelled, *answer);
            if !shown.stage.is_empty() {
                let share = per_stage.entry(shown.stage.clone()).or_default();
                share.n += 1;
                share.right += usize::from(*answer == Some(shown.labelled.as_str()));
            }
        }
        let share = confusion.share();
        Self { share, interval: share.interval(), per_stage, confusion }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn person_and_machine_are_scored_on_the_same_pictures() {
        let shown = |labelled: &str, machine: Option<&str>| Shown {
            file: "a.png".into(),
            labelled: labelled.into(),
            stage: "reach".into(),
            png: Vec::new(),
            machine: Some(machine.map(str::to_owned)),
        };
        let pictures =
            [shown("pinch", Some("pinch")), shown("pinch", None), shown("power-sphere", Some("pinch"))];
        let result = QuizResult::new(pictures.iter().zip(&[3, 3, 3]), 5, 7);
        assert_eq!(result.person.share, Share { n: 3, right: 2 });
        assert_eq!(result.machine.as_ref().unwrap().share, Share { n: 3, right: 1 });
        assert_eq!(result.alike, Some(Share { n: 3, right: 2 }));
        let text = result.text();
        assert!(text.contains("3 of 5 pictures answered") && text.contains("person 61 %"), "{text}");
        let nothing = QuizResult::new([].into_iter(), 5, 7);
        assert!(nothing.machine.is_none() && nothing.text().starts_with("0 of 5"));
    }
}
