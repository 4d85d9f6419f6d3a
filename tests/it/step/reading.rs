//! A reader of STEP files that knows nothing of the writer.

use morion::internals::geom::{DVec2, DVec3};
use std::collections::BTreeMap;

/// An argument of an instance.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    Ref(u32),
    Number(f64),
    Text(String),
    /// `.T.` and the like; `*`, `$`.
    Word(String),
    List(Vec<Value>),
    /// A keyword with arguments.
    Typed(String, Vec<Value>),
}

/// A file's instances by number: keyword and arguments; of a complex one, a list of typed values.
pub struct File {
    pub header: String,
    pub data: BTreeMap<u32, (String, Vec<Value>)>,
}

struct Text<'a>(&'a [u8]);

impl Text<'_> {
    fn skip(&mut self) {
        while self.0.first().is_some_and(u8::is_ascii_whitespace) {
            self.0 = &self.0[1..];
        }
    }

    fn eat(&mut self, wanted: u8) -> bool {
        self.skip();
        let found = self.0.first() == Some(&wanted);
        if found {
            self.0 = &self.0[1..];
        }
        found
    }

    fn expect(&mut self, wanted: u8) {
        let rest = String::from_utf8_lossy(&self.0[..self.0.len().min(40)]).into_owned();
        assert!(self.eat(wanted), "no {:?} before {rest:?}", wanted as char);
    }

    fn take(&mut self, of: impl Fn(u8) -> bool) -> String {
        let end = self.0.iter().position(|&c| !of(c)).unwrap_or(self.0.len());
        let (head, rest) = self.0.split_at(end);
        self.0 = rest;
        String::from_utf8(head.to_vec()).unwrap()
    }

    fn list(&mut self) -> Vec<Value> {
        self.expect(b'(');
        let mut values = Vec::new();
        if self.eat(b')') {
            return values;
        }
        loop {
            values.push(self.value());
            if self.eat(b')') {
                return values;
            }
            // The parts of a complex instance follow each other.
            let complex = matches!(values.last(), Some(Value::Typed(..)));
            if !self.eat(b',') {
                assert!(complex, "no comma after {:?}", values.last());
            }
        }
    }

    fn value(&mut self) -> Value {
        self.skip();
        match self.0[0] {
            b'#' => {
                self.expect(b'#');
                Value::Ref(self.take(|c| c.is_ascii_digit()).parse().unwrap())
            }
            b'\'' => {
                let mut text = String::new();
                while self.eat(b'\'') {
                    if !text.is_empty() {
                        text.push('\'');
                    }
                    text += &self.take(|c| c != b'\'');
                    self.expect(b'\'');
                    if self.0[0] != b'\'' {
                        break;
                    }
                }
                Value::Text(text)
            }
            b'(' => Value::List(self.list()),
            b'.' | b'*' | b'$' => {
                Value::Word(self.take(|c| c.is_ascii_uppercase() || b".*$_0123456789".contains(&c)))
            }
            c if c.is_ascii_uppercase() => {
                let word = self.take(|c| c.is_ascii_alphanumeric() || c == b'_');
                Value::Typed(word, self.list())
            }
            _ => {
                let text = self.take(|c| b"+-.E0123456789".contains(&c));
                assert!(!text.contains('E') || text.contains('.'), "{text} is no real");
                Value::Number(text.parse().unwrap_or_else(|_| panic!("{text:?}")))
            }
        }
    }
}

impl Value {
    pub fn id(&self) -> u32 {
        if let Self::Ref(id) = self { *id } else { panic!("{self:?}") }
    }

    pub fn number(&self) -> f64 {
        if let Self::Number(x) = self { *x } else { panic!("{self:?}") }
    }

    pub fn list(&self) -> &[Value] {
        if let Self::List(list) = self { list } else { panic!("{self:?}") }
    }

    pub fn is(&self, word: &str) -> bool {
        *self == Self::Word(word.into())
    }

    fn numbers(&self) -> Vec<f64> {
        self.list().iter().map(Self::number).collect()
    }
}

/// Cox and de Boor's recursion, by definition: the k-th spline of a degree.
fn spline(knots: &[f64], k: usize, degree: usize, t: f64) -> f64 {
    if degree == 0 {
        let last = knots[knots.len() - 1];
        // The last span holds its end too.
        let closed = t == last && knots[k + 1] == last && knots[k] < last;
        return f64::from(u8::from(knots[k] <= t && t < knots[k + 1] || closed));
    }
    let part = |over: f64, under: f64| if under == 0.0 { 0.0 } else { over / under };
    part(t - knots[k], knots[k + degree] - knots[k]) * spline(knots, k, degree - 1, t)
        + part(knots[k + degree + 1] - t, knots[k + degree + 1] - knots[k + 1])
            * spline(knots, k + 1, degree - 1, t)
}

/// One direction of a spline.
pub struct Axis {
    pub degree: usize,
    pub knots: Vec<f64>,
}

