//! Programs that mill or turn a mirror, in words.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use super::fact_rows::{errors_sentence, ray_counts};
use super::maps::left_map;
use super::milling_plots::{section_figure, speeds_figure, times_figure};
use super::page::{map_figure, page_of};
use crate::geom::Cutter;
use crate::raster::{EncodingError, FalseColourMap};
use crate::results::{
    AsCutFacts, LeftFacts, LengthFacts, OperationFacts, ProgramReport, ServoFacts, error_px,
    figures, three_digits,
};
use crate::turning::ServoLimit;

/// What is left on a mirror after a program.
pub enum LeftPicture {
    /// From above, of a mill.
    Map(FalseColourMap),
    /// Along the radius, of a lathe: distance from the axis (mm), the least and the most (um).
    Section(Vec<[f64; 3]>),
}

impl ProgramReport {
    /// `program.html`, with pictures of what is left and of pixel errors, and the speeds in equal parts of the time of each
    /// operation.
    ///
    /// # Errors
    /// What the encoder of pictures reports.
    pub fn html(
        &self,
        left: &[(String, LeftPicture)],
        errors: Option<&FalseColourMap>,
        speeds_mm_min: &[Vec<f64>],
    ) -> Result<String, EncodingError> {
        let mut figures = Vec::new();
        for (operation, picture) in left {
            let map = match picture {
                LeftPicture::Map(map) => map,
                LeftPicture::Section(section) => {
                    let is_round = self.operations.iter().all(|done| done.servo.is_none());
                    figures.push(section_figure(operation, section, is_round));
                    continue;
                }
            };
            let caption = format!(
                "The face from above, each square {} mm wide, after {operation}: what its program, read back, leaves \
                 along the mirror's normal. Grey is where less than 0.1 um is left.",
                map.pixel_mm.map_or("0".into(), three_digits),
            );
            figures.push(map_figure(&format!("Left after {operation}, um"), map, caption)?);
        }
        if let Some(map) = errors {
            let caption = "What the picture is off by where the camera looks into the mirror as it comes off the machine, \
                           unpolished.";
            figures.push(map_figure("Pixel error as cut, px", map, caption.into())?);
        }
        figures.extend(times_figure(&self.operations));
        let speeds = self.operations.iter().zip(speeds_mm_min);
        figures.extend(speeds.map(|(operation, speeds)| speeds_figure(operation, speeds)));
        Ok(page_of(self, (None, "programs"), figures, &self.files))
    }

    /// The map of what an operation leaves over a grid of columns and rows so far apart.
    #[must_use]
    pub fn left_map(
        left_mm: &[Option<f64>],
        grid: ([usize; 2], f64),
        operation: &str,
    ) -> FalseColourMap {
        left_map(left_mm, grid, (format!("left after {operation}, um"), "done"))
    }
}

impl Answer for ProgramReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::default();
        let Self { material, control, work_offset, stock, .. } = self;
        let [x, y, z] = stock.size_mm;
        let size = match self.is_turned() {
            true => format!("a bar of {x:.1} mm diameter, {z:.1} mm high"),
            false => format!("{x:.1} x {y:.1} x {z:.1} mm"),
        };
        rows.add(
            "stock",
            format!(
                "{}, {size}: {} mm over the part on its sides and on top",
                material.name(),
                stock.allowance_mm
            ),
        );
        let is_servo = self.operations.iter().any(|operation| operation.servo.is_some());
        let middle = match self.is_turned() {
            true if is_servo => "X0 on the spindle's axis, X a radius, C0 towards the part's X",
            true => "X0 on the spindle's axis, X a diameter",
            false => "X0 Y0 below the camera's axis, in the middle of the mirror",
        };
        rows.add(
            "zero",
            format!("{work_offset}: {middle}; Z0 on the part's base ({})", control.name()),
        );
        self.operations.iter().for_each(|operation| operation.add_to(&mut rows));
        rows.add("time", format!("{} min on the machine", three_digits(self.machine_min)));
        self.add_cutters(&mut rows);
        self.add_picture(&mut rows);
        let [x, y, z] = self.travel_mm;
        rows.details(|rows| {
            rows.add("travel", format!("{x:.1} x {y:.1} x {z:.1} mm"));
            match self.angle_deg {
                Some(angle_deg) => rows.add("direction", format!("{angle_deg:.2} deg from X")),
                None if self.is_turned() => {}
                None => rows.add("path", "a spiral about the axis; roughing along X"),
            }
        });
        if let Some(program) = &self.program {
            rows.details(|rows| program.add_to(rows));
        }
        self.files.add_to(&mut rows);
        rows
    }
}

impl ProgramReport {
    /// Whether the programs are those of a lathe.
    fn is_turned(&self) -> bool {
        self.holder_diameter_mm.is_none()
    }

