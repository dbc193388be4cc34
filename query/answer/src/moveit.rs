//! Answers as messages for MoveIt.

use grasp_robot::moveit::yaml;

use super::human;
use super::record::Answer;

/// The YAML document of an answer, where it has a strategy that can be carried out: a message is
/// for machines, which would try any.
pub fn message(answer: &Answer) -> Option<String> {
    let id = answer.frame.map_or_else(|| answer.file.clone(), |frame| format!("{} {frame}", answer.file));
    let feasible = answer.strategy.as_ref().filter(|strategy| strategy.feasible);
    feasible.map(|strategy| yaml(strategy, &id))
}

/// Why an answer's strategy is no message, where it cannot be carried out: a line for each problem.
pub fn refusal(answer: &Answer) -> Option<String> {
    let infeasible = answer.strategy.as_ref().filter(|strategy| !strategy.feasible)?;
    let name = human::name(&answer.file, answer.frame);
    let lines = infeasible.problems.iter();
    Some(
        lines
            .map(|problem| format!("{name}: no message, as it is not feasible: {}\n", problem.message))
            .collect(),
    )
}