impl Axis {
    fn new(degree: &Value, times: &Value, values: &Value) -> Self {
        let repeated = |(&times, &knot): (&f64, &f64)| vec![knot; times as usize];
        let (times, values) = (times.numbers(), values.numbers());
        assert_eq!(times.len(), values.len());
        assert!(values.windows(2).all(|ends| ends[0] < ends[1]), "knots that do not rise");
        let knots = times.iter().zip(&values).flat_map(repeated).collect();
        Self { degree: degree.number() as usize, knots }
    }

    pub fn ends(&self) -> [f64; 2] {
        [self.knots[0], self.knots[self.knots.len() - 1]]
    }

    /// Numbers and weights of the coefficients that matter at `t`.
    fn weights(&self, t: f64) -> Vec<(usize, f64)> {
        let count = self.knots.len() - self.degree - 1;
        let reaches = |&k: &usize| self.knots[k] <= t && t <= self.knots[k + self.degree + 1];
        (0..count).filter(reaches).map(|k| (k, spline(&self.knots, k, self.degree, t))).collect()
    }
}

/// A surface with what it is evaluated from.
pub enum Surface {
    Plane { at: DVec3, normal: DVec3 },
    Cylinder { at: DVec3, radius: f64 },
    Cone { at: DVec3, radius: f64, angle: f64 },
    Spline { axes: [Axis; 2], points: Vec<Vec<DVec3>> },
    Turned { axis: Axis, points: Vec<DVec3> },
}

/// A curve with its parameters' range.
pub enum Curve {
    Line { at: DVec3, way: DVec3 },
    Circle { at: DVec3, radius: f64 },
    Spline { axis: Axis, points: Vec<DVec3> },
}

impl File {
    pub fn parse(bytes: &[u8]) -> Self {
        let text = std::str::from_utf8(bytes).unwrap();
        assert!(text.is_ascii() && text.starts_with("ISO-10303-21;\nHEADER;\n"));
        let (header, data) = text.split_once("ENDSEC;\nDATA;\n").unwrap();
        let data = data.strip_suffix("ENDSEC;\nEND-ISO-10303-21;\n").unwrap();
        let mut text = Text(data.as_bytes());
        let mut found = BTreeMap::new();
        while text.eat(b'#') {
            let id = text.take(|c| c.is_ascii_digit()).parse().unwrap();
            text.expect(b'=');
            let instance = match text.value() {
                Value::Typed(word, arguments) => (word, arguments),
                Value::List(parts) => (String::new(), parts),
                other => panic!("#{id} is {other:?}"),
            };
            text.expect(b';');
            assert!(found.insert(id, instance).is_none(), "#{id} twice");
        }
        assert!(text.0.is_empty());
        Self { header: header.into(), data: found }
    }

    /// All instances with this keyword.
    pub fn all(&self, keyword: &str) -> Vec<u32> {
        self.data.iter().filter(|(_, (word, _))| word == keyword).map(|(&id, _)| id).collect()
    }

    /// The arguments of an instance, which must have this keyword.
    pub fn get(&self, id: u32, keyword: &str) -> &[Value] {
        let (word, arguments) = &self.data[&id];
        assert_eq!(word, keyword, "#{id}");
        arguments
    }

    pub fn point(&self, id: u32) -> DVec3 {
        DVec3::from_slice(&self.get(id, "CARTESIAN_POINT")[1].numbers())
    }

    pub fn vertex(&self, id: u32) -> DVec3 {
        self.point(self.get(id, "VERTEX_POINT")[1].id())
    }

    fn direction(&self, id: u32) -> DVec3 {
        DVec3::from_slice(&self.get(id, "DIRECTION")[1].numbers())
    }

    fn placement(&self, id: u32) -> (DVec3, DVec3) {
        let place = self.get(id, "AXIS2_PLACEMENT_3D");
        (self.point(place[1].id()), self.direction(place[2].id()))
    }

