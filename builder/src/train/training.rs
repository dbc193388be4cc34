//! A training: its state, and what one round does to it.

use anyhow::{Context as _, bail, ensure};
use grasp_network::Network;
use grasp_terminal::Work;
use grasp_train::{Batch, Trainer, learning_rate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::check::Check;
use super::checkpoint::State;
use super::course::{Course, Lesson, Showing};
use super::curve::{MeanLosses, Row};
use super::figures::Figure;
use super::window::{Window, render_all};
use super::{Options, Schedule, joints};

/// Batches that show what values the layers of a network have that a training begins with.
const BATCHES_AT_START: u64 = 8;

/// A training that goes on where its state says.
pub(super) struct Training<C: Course> {
    options: Options,
    schedule: Schedule,
    course: C,
    window: Window<C::Render>,
    state: State,
}

impl<C: Course> Training<C> {
    /// Goes on from a checkpoint, or begins.
    pub(super) fn new(
        options: &Options,
        schedule: Schedule,
        start: Option<&Network>,
        saved: Option<State>,
        check: Check<'_>,
    ) -> anyhow::Result<Self> {
        let course = C::new(options);
        let architecture = course.architecture();
        let begin = |trainer| State { trainer, curve: Vec::new(), losses: MeanLosses::default() };
        let state = match (saved, start) {
            (Some(state), _) => state,
            (None, Some(start)) => begin(warm_start(options, &schedule, &course, start, check)?),
            (None, None) => {
                let trainer = Trainer::new(&architecture, joints::COUNT, options.seed_of_weights())?;
                begin(trainer.with_optimiser(options.optimiser.into()))
            }
        };
        ensure!(
            *state.trainer.architecture() == architecture && state.trainer.joints() == joints::COUNT,
            "the checkpoint is of another network: remove it to begin again"
        );
        Ok(Self { options: options.clone(), window: Window::new(schedule.window), schedule, course, state })
    }

    pub(super) fn course(&self) -> &C {
        &self.course
    }

    pub(super) fn state(&self) -> &State {
        &self.state
    }

    pub(super) fn is_done(&self) -> bool {
        self.state.trainer.steps() >= self.steps()
    }

    /// Samples shown so far.
    pub(super) fn samples(&self) -> u64 {
        self.schedule.samples(self.state.trainer.steps())
    }

    /// How many scenes [`Self::fill`] renders.
    pub(super) fn scenes_at_start(&self) -> u64 {
        let parts = self.schedule.parts(self.round());
        (parts.end - parts.start) * self.schedule.scenes
    }

    /// Renders what is in the window at the next step.
    pub(super) fn fill(&mut self, check: Check<'_>, work: &Work) -> anyhow::Result<()> {
        for part in self.schedule.parts(self.round()) {
            let part = render_part(&self.course, &self.schedule, part, check)?;
            self.window.advance(part);
            work.inc(self.schedule.scenes);
        }
        Ok(())
    }

    /// Does the steps that are left of a round, and renders the part that comes in after it. Where
    /// the work is stopped, the steps that were done count.
    pub(super) fn advance(
        &mut self,
        validation: &C::Validation,
        check: Check<'_>,
        work: &Work,
    ) -> anyhow::Result<()> {
        let round = self.round();
        let (end, steps) = (self.schedule.end(round), self.steps());
        let Self { options, schedule, course, window, state } = self;
        let next = schedule.parts(round).end;
        let render_next = || match end < steps {
            true => render_part(course, schedule, next, check),
            false => Ok(Vec::new()),
        };
        let take_steps = || {
            while state.trainer.steps() < end.min(steps) {
                check()?;
                let batch = batch(options, schedule, course, window, state.trainer.steps());
                let measure = |network: &Network| course.measure(validation, network);
                step(options, schedule, state, &batch, work, &measure)?;
            }
            anyhow::Ok(())
        };
        let (next, done) = rayon::join(render_next, take_steps);
        done?;
        window.advance(next?);
        Ok(())
    }

    /// The network as it is now.
    pub(super) fn network(&self) -> anyhow::Result<Network> {
        network(&self.state.trainer)
    }

    fn round(&self) -> u64 {
        self.schedule.round(self.state.trainer.steps())
    }

    fn steps(&self) -> u64 {
        self.schedule.steps(self.options.samples)
    }
}

/// Begins with a trained network: samples of the first part show what its layers' values are.
fn warm_start<C: Course>(
    options: &Options,
    schedule: &Schedule,
    course: &C,
    start: &Network,
    check: Check<'_>,
) -> anyhow::Result<Trainer> {
    ensure!(
        *start.architecture() == course.architecture(),
        "the network to begin with is of another shape than this kind's: give one that was trained with the same --kind"
    );
    let mut window = Window::new(schedule.window);
    window.advance(render_part(course, schedule, 0, check)?);
    let batches = (0..BATCHES_AT_START).map(|step| batch(options, schedule, course, &window, step).inputs);
    let inputs: Vec<f32> = batches.flatten().collect();
    let trainer = Trainer::from_network(start, joints::COUNT, options.seed_of_weights(), &inputs)?;
    Ok(trainer.with_optimiser(options.optimiser.into()))
}

/// Learns from a batch; a validation follows where it is due, and at the end.
fn step(
    options: &Options,
    schedule: &Schedule,
    state: &mut State,
    batch: &Batch,
    work: &Work,
    measure: &dyn Fn(&Network) -> Vec<Figure>,
) -> anyhow::Result<()> {
    let State { trainer, curve, losses } = state;
    let (before, steps) = (trainer.steps(), schedule.steps(options.samples));
    let found = trainer.step(batch, learning_rate(options.peak_rate(), before, steps))?;
    let total = found.total(&batch.factors);
    if !total.is_finite() {
        bail!("the training has diverged at step {before}: its losses are not finite; another seed may help");
    }
    losses.add(&found, &batch.factors);
    work.set_position(schedule.samples(before + 1));
    work.set_message(format!("training, loss {total:.2}"));
    let rows = |step: u64| schedule.samples(step) / options.validate_every;
    if rows(before + 1) > rows(before) || before + 1 == steps {
        let figures = measure(&network(trainer)?);
        let has_masks = trainer.architecture().masks.is_some();
        let row = Row::new(schedule.samples(before + 1), &std::mem::take(losses), has_masks, figures);
        work.line(&row.to_string());
        curve.push(row);
    }
    Ok(())
}

fn network(trainer: &Trainer) -> anyhow::Result<Network> {
    let weights = trainer.weights();
    Network::from_weights(trainer.architecture().clone(), weights).context("the training has diverged")
}

/// The batch of a step, picked from the window and varied by its number alone.
fn batch<C: Course>(
    options: &Options,
    schedule: &Schedule,
    course: &C,
    window: &Window<C::Render>,
    step: u64,
) -> Batch {
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed_of_picks());
    rng.set_stream(step);
    let picks: Vec<&C::Render> = (0..schedule.batch).filter_map(|_| window.pick(&mut rng)).collect();
    let hard = options.hard_samples(schedule.batch, step, schedule.steps(options.samples));
    let first = schedule.samples(step);
    let lesson = |(at, render): (usize, &&C::Render)| {
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed_of_variations());
        rng.set_stream(first + at as u64);
        let showing = Showing { is_hard: at < hard, is_mirrored: schedule.is_mirrored(at) };
        course.lesson(render, showing, &mut rng)
    };
    let lessons: Vec<Option<Lesson>> = picks.par_iter().enumerate().map(lesson).collect();
    let mut batch = Batch { factors: course.factors(), ..Batch::default() };
    for Lesson { planes, target, masks, joints } in lessons.into_iter().flatten() {
        batch.inputs.extend(planes);
        batch.targets.push(target);
        batch.masks.extend(masks);
        batch.joints.extend(joints);
    }
    batch
}

/// Renders a part of the list of scenes.
fn render_part<C: Course>(
    course: &C,
    schedule: &Schedule,
    part: u64,
    check: Check<'_>,
) -> anyhow::Result<Vec<C::Render>> {
    render_all(schedule.scenes(part), check, |number| course.render(number, schedule.views))
}
