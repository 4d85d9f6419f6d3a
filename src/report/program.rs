//! What a program cuts, in answers.

use super::answer::{AnswerRows, ToRows};
use crate::geom::Cutter;
use crate::results::{CutDeparture, ProgramFacts, SlopeOrigin, coordinate, three_digits};

impl ToRows for ProgramFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { ball_mm, nose_mm, lines, moves, cutting_mm, rapid_mm, cutting_min, .. } = self;
        let ball = ball_mm.map(|mm| format!("a ball of {mm} mm radius"));
        let nose = nose_mm.map(|mm| format!("a nose of {mm} mm radius"));
        let other = self
            .radius_mm
            .zip(self.corner_mm)
            .map(|(radius_mm, corner_mm)| format!("a {}", Cutter { radius_mm, corner_mm }.words()));
        let tool = ball.or(nose).or(other).unwrap_or_default();
        rows.add(
            "program",
            format!(
                "{lines} lines, {:.2} m of cuts, {} min at the feeds alone; cut by {tool}",
                1e-3 * cutting_mm,
                three_digits(*cutting_min)
            ),
        );
        let depth = |CutDeparture { off_um, at_mm, line }: &CutDeparture| {
            let [x, y, _] = at_mm.map(|mm| coordinate(mm, 3));
            format!("{} um at X {x}, Y {y} (line {line})", three_digits(*off_um))
        };
        rows.add("left", format!("{} at most", depth(&self.highest)));
        rows.add("least left", depth(&self.lowest));
        let Self { apart_mm, angle_deg, parallel, optical_triangles, .. } = self;
        rows.details(|rows| {
            let apart = format!("{} mm apart in the mean", three_digits(*apart_mm));
            match angle_deg.zip(*parallel) {
                Some((angle_deg, parallel)) => {
                    let agree = 100.0 * parallel;
                    rows.add(
                        "lines",
                        format!("{apart}, {angle_deg:.2} deg from X ({agree:.0} % agree)"),
                    );
                }
                None => rows.add("turns", apart),
            }
            let moves = format!("{moves} straight moves; {:.2} m of rapid ones", 1e-3 * rapid_mm);
            rows.add("moves", moves);
            let slopes = match self.slopes {
                SlopeOrigin::Facets => "",
                SlopeOrigin::Path => "; slopes are those that the moves leave, which are finer",
            };
            rows.add("as cut", format!("{optical_triangles} optical triangles{slopes}"));
        });
    }
}
