//! Random profiles from lists of numbers, which proptest makes smaller when something is wrong: the
//! smaller the numbers, the plainer the profile.

mod views;

use morion::internals::num::{exp, log};
use proptest::prelude::*;
use std::fmt;
use std::fmt::Write;

/// A profile, most of the time a valid one.
#[derive(Clone)]
pub struct Wanted {
    pub text: String,
    /// What is in `sag.csv`.
    pub heights: Option<String>,
    /// Whether its tolerances are asked for too.
    pub toleranced: bool,
}

impl fmt::Debug for Wanted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "profile:\n{}\nsag.csv:\n{}", self.text, self.heights.as_deref().unwrap_or("-"))
    }
}

pub fn strategy() -> impl Strategy<Value = Wanted> {
    prop::collection::vec(any::<u32>(), 120)
        .prop_map(|numbers| Draft { numbers: numbers.into_iter(), text: String::new() }.wanted())
}

struct Draft {
    numbers: std::vec::IntoIter<u32>,
    text: String,
}

const STRIP_LAWS: [&str; 6] =
    ["cylindrical", "mercator", "equirectangular", "equal-area", "best", "table"];
const RADIAL_LAWS: [&str; 10] = [
    "equiangular",
    "parabolic",
    "hyperbolic",
    "conical",
    "tangent-proportional",
    "area-proportional",
    "plane",
    "equi-areal",
    "cylinder",
    "table",
];
const FORMATS: [&str; 8] = ["stl", "obj", "3mf", "glb", "step", "csv", "pdf", "dxf"];
const PRESETS: [&str; 3] = ["precision-cnc", "spdt", "sla-print"];

/// What the parts of a profile have to know of each other.
struct Setting {
    width: f64,
    pinhole: bool,
    round: bool,
    bare: bool,
}