    pub fn surface(&self, id: u32) -> Surface {
        let (word, a) = &self.data[&id];
        match word.as_str() {
            "PLANE" => {
                let (at, normal) = self.placement(a[1].id());
                // (Directions are ratios.)
                Surface::Plane { at, normal: normal.normalize() }
            }
            "CYLINDRICAL_SURFACE" => {
                let (at, axis) = self.placement(a[1].id());
                assert_eq!(axis, DVec3::Z);
                Surface::Cylinder { at, radius: a[2].number() }
            }
            "CONICAL_SURFACE" => {
                let (at, axis) = self.placement(a[1].id());
                assert!(axis == DVec3::Z || axis == DVec3::NEG_Z, "{axis}");
                // Its radius grows along the axis.
                Surface::Cone { at, radius: a[2].number(), angle: a[3].number() * axis.z }
            }
            "B_SPLINE_SURFACE_WITH_KNOTS" => {
                let axes = [Axis::new(&a[1], &a[8], &a[10]), Axis::new(&a[2], &a[9], &a[11])];
                let line = |line: &Value| line.list().iter().map(|p| self.point(p.id())).collect();
                let points: Vec<Vec<DVec3>> = a[3].list().iter().map(line).collect();
                assert_eq!(points.len(), axes[0].knots.len() - axes[0].degree - 1);
                let across = axes[1].knots.len() - axes[1].degree - 1;
                assert!(points.iter().all(|line| line.len() == across));
                Surface::Spline { axes, points }
            }
            "SURFACE_OF_REVOLUTION" => {
                let axis = self.get(a[2].id(), "AXIS1_PLACEMENT");
                assert_eq!(
                    (self.point(axis[1].id()), self.direction(axis[2].id())),
                    (DVec3::ZERO, DVec3::Z)
                );
                let Curve::Spline { axis, points } = self.curve(a[1].id()) else {
                    panic!("no meridian")
                };
                Surface::Turned { axis, points }
            }
            _ => panic!("{word}"),
        }
    }

    pub fn curve(&self, id: u32) -> Curve {
        let (word, a) = &self.data[&id];
        match word.as_str() {
            "LINE" => {
                let vector = self.get(a[2].id(), "VECTOR");
                let way = self.direction(vector[1].id()) * vector[2].number();
                Curve::Line { at: self.point(a[1].id()), way }
            }
            "CIRCLE" => {
                let (at, axis) = self.placement(a[1].id());
                assert_eq!(axis, DVec3::Z);
                Curve::Circle { at, radius: a[2].number() }
            }
            "B_SPLINE_CURVE_WITH_KNOTS" => {
                let axis = Axis::new(&a[1], &a[6], &a[7]);
                let points: Vec<DVec3> = a[2].list().iter().map(|p| self.point(p.id())).collect();
                assert_eq!(points.len(), axis.knots.len() - axis.degree - 1);
                Curve::Spline { axis, points }
            }
            "SURFACE_CURVE" => self.curve(a[1].id()),
            _ => panic!("{word}"),
        }
    }
}

impl Surface {
    /// The point of a spline at its parameters.
    pub fn at(&self, q: DVec2) -> DVec3 {
        let Self::Spline { axes: [u, v], points } = self else { panic!("no spline") };
        let across = v.weights(q.y);
        let line = |i: usize| -> DVec3 { across.iter().map(|&(j, b)| points[i][j] * b).sum() };
        u.weights(q.x).into_iter().map(|(i, a)| line(i) * a).sum()
    }
}

impl Surface {
    /// The ranges of a spline's parameters.
    pub fn ends(&self) -> [[f64; 2]; 2] {
        let Self::Spline { axes, .. } = self else { panic!("no spline") };
        axes.each_ref().map(Axis::ends)
    }

    /// What a spline's points change by with its parameters.
    pub fn slopes(&self, q: DVec2) -> [DVec3; 2] {
        let [u, v] = self.ends();
        let inside = |q: DVec2| DVec2::new(q.x.clamp(u[0], u[1]), q.y.clamp(v[0], v[1]));
        let h = DVec2::new(u[1] - u[0], v[1] - v[0]) * 1e-5;
        [DVec2::X * h.x, DVec2::Y * h.y].map(|e| {
            let (a, b) = (inside(q + e), inside(q - e));
            (self.at(a) - self.at(b)) / (a - b).length()
        })
    }
}

impl Curve {
    /// `count` + 1 points from one vertex to another along the curve's direction.
    pub fn between(&self, [from, to]: [DVec3; 2], count: usize) -> Vec<DVec3> {
        let share = |k: usize| k as f64 / count as f64;
        match self {
            Self::Line { at, way } => {
                let [from, to] = [from, to].map(|p| (p - *at).dot(*way) / way.length_squared());
                (0..=count).map(|k| *at + *way * (from + (to - from) * share(k))).collect()
            }
            Self::Circle { at, radius } => {
                use morion::internals::num::{atan2, cos, sin};
                let [from, to] = [from, to].map(|p| atan2(p.y - at.y, p.x - at.x));
                let turn = 2.0 * std::f64::consts::PI;
                let to = if to <= from { to + turn } else { to };
                let way = |angle: f64| DVec3::new(cos(angle), sin(angle), 0.0);
                (0..=count).map(|k| *at + way(from + (to - from) * share(k)) * *radius).collect()
            }
            Self::Spline { axis, points } => {
                let [from, to] = axis.ends();
                (0..=count)
                    .map(|k| if k == count { to } else { from + (to - from) * share(k) })
                    .map(|t| axis.weights(t).into_iter().map(|(k, b)| points[k] * b).sum())
                    .collect()
            }
        }
    }
}

/// The value of a plane spline at `t`.
pub fn height(axis: &Axis, points: &[DVec3], t: f64) -> DVec3 {
    axis.weights(t).into_iter().map(|(k, b)| points[k] * b).sum()
}
