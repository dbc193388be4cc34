//! The human baseline of the paper's Section VII: a person is shown the hand images H, one by one
//! and in random order, and names the grasp of each, as the program does.
//!
//! [`pictures`] makes what is shown, [`answers`] keeps what the person says, [`Quiz`] knows whose
//! turn it is, [`server`] is the page's other end, and [`result`] scores both. Until the last
//! picture is answered nothing that leaves this program tells a label: a picture's address is its
//! place in the random order.

pub mod answers;
mod choices;
pub mod pictures;
pub mod result;
pub mod server;

use std::collections::HashMap;

use serde::Serialize;

use answers::{AnswerError, AnswerFile};
pub use choices::{CHOICES, Choice};
use pictures::Shown;
use result::QuizResult;

/// A quiz under way.
#[derive(Debug)]
pub struct Quiz {
    /// Those that were answered already, then the others in their random order.
    pictures: Vec<Shown>,
    /// Places in [`CHOICES`], of the first so many pictures.
    given: Vec<usize>,
    answers: AnswerFile,
    seed: u64,
    finished: bool,
}

/// Where the quiz is: what the page is told.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct State {
    /// Pictures.
    pub total: usize,
    /// Those that are answered; the next to answer has this number.
    pub answered: usize,
    /// What was answered last, as the number of a choice, 1 to 6.
    pub last: Option<usize>,
    /// What the order comes from.
    pub seed: u64,
    /// Whether the result was shown; nothing can be answered any more.
    pub finished: bool,
}

/// An answer that is not taken.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// There is no such picture.
    #[error("there is no picture {0}")]
    NoPicture(usize),
    /// There is no such choice.
    #[error("{0} is not an answer: it must be a number from 1 to {most}", most = CHOICES.len())]
    NoChoice(usize),
    /// Another picture is to be answered, or the last one again.
    #[error("picture {0} is not the one to answer now")]
    NotNow(usize),
    /// The result has been shown.
    #[error("the quiz is over: the result has been shown")]
    Over,
    /// Some pictures are not answered.
    #[error("{0} pictures are not answered yet")]
    Unfinished(usize),
    /// The answer could not be kept, and does not count.
    #[error(transparent)]
    NotKept(#[from] AnswerError),
}

impl Quiz {
    /// Goes on with a quiz over `pictures`, which are in their random order, where the file of
    /// answers leaves it. `before` is what [`AnswerFile::open`] found in it.
    pub fn new(
        mut pictures: Vec<Shown>,
        answers: AnswerFile,
        before: &HashMap<String, usize>,
        seed: u64,
    ) -> Self {
        // Stable: within either part the order stays.
        pictures.sort_by_key(|picture| !before.contains_key(&picture.file));
        let given = pictures.iter().map_while(|picture| before.get(&picture.file).copied()).collect();
        Self { pictures, given, answers, seed, finished: false }
    }

    /// Where the quiz is.
    pub fn state(&self) -> State {
        State {
            total: self.pictures.len(),
            answered: self.given.len(),
            last: self.given.last().map(|choice| choice + 1),
            seed: self.seed,
            finished: self.finished,
        }
    }

    /// The PNG of a picture.
    ///
    /// # Errors
    /// Where there is no such picture.
    pub fn picture(&self, number: usize) -> Result<Vec<u8>, Refused> {
        self.pictures.get(number).map(|picture| picture.png.clone()).ok_or(Refused::NoPicture(number))
    }

    /// Takes the answer, 1 to 6, to the next picture, or another one to the last; keeps it before
    /// it counts.
    ///
    /// # Errors
    /// [`Refused`]; the quiz is then as it was.
    pub fn answer(&mut self, number: usize, answer: usize) -> Result<State, Refused> {
        let picture = self.pictures.get(number).ok_or(Refused::NoPicture(number))?;
        let choice = answer.checked_sub(1).filter(|&at| at < CHOICES.len());
        let choice = choice.ok_or(Refused::NoChoice(answer))?;
        if self.finished {
            return Err(Refused::Over);
        }
        if number > self.given.len() || number + 1 < self.given.len() {
            return Err(Refused::NotNow(number));
        }
        self.answers.append(&picture.file, choice)?;
        self.given.truncate(number);
        self.given.push(choice);
        Ok(self.state())
    }

    /// Ends the quiz and tells the result.
    ///
    /// # Errors
    /// Where pictures are not answered yet: the result would tell what they show.
    pub fn finish(&mut self) -> Result<QuizResult, Refused> {
        match self.pictures.len() - self.given.len() {
            0 => {
                self.finished = true;
                Ok(self.result())
            }
            left => Err(Refused::Unfinished(left)),
        }
    }

    /// Whether every picture is answered.
    pub fn is_complete(&self) -> bool {
        self.given.len() == self.pictures.len()
    }

    /// The result over what is answered so far.
    pub fn result(&self) -> QuizResult {
        QuizResult::new(self.pictures.iter().zip(&self.given), self.pictures.len(), self.seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(file: &str, labelled: &str) -> Shown {
        Shown {
            file: file.into(),
            labelled: labelled.into(),
            stage: "grasp".into(),
            png: vec![1],
            machine: None,
        }
    }

    fn quiz(folder: &tempfile::TempDir) -> Quiz {
        let (answers, before) = AnswerFile::open(&folder.path().join("answers.csv")).unwrap();
        let pictures = vec![shown("a", "pinch"), shown("b", "pinch"), shown("c", "power-sphere")];
        Quiz::new(pictures, answers, &before, 7)
    }

    #[test]
    fn the_next_picture_is_answered_or_the_last_one_again() {
        let folder = tempfile::tempdir().unwrap();
        let mut quiz = quiz(&folder);
        assert!(matches!(quiz.answer(1, 4), Err(Refused::NotNow(1))));
        quiz.answer(0, 4).unwrap();
        quiz.answer(1, 4).unwrap();
        assert!(matches!(quiz.answer(0, 4), Err(Refused::NotNow(0))));
        let state = quiz.answer(1, 6).unwrap();
        assert_eq!((state.answered, state.last), (2, Some(6)));
        assert!(matches!(quiz.finish(), Err(Refused::Unfinished(1))));
        assert!(matches!(quiz.answer(3, 1), Err(Refused::NoPicture(3))));
        assert!(matches!(quiz.answer(2, 0), Err(Refused::NoChoice(0))));
        assert!(matches!(quiz.answer(2, 7), Err(Refused::NoChoice(7))));
        quiz.answer(2, 5).unwrap();
        let result = quiz.finish().unwrap();
        assert_eq!((result.n, result.person.share.right), (3, 2));
        assert!(matches!(quiz.answer(2, 1), Err(Refused::Over)));
    }

    #[test]
    fn a_quiz_goes_on_where_it_stopped_in_any_order() {
        let folder = tempfile::tempdir().unwrap();
        let mut first = quiz(&folder);
        first.answer(0, 4).unwrap();
        first.answer(0, 3).unwrap();
        first.answer(1, 4).unwrap();
        drop(first);
        let (answers, before) = AnswerFile::open(&folder.path().join("answers.csv")).unwrap();
        let pictures = vec![shown("c", "power-sphere"), shown("b", "pinch"), shown("a", "pinch")];
        let mut again = Quiz::new(pictures, answers, &before, 8);
        assert_eq!(again.state().answered, 2);
        assert_eq!(again.pictures.iter().map(|p| p.file.as_str()).collect::<String>(), "bac");
        assert_eq!(again.given, [3, 2]);
        again.answer(2, 5).unwrap();
        assert!(again.is_complete());
    }
}