impl Draft {
    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        f64::from(self.numbers.next().unwrap_or(0)) / (f64::from(u32::MAX) + 1.0)
    }

    fn chance(&mut self, share: f64) -> bool {
        self.unit() > 1.0 - share
    }

    fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[(self.unit() * items.len() as f64) as usize]
    }

    fn inside(&mut self, [lo, hi]: [f64; 2]) -> f64 {
        rounded(lo + (hi - lo) * self.unit())
    }

    fn octaves(&mut self, [lo, hi]: [f64; 2]) -> f64 {
        let exponent = log(lo) + (log(hi) - log(lo)) * self.unit();
        rounded(exp(exponent))
    }

    fn sign(&mut self) -> f64 {
        if self.chance(0.5) { -1.0 } else { 1.0 }
    }

    fn line(&mut self, line: impl fmt::Display) {
        writeln!(self.text, "{line}").expect("strings take all");
    }

    fn wanted(mut self) -> Wanted {
        let family = self.pick(&["strip", "radial", "given", "view"]);
        let width = self.octaves([1.0, 300.0]);
        let pinhole = self.chance(0.4);
        // What a mirror has beyond a narrow frame is free, and may be anything.
        let least = if family == "view" { 8.0 } else { 1.0 };
        self.camera(width, pinhole, least);
        let mut setting = Setting { width, pinhole, round: false, bare: false };
        let (mut height, mut heights) = (None, None);
        match family {
            "strip" => {
                self.strip(&setting, false);
                self.method();
            }
            "radial" => {
                setting.round = true;
                self.radial(&setting);
                self.method();
            }
            "view" => {
                self.view(&setting);
                self.method();
            }
            _ => (height, heights) = self.given(&mut setting),
        }
        self.part(&setting, height);
        self.mesh(&setting);
        self.export(&setting);
        self.accept(&setting);
        let toleranced = self.tolerance(&setting);
        Wanted { text: self.text, heights, toleranced }
    }

    /// A camera of `least` to 25 pixels along and across.
    fn camera(&mut self, width: f64, pinhole: bool, least: f64) {
        let [columns, rows] = [(); 2].map(|()| self.inside([least, 25.0]).floor());
        let pixels = format!("pixels = [{columns}, {rows}]");
        if !pinhole {
            return self.line(format_args!("camera.orthographic = {{ {pixels} }}"));
        }
        let distance = rounded(width * self.octaves([0.5, 20.0]));
        // The frame is between a third and three times as wide as the part.
        let focal = rounded(columns * distance / width * self.octaves([0.3, 3.0]));
        let lens = match self.chance(0.3) {
            true => format!("hfov_deg = {}", self.octaves([1.0, 120.0])),
            false => format!("focal_px = {focal}"),
        };
        self.line(format_args!(
            "camera.pinhole = {{ {pixels}, {lens}, distance_mm = {distance} }}"
        ));
    }

    /// A target, and whether it is met below the horizon or above it alone.
    fn target(&mut self, width: f64) -> (String, f64) {
        let far = rounded(width * self.octaves([0.6, 30.0]));
        let side = self.sign();
        match self.pick(&["far", "far", "radius", "plane"]) {
            "far" => (String::new(), 0.0),
            "radius" => (format!(", target_radius_mm = {far}"), 0.0),
            _ => (format!(", target_plane_mm = {}", side * far), side),
        }
    }

    fn strip(&mut self, setting: &Setting, given: bool) {
        let law = self.pick(&STRIP_LAWS[..if given { 4 } else { 6 }]);
        let folded = !given && self.chance(0.4);
        let span = if folded || self.chance(0.3) { 360.0 } else { self.octaves([2.0, 360.0]) };
        let half = self.octaves([0.5, 60.0]);
        let centre = self.inside([-30.0, 30.0]);
        let (target, side) = self.target(setting.width);
        let range = [centre - half, centre + half].map(|e| rounded(e.clamp(-85.0, 85.0)));
        let [low, high] = match side {
            0.0 => range,
            side => {
                let ends = [side * 2.0, side * (2.0 + half)];
                [ends[0].min(ends[1]), ends[0].max(ends[1])]
            }
        };
        let elevation = if law == "table" {
            let count = 2 + (self.unit() * 4.0) as usize;
            let mut row = 0.0;
            let rows = (0..count).map(|k| {
                row += self.octaves([0.1, 20.0]);
                let share = k as f64 / (count - 1) as f64;
                format!("[{row}, {}]", rounded(high + (low - high) * share))
            });
            rows.collect::<Vec<_>>().join(", ")
        } else {
            format!("{low}, {high}")
        };
        let azimuth = format!("[{}, {}]", -0.5 * span, 0.5 * span);
        self.line(format_args!(
            "projection.{law} = {{ azimuth_deg = {azimuth}, elevation_deg = [{elevation}]{target} }}"
        ));
        let fills = self.chance(0.3) && !["table", "best"].contains(&law);
        if folded {
            let panel = self.pick(&["refit", "section"]);
            let ridge = self.pick(&["crest", "valley"]);
            self.line(format_args!(
                "layout.conquistador = {{ panel = \"{panel}\", ridge = \"{ridge}\", fill_frame = {fills} }}"
            ));
        } else {
            self.line(format_args!("layout.strip = {{ fill_frame = {fills} }}"));
        }
    }

    fn radial(&mut self, setting: &Setting) {
        let law = loop {
            let law = self.pick(&RADIAL_LAWS);
            let fits = match law {
                "parabolic" => !setting.pinhole,
                "hyperbolic" | "conical" => setting.pinhole,
                _ => true,
            };
            if fits {
                break law;
            }
        };
        let annulus = self.chance(0.5) || ["conical", "cylinder"].contains(&law);
        let most = if law == "plane" { 85.0 } else { 160.0 };
        let outer = self.inside([10.0, most]);
        let two = !["parabolic", "hyperbolic", "conical", "plane"].contains(&law);
        let inner = rounded(outer * self.inside([0.05, 0.9]));
        let inner_key = match two && annulus {
            true => format!("inner_polar_deg = {inner}, "),
            false => String::new(),
        };
        let (target, _) = self.target(setting.width);
        let keys = match law {
            "table" => self.polar_angles([if annulus { inner } else { 0.0 }, outer]),
            _ => format!("{inner_key}outer_polar_deg = {outer}"),
        };
        self.line(format_args!("projection.{law} = {{ {keys}{target} }}"));
        self.round(setting, annulus);
    }

    /// A table of two to six polar angles between those of the rims, at uneven places.
    fn polar_angles(&mut self, [inner, outer]: [f64; 2]) -> String {
        let count = 1 + (self.unit() * 5.0) as usize;
        let mut ways = vec![[0.0; 2]];
        for k in 0..count {
            ways.push([(); 2].map(|()| self.octaves([0.2, 5.0])));
            ways[k + 1] = [0, 1].map(|side| ways[k][side] + ways[k + 1][side]);
        }
        let whole = ways[count];
        let entry = |way: &[f64; 2]| {
            let [share, part] = [0, 1].map(|side| way[side] / whole[side]);
            format!("[{}, {}]", rounded(share), rounded(inner + part * (outer - inner)))
        };
        format!("polar_deg = [{}]", ways.iter().map(entry).collect::<Vec<_>>().join(", "))
    }

    fn round(&mut self, setting: &Setting, annulus: bool) {
        if annulus {
            let inner = rounded(setting.width * self.inside([0.05, 0.8]));
            self.line(format_args!("layout.annulus.inner_width_mm = {inner}"));
        } else {
            self.line("layout.disc = {}");
        }
    }

    fn method(&mut self) {
        let method = self.pick(&["vector-field", "fixed-surface", "distribution"]);
        let degree = self.inside([1.0, 10.0]).floor();
        let minimax = self.chance(0.15);
        self.line(format_args!("method.{method} = {{ degree = {degree}, minimax = {minimax} }}"));
    }

    /// A given mirror, and the height and the heights that it comes with.
    fn given(&mut self, setting: &mut Setting) -> (Option<f64>, Option<String>) {
        let width = setting.width;
        let radius = rounded(width * self.octaves([0.55, 30.0]) * self.sign());
        let mut height = None;
        match self.pick(&["bare", "disc", "annulus", "strip", "radial"]) {
            "bare" => {
                setting.bare = true;
                height = Some(rounded(width * self.octaves([0.3, 2.0])));
            }
            "strip" => self.strip(setting, true),
            "radial" => {
                setting.round = true;
                self.radial(setting);
            }
            name => {
                (setting.bare, setting.round) = (true, true);
                self.round(setting, name == "annulus");
            }
        }
        if self.chance(0.4) {
            self.line("mirror.grid.file = \"sag.csv\"");
            let heights = self.heights([0.5 * width, 0.5 * height.unwrap_or(2.0 * width)], radius);
            return (height, Some(heights));
        }
        let conic = self.inside([-3.0, 1.0]);
        let count = self.pick(&[0, 0, 1, 2, 3]);
        let mut terms: Vec<(i32, i32, f64)> = Vec::new();
        for _ in 0..count {
            let [i, j] = [(); 2].map(|()| (self.unit() * 4.0) as i32);
            let size = self.octaves([1e-3, 0.2]) * self.sign();
            let powers = (1..i + j).fold(1.0, |power, _| power / (0.5 * width));
            if terms.iter().all(|term| (term.0, term.1) != (i, j)) {
                terms.push((i, j, rounded(size * powers)));
            }
        }
        let terms: Vec<String> = terms.iter().map(|(i, j, c)| format!("[{i}, {j}, {c}]")).collect();
        let terms = match terms.is_empty() {
            true => String::new(),
            false => format!(", terms = [{}]", terms.join(", ")),
        };
        self.line(format_args!(
            "mirror.polynomial = {{ radius_mm = {radius}, conic = {conic}{terms} }}"
        ));
        (height, None)
    }

    /// A grid over a little more than the mirror.
    fn heights(&mut self, half: [f64; 2], radius: f64) -> String {
        let [columns, rows] = [(); 2].map(|()| 4 + (self.unit() * 9.0) as usize);
        let twist = self.inside([-0.3, 0.3]) / half[0];
        let rough = 1e-3 * half[0] * self.unit();
        let mut text = String::new();
        for j in 0..rows {
            for i in 0..columns {
                let at = |k: usize, n: usize, half: f64| {
                    1.02 * half * (2.0 * k as f64 / (n - 1) as f64 - 1.0)
                };
                let (x, y) = (at(i, columns, half[0]), at(j, rows, half[1]));
                let bump = rough * ((7 * i + 5 * j) % 3) as f64;
                let z = 0.5 * (x * x + y * y) / radius + twist * x * y + bump;
                writeln!(text, "{x},{y},{z}").expect("strings take all");
            }
        }
        text
    }

    fn part(&mut self, setting: &Setting, height: Option<f64>) {
        let width = setting.width;
        let base = rounded(width * self.octaves([0.02, 1.0]));
        self.line("[part]");
        self.line(format_args!("width_mm = {width}\nbase_mm = {base}"));
        if let Some(height) = height {
            self.line(format_args!("height_mm = {height}"));
        }
        if !self.chance(0.3) {
            return;
        }
        let border = rounded(width * self.octaves([0.05, 0.5])).max(0.1);
        self.line(format_args!("border_mm = {border}"));
        let rim = rounded(base * self.inside([0.02, 0.9]));
        if self.chance(0.5) {
            self.line(format_args!("rim_mm = {rim}"));
        }
        if !setting.round && self.chance(0.4) {
            let radius = rounded(border * self.inside([0.2, 1.5]));
            self.line(format_args!("corner_radius_mm = {radius}"));
        }
        let x = rounded(0.5 * width + 0.5 * border);
        for (key, x) in [("holes_mm", x), ("marks_mm", -x)] {
            let diameter = rounded(border * self.inside([0.05, 0.7])).max(0.1);
            if self.chance(0.4) {
                self.line(format_args!("{key} = [[{x}, 0, {diameter}]]"));
            }
        }
    }

    fn mesh(&mut self, setting: &Setting) {
        self.line("[mesh]");
        let chord = rounded(1e3 * setting.width * self.octaves([2e-4, 2e-2]));
        let facet = self.octaves([1.0, 50.0]);
        let most = self.octaves([100.0, 2000.0]).floor();
        // To spend a number of triangles takes many meshes.
        match self.pick(&["both", "facet", "chord", "both", "facet", "chord", "both", "most"]) {
            "most" => self.line(format_args!("max_triangles = {most}")),
            "facet" if !setting.bare => self.line(format_args!("facet_px = {facet}")),
            "both" if !setting.bare => {
                self.line(format_args!("chord_um = {chord}\nfacet_px = {facet}"));
            }
            _ => self.line(format_args!("chord_um = {chord}")),
        }
    }

    fn export(&mut self, setting: &Setting) {
        self.line("[export]");
        let first = self.pick(&FORMATS);
        let mut formats = vec![first];
        for format in FORMATS {
            if format != first && self.chance(0.2) {
                formats.push(format);
            }
        }
        self.line(format_args!("formats = {formats:?}"));
        if self.chance(0.3) {
            let path = self.pick(&["raster", "spiral"]);
            let [pitch, step] = [(); 2].map(|()| setting.width * self.octaves([0.01, 0.3]));
            let [pitch, step] = [pitch, step].map(rounded);
            self.line(format_args!(
                "sag = {{ path = \"{path}\", pitch_mm = {pitch}, step_mm = {step} }}"
            ));
        }
    }

    fn accept(&mut self, setting: &Setting) {
        if setting.bare || !self.chance(0.3) {
            return;
        }
        self.line("[accept]");
        for key in ["pixel_error_rms_px", "pixel_error_max_px"] {
            let limit = self.octaves([0.1, 100.0]);
            if self.chance(0.5) {
                self.line(format_args!("{key} = {limit}"));
            }
        }
        if self.chance(0.3) {
            let filled = self.unit();
            self.line(format_args!("frame_filled = {filled}"));
        }
    }

    /// Expected errors, and whether they are worked out.
    fn tolerance(&mut self, setting: &Setting) -> bool {
        if !self.chance(0.2) {
            return false;
        }
        let (preset, budget) = (self.pick(&PRESETS), self.octaves([0.01, 30.0]));
        let criterion = self.pick(&["rms", "p95"]);
        let reference = self.pick(&["design", "projection"]);
        let form = self.pick(&["pv", "rms"]);
        self.line(format_args!(
            "[tolerance]\npreset = \"{preset}\"\nbudget_px = {budget}\ncriterion = \"{criterion}\"\n\
             reference = \"{reference}\"\nform = \"{form}\""
        ));
        if self.chance(0.5) {
            self.line("compensators = [\"shift\", \"tilt\"]");
        }
        let own = if setting.round { "zernike_5_um" } else { "legendre_20_um" };
        let [tilt, bend] = [(); 2].map(|()| self.octaves([1e-3, 10.0]));
        self.line(format_args!("limits = {{ tilt_x_mrad = {tilt}, {own} = {bend} }}"));
        let shape = self.pick(&["uniform", "normal", "truncated", "fixed"]);
        self.line(format_args!("distributions.tilt_x_mrad = \"{shape}\"\nweights.tilt_x_mrad = 2"));
        self.chance(0.3)
    }
}

/// To four digits, as someone would write it.
fn rounded(x: f64) -> f64 {
    format!("{x:.3e}").parse().expect("a number")
}
