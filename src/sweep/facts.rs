//! What the outcomes of a study come to.

use super::front::on_front;
use super::grid::Grid;
use super::study::SweepStudy;
use crate::num::rounding::significant;
use crate::profile::{AxisSpec, ColumnGoal, ColumnSpec, SweepSpec};
use crate::results::{
    AxisFacts, ColumnFacts, PointFacts, PointFailures, PointOutcome, PointStatus, SCHEMA,
    SweepReport, SweepRow, SweepTable, words_of_key,
};
use serde_json::Value as Json;

/// Most points of a front that a report lists: a page of them; all are marked in the rows.
const MOST_LISTED: usize = 100;
/// Most reasons of failures that a report lists.
const MOST_REASONS: usize = 10;

/// Digits in which figures must differ for one to be better than the other: iterations of a design end at the seventh.
const DIGITS: usize = 6;

/// Places among axes and then columns of which something is sought, and what.
fn goals(spec: &SweepSpec) -> Vec<(usize, ColumnGoal)> {
    let axes = spec.axes.iter().map(|axis| axis.goal);
    let goals = axes.chain(spec.columns.iter().map(|column| column.goal));
    goals.enumerate().filter_map(|(place, goal)| Some((place, goal?))).collect()
}

/// What is made small in the place of a figure of a row; NaN where there is none.
fn cost(row: &SweepRow, (place, goal): (usize, ColumnGoal)) -> f64 {
    let figure = significant(row.number(place).unwrap_or(f64::NAN), DIGITS);
    if goal == ColumnGoal::Least { figure } else { -figure }
}

/// All points with their outcomes.
pub(super) fn table(spec: &SweepSpec, outcomes: Vec<PointOutcome>) -> SweepTable {
    let grid = Grid::new(&spec.axes);
    let row = |(k, outcome)| {
        let axes = grid.values(k).into_iter().cloned().collect();
        SweepRow { axes, outcome, is_on_front: false }
    };
    let mut rows: Vec<SweepRow> = outcomes.into_iter().enumerate().map(row).collect();
    let goals = goals(spec);
    let costs = |row: &SweepRow| goals.iter().map(|goal| cost(row, *goal)).collect::<Vec<f64>>();
    let front = on_front(&rows.iter().map(costs).collect::<Vec<_>>());
    rows.iter_mut().zip(front).for_each(|(row, is_on)| row.is_on_front = is_on);
    SweepTable {
        axes: spec.axes.iter().map(|axis| axis.key.clone()).collect(),
        columns: spec.columns.iter().map(|column| column.key.clone()).collect(),
        rows,
    }
}

/// The report on `table`; no files in it yet.
pub(super) fn report(study: &SweepStudy, table: &SweepTable) -> SweepReport {
    let SweepStudy { spec, profile, .. } = study;
    let count = |status| table.rows.iter().filter(|row| row.outcome.status == status).count();
    let columns = spec.columns.iter().enumerate();
    let (front_points, front) = front(spec, table);
    SweepReport {
        schema: SCHEMA,
        study: spec.name.clone(),
        profile: profile.clone(),
        command: spec.command,
        points: table.rows.len(),
        made: count(PointStatus::Made),
        invalid: count(PointStatus::Invalid),
        refused: count(PointStatus::Refused),
        axes: spec.axes.iter().map(|axis| axis_facts(spec, axis)).collect(),
        columns: columns.map(|(k, column)| column_facts(table, k, column)).collect(),
        front_points,
        front,
        failures: failures(table),
        files: Vec::new(),
        warnings: warnings(spec, table),
    }
}

fn axis_facts(spec: &SweepSpec, axis: &AxisSpec) -> AxisFacts {
    AxisFacts {
        key: axis.key.clone(),
        label: axis.label.clone().unwrap_or_else(|| words_of_key(&axis.key)),
        values: axis.values.len(),
        range: range(axis.values.iter()),
        is_logarithmic: axis.is_logarithmic,
        paired_with: axis.paired_with.map(|other| spec.axes[other].key.clone()),
        goal: axis.goal,
    }
}