    /// A row for each cutter, with the most that its operations need; of a lathe how far the tool reaches.
    fn add_cutters(&self, rows: &mut AnswerRows) {
        let Some(holder_mm) = self.holder_diameter_mm else {
            if let Some(nose_mm) = self.operations.first().and_then(|done| done.nose_mm) {
                let reach = 0.1 * f64::ceil(10.0 * self.reach_mm);
                let words = format!(
                    "nose of {nose_mm} mm radius, {reach:.1} mm below the bar's top at most"
                );
                rows.add("tool", words);
            }
            return;
        };
        let mut cutters: Vec<Cutter> =
            self.operations.iter().filter_map(OperationFacts::cutter).collect();
        cutters.dedup();
        for cutter in cutters {
            let of_cutter = || self.operations.iter().filter(|done| done.cutter() == Some(cutter));
            let longest = |length: fn(&OperationFacts) -> Option<LengthFacts>| {
                let lengths = of_cutter().filter_map(length);
                lengths.reduce(|a, b| if b.least_mm > a.least_mm { b } else { a })
            };
            let flute = length_words("teeth", longest(|done| done.flute), "long");
            let holder = format!("out of a holder of {holder_mm} mm diameter");
            let stickout = length_words("", longest(|done| done.stickout), &holder);
            rows.add("cutter", format!("{}, {flute},{stickout}", cutter.words()));
        }
    }

    fn add_picture(&self, rows: &mut AnswerRows) {
        let Some(AsCutFacts { optical_triangles, trace }) = &self.as_cut else {
            rows.add("picture", "none: the finishing program cuts no face");
            return;
        };
        if let Some(error) = trace.errors.pixel_error_px {
            let allowed = self.accepted.map_or(String::new(), |allowed| {
                let limits = [allowed.pixel_error_rms_px, allowed.pixel_error_max_px];
                let [rms, max] = limits.map(|limit| limit.value);
                format!("; allowed {rms} and {max}")
            });
            rows.add(
                "picture",
                format!(
                    "off by {} px RMS, {} px at most, as it comes off the machine{allowed}",
                    error_px(error.rms),
                    error_px(error.max)
                ),
            );
        }
        rows.details(|rows| {
            let counts = ray_counts(trace, "rays ");
            rows.add("as cut", format!("{optical_triangles} optical triangles; {counts}"));
            rows.add("", errors_sentence(&trace.errors));
            if self.foreseen_px.is_some() {
                let foreseen = figures(self.foreseen_px);
                rows.add("foreseen", format!("{foreseen} px, by the study of its raster"));
            }
        });
    }
}

/// A length of a cutter in words, up to the next tenth of a millimetre.
fn length_words(before: &str, length: Option<LengthFacts>, after: &str) -> String {
    let Some(LengthFacts { least_mm, given_mm, .. }) = length else {
        return format!("{before} any length {after}");
    };
    let least = format!("{:.1} mm", 0.1 * f64::ceil(10.0 * least_mm));
    match given_mm {
        Some(given) => format!("{before} {given} mm {after} ({least} needed)"),
        None => format!("{before} at least {least} {after}"),
    }
}

impl ToRows for OperationFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { operation, file, levels, speeds, .. } = self;
        let levels = match levels {
            1 => String::new(),
            _ => format!("{levels} levels, "),
        };
        let left = self.left.map_or(String::new(), |left| {
            let LeftFacts { least_um, most_um, .. } = left;
            format!("; leaves {} to {} um", three_digits(least_um), three_digits(most_um))
        });
        rows.add(
            operation.name(),
            format!(
                "{file}: {} at {} rpm; {} min{left}",
                self.tool_words(&levels),
                speeds.spindle_rpm,
                three_digits(self.machine_min)
            ),
        );
        rows.details(|rows| {
            let Self { lines, moves, cutting_mm, rapid_mm, .. } = self;
            rows.add(
                "",
                format!(
                    "{lines} lines, {moves} moves; {:.2} m of cuts, {:.2} m of rapid moves",
                    1e-3 * cutting_mm,
                    1e-3 * rapid_mm
                ),
            );
            if let Some(servo) = &self.servo {
                rows.add("", servo.words());
            }
        });
    }
}

impl ServoFacts {
    /// Its points, and what its axes do at their most.
    fn words(&self) -> String {
        let Self { points_rev, acceleration_mm_s2, speed_mm_min, limited_by } = self;
        let why = match limited_by {
            ServoLimit::Acceleration => "the acceleration holds C down",
            ServoLimit::Speed => "the speed of X and Z holds C down",
            ServoLimit::Spindle => "C is as fast as it may",
        };
        let [acceleration, speed] = [*acceleration_mm_s2, *speed_mm_min].map(three_digits);
        format!(
            "{points_rev} points in a turn; {acceleration} mm/s^2 and {speed} mm/min at most: {why}"
        )
    }
}

impl OperationFacts {
    /// The tool, the levels, the stepover, and the feed.
    fn tool_words(&self, levels: &str) -> String {
        let Self { stepover_mm, nose_mm, feed_mm_rev, .. } = self;
        let cutter = self.cutter().zip(*stepover_mm).map(|(cutter, stepover_mm)| {
            let apart = three_digits(stepover_mm);
            let feed = self.speeds.feed_mm_min;
            let cutter = cutter.words();
            format!("{cutter}, {levels}stepover {apart} mm, {feed} mm/min")
        });
        let nose = nose_mm.zip(*feed_mm_rev).map(|(nose_mm, feed_mm)| {
            format!("nose of {nose_mm} mm radius, {levels}{feed_mm} mm in a turn")
        });
        cutter.or(nose).unwrap_or_default()
    }

    /// The cutter of a mill.
    fn cutter(&self) -> Option<Cutter> {
        let other = self.radius_mm.zip(self.corner_mm);
        let other = other.map(|(radius_mm, corner_mm)| Cutter { radius_mm, corner_mm });
        self.ball_mm.map(Cutter::ball).or(other)
    }
}
