//! The frame-fill check's results as JSON, CSV and text.

use super::answer::{Answer, AnswerRows, Head};
use super::page::{map_figure, page_of};
use crate::profile::Profile;
use crate::raster::{EncodingError, FalseColourMap};
use crate::results::{FrameReport, digits};
use crate::trace::{Coverage, FrameFill, Obstruction};
use std::fmt::Write;

/// Names of the causes, in the order of [`crate::trace::PixelClass::LOST`].
pub(super) const LOST: [&str; 8] = [
    "beyond the mirror",
    "at the rim",
    "at the ridge",
    "in shadow",
    "wrong content",
    "back face",
    "missed",
    "behind obstacles",
];

impl FrameReport {
    /// `frame.csv`: a line a column of the sensor.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut out = String::from("column,filled_px,lowest_deg,highest_deg\n");
        for (k, column) in self.coverage.columns.iter().enumerate() {
            let [lowest, highest] = match column.elevation_deg {
                Some(range) => range.map(|deg| format!("{deg:.6}")),
                None => Default::default(),
            };
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{k},{},{lowest},{highest}", column.filled);
        }
        out
    }
}

impl FrameReport {
    /// `frame.html`, with the map of the frame.
    ///
    /// # Errors
    /// What the encoder of pictures reports.
    pub fn html(&self, profile: &Profile, map: &FalseColourMap) -> Result<String, EncodingError> {
        let caption = format!(
            "Every pixel of the frame: grey where it shows what it should, lighter where it covers more of the world \
             (coarser there), in colour where it is lost. {:.3} % are filled.",
            100.0 * self.frame.filled
        );
        Ok(page_of(
            self,
            (Some(("frame.html", profile)), "frame"),
            [map_figure("Solid angle of a pixel, microsteradian", map, caption)?],
            &[],
        ))
    }
}

/// The widest of some ranges of azimuth in degrees, in their order, and how many others there are.
fn widest(ranges: &[[f64; 2]]) -> (Vec<String>, usize) {
    /// Ranges that are named.
    const NAMED: usize = 4;
    let width = |k: &usize| ranges[*k][1] - ranges[*k][0];
    let mut order: Vec<usize> = (0..ranges.len()).collect();
    order.sort_by(|a, b| width(b).total_cmp(&width(a)).then(a.cmp(b)));
    order.truncate(NAMED);
    order.sort_unstable();
    let named: Vec<String> =
        order.into_iter().map(|k| format!("{:.3} to {:.3}", ranges[k][0], ranges[k][1])).collect();
    let others = ranges.len() - named.len();
    (named, others)
}

impl Answer for FrameReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::labelled(10);
        self.add_frame(&mut rows);
        self.add_coverage(&mut rows);
        self.add_obstacles(&mut rows);
        self.add_solid_angles(&mut rows);
        rows
    }
}

impl FrameReport {
    fn add_frame(&self, rows: &mut AnswerRows) {
        let FrameFill { pixels: [width, height], tolerance_px, .. } = self.frame;
        let [filled, gain] = [self.frame.filled, self.frame.gain_over_disc].map(|x| 100.0 * x);
        rows.terminal(
            "frame",
            format!(
                "{filled:.3} % of {width} x {height} filled within {tolerance_px} px; {gain:+.1} % against \
                 a disc"
            ),
        );
        let lost = self.frame.lost.counts().into_iter().zip(LOST).filter(|(count, _)| *count > 0);
        let lost: Vec<String> = lost.map(|(count, name)| format!("{count} {name}")).collect();
        rows.terminal("lost", if lost.is_empty() { "none".into() } else { lost.join(", ") });
    }

    fn add_coverage(&self, rows: &mut AnswerRows) {
        let Coverage { azimuth_deg, gaps_deg, seams, lowest_deg, highest_deg, .. } = &self.coverage;
        let (widest, others) = widest(gaps_deg);
        let mut gaps: String = widest.iter().map(|gap| format!(", not {gap}")).collect();
        if others > 0 {
            gaps += &format!(", nor {others} narrower gaps");
        }
        rows.terminal("azimuth", format!("{azimuth_deg:.3} of 360 deg covered{gaps}"));
        for seam in seams {
            let (px, deg) = (seam.gap_px, seam.gap_deg);
            rows.terminal(
                "seam",
                format!(
                    "{} edge: gap {:.3} to {:.3} px, {:.3} in the mean ({:.4} to {:.4} deg)",
                    seam.edges, px.min, px.max, px.mean, deg.min, deg.max
                ),
            );
        }
        if let (Some(low), Some(high)) = (lowest_deg, highest_deg) {
            rows.terminal(
                "elevation",
                format!(
                    "columns begin at {:.2} to {:.2} ({:.2} in the mean) and end at {:.2} to {:.2} ({:.2}) \
                     deg",
                    low.min, low.max, low.mean, high.min, high.max, high.mean
                ),
            );
        }
    }

    /// What each obstacle hides.
    fn add_obstacles(&self, rows: &mut AnswerRows) {
        for Obstruction { name, pixels, azimuth_deg, elevation_deg } in &self.obstacles {
            let (mut azimuths, others) = widest(azimuth_deg);
            if others > 0 {
                azimuths.push(format!("{others} narrower ranges"));
            }
            let sentence = match elevation_deg {
                Some([low, high]) => format!(
                    "{name}: {pixels} pixels, azimuth {} deg, elevation {low:.3} to {high:.3} deg",
                    azimuths.join(" and ")
                ),
                None => format!("{name}: {pixels} pixels"),
            };
            rows.add("obstacle", sentence);
        }
    }

    /// The table of the solid angles of pixels, of this mirror and of round ones.
    fn add_solid_angles(&self, rows: &mut AnswerRows) {
        let line = |name: &str, [least, mean, most, ratio, pixels]: [&str; 5]| {
            format!("  {name:28} {least:>9} {mean:>9} {most:>9} {ratio:>8} {pixels:>9}")
        };
        let names = ["least", "mean", "most", "ratio", "pixels"];
        rows.line(line("solid angle of a pixel, usr", names));
        let rounds = self.round_mirrors.iter().map(|round| (&round.profile, &round.resolution));
        for (name, resolution) in [(&self.profile.name, &self.resolution)].into_iter().chain(rounds)
        {
            let [least, mean, most, ratio] = match (resolution.pixel_usr, resolution.ratio) {
                (Some(usr), Some(ratio)) => [usr.min, usr.mean, usr.max, ratio].map(digits),
                _ => ["-"; 4].map(String::from),
            };
            let pixels = resolution.pixels.to_string();
            rows.line(line(&format!("  {name}"), [&least, &mean, &most, &ratio, &pixels]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_ranges_the_widest_are_named() {
        let few = [[0.0, 1.0], [2.0, 2.5]];
        assert_eq!(widest(&few), (vec!["0.000 to 1.000".into(), "2.000 to 2.500".into()], 0));
        let many: Vec<[f64; 2]> =
            (0..50).map(|k| [f64::from(k), f64::from(k) + 0.01 * f64::from(k % 10)]).collect();
        let (named, others) = widest(&many);
        assert_eq!(named[0], "9.000 to 9.090");
        assert_eq!((named.len(), others), (4, 46));
        assert_eq!(widest(&[]), (Vec::new(), 0));
        // The widest after as many of one width as are named.
        let ties = [[0.0, 0.5], [1.0, 1.5], [2.0, 2.5], [3.0, 3.5], [90.0, 130.0]];
        let (named, others) = widest(&ties);
        assert_eq!((named[3].as_str(), others), ("90.000 to 130.000", 1));
    }
}