fn column_facts(table: &SweepTable, k: usize, column: &ColumnSpec) -> ColumnFacts {
    let ColumnSpec { key, label, goal } = column;
    let values = || table.rows.iter().map(|row| row.outcome.values.get(k).unwrap_or(&Json::Null));
    let best = goal.and_then(|goal| {
        let place = table.axes.len() + k;
        // Of equal ones one on the front, which is better in another goal.
        let rank = |row: &SweepRow| (cost(row, (place, goal)), !row.is_on_front);
        let ranks = table.rows.iter().map(rank).enumerate();
        let known = ranks.filter(|(_, (cost, _))| !cost.is_nan());
        known.reduce(|a, b| if b.1 < a.1 { b } else { a })
    });
    ColumnFacts {
        key: key.clone(),
        label: label.clone().unwrap_or_else(|| words_of_key(key)),
        goal: *goal,
        known: values().filter(|value| !value.is_null()).count(),
        range: range(values()),
        best: best.map(|(point, _)| point_facts(table, point)),
    }
}

/// The least and the largest of the numbers among `values`.
fn range<'a>(values: impl Iterator<Item = &'a Json>) -> Option<[f64; 2]> {
    let ends = values.filter_map(Json::as_f64).map(|x| [x, x]);
    ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
}

/// The number of points on the front, and those of them that are listed.
fn front(spec: &SweepSpec, table: &SweepTable) -> (usize, Vec<PointFacts>) {
    let rows = table.rows.iter().enumerate().filter(|(_, row)| row.is_on_front);
    let mut all: Vec<(usize, &SweepRow)> = rows.collect();
    if let Some(goal) = goals(spec).first() {
        let order = |a: &SweepRow, b: &SweepRow| cost(a, *goal).total_cmp(&cost(b, *goal));
        all.sort_by(|a, b| order(a.1, b.1).then(a.0.cmp(&b.0)));
    }
    let listed = all.len().min(MOST_LISTED);
    // Both ends are among them.
    let place = |k: usize| k * (all.len() - 1) / (listed.max(2) - 1);
    (all.len(), (0..listed).map(|k| point_facts(table, all[place(k)].0)).collect())
}

fn point_facts(table: &SweepTable, point: usize) -> PointFacts {
    let row = &table.rows[point];
    PointFacts { point, axes: row.axes.clone(), columns: row.outcome.values.clone() }
}

/// Reasons of failures; those that differ in numbers alone are one.
fn failures(table: &SweepTable) -> Vec<PointFailures> {
    let mut kinds: Vec<(String, PointFailures)> = Vec::new();
    for (first, row) in table.rows.iter().enumerate() {
        let PointOutcome { status, error: Some(error), .. } = &row.outcome else { continue };
        let kind = without_numbers(error);
        match kinds.iter_mut().find(|(other, found)| *other == kind && found.status == *status) {
            Some((_, found)) => found.points += 1,
            None => {
                let failure =
                    PointFailures { points: 1, first, status: *status, error: error.clone() };
                kinds.push((kind, failure));
            }
        }
    }
    let mut all: Vec<PointFailures> = kinds.into_iter().map(|(_, failure)| failure).collect();
    all.sort_by_key(|failure| (std::cmp::Reverse(failure.points), failure.first));
    all.truncate(MOST_REASONS);
    all
}

/// A sentence with a mark in the place of each number.
fn without_numbers(sentence: &str) -> String {
    let is_number = |c: char| c.is_ascii_digit() || ".+-".contains(c);
    let mut words = String::new();
    for c in sentence.chars() {
        match is_number(c) {
            true if words.ends_with('#') => {}
            true => words.push('#'),
            false => words.push(c),
        }
    }
    words
}

/// What a reader of the rows has to know.
fn warnings(spec: &SweepSpec, table: &SweepTable) -> Vec<String> {
    let made = table.rows.iter().any(|row| row.outcome.status == PointStatus::Made);
    let unknown = |k: usize| {
        !table
            .rows
            .iter()
            .any(|row| row.outcome.values.get(k).is_some_and(|value| !value.is_null()))
    };
    let columns = spec.columns.iter().enumerate();
    let empty = columns.filter(|(k, _)| made && unknown(*k)).map(|(_, column)| {
        format!("{}: no point has {}; its reports leave that key out", spec.name, column.key)
    });
    empty.collect()
}
