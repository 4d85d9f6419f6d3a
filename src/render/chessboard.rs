//! The paper's chessboard: pieces in their first places around a mirror in the middle of the board.

use super::World;
use super::chess_pieces::{ChessPiece, KINGS_HEAD, PieceKind};
use super::material::{Lighting, Material, backdrop};
use crate::geom::{DVec2, DVec3, Ray};
use crate::raster::srgb::hex;

/// Width of the board's border, in squares.
const BORDER: f64 = 0.45;
/// Height of the board over the table, in squares.
const THICK: f64 = 0.3;
/// How far a shadow's ray starts from its surface, in squares.
const CLEAR: f64 = 1e-6;
/// From the files a to h.
const OFFICERS: [PieceKind; 8] = [
    PieceKind::Rook,
    PieceKind::Knight,
    PieceKind::Bishop,
    PieceKind::Queen,
    PieceKind::King,
    PieceKind::Bishop,
    PieceKind::Knight,
    PieceKind::Rook,
];

/// A chessboard with its 32 pieces on a table under the open sky. The mirror is in the middle of the
/// board, at the height of the king's head, and the camera looks up at it through a hole (paper,
/// section 4): up is -Z of the part frame. White stands at azimuth 180 degrees, Black at 0, the file a at
/// azimuth 90.
///
/// Inside, lengths are squares of the board, Z = 0 is the board, Z is up, +Y goes to Black and X
/// from file a to h.
#[derive(Debug, Clone)]
pub struct Chessboard {
    square_mm: f64,
    /// Z of the part frame at the board, mm.
    board_mm: f64,
    /// Radius of the hole, squares.
    hole: f64,
    kinds: [ChessPiece; 6],
    /// Number in `kinds`, place, whether it is White.
    pieces: Vec<(usize, DVec2, bool)>,
    lights: Lighting,
}

/// Nearest surface that a ray meets.
enum BoardHit {
    Piece { white: bool, normal: DVec3 },
    Board(DVec2),
    Table,
}

const KINDS: [PieceKind; 6] = [
    PieceKind::Pawn,
    PieceKind::Rook,
    PieceKind::Knight,
    PieceKind::Bishop,
    PieceKind::Queen,
    PieceKind::King,
];

impl Chessboard {
    /// A board of squares of `square_mm` around the place (0, 0, `height_mm`) of the mirror, with a
    /// hole of radius `hole_mm` for the camera.
    #[must_use]
    pub fn new(square_mm: f64, height_mm: f64, hole_mm: f64) -> Self {
        let mut pieces = Vec::new();
        let number = |kind: PieceKind| KINDS.iter().position(|k| *k == kind).unwrap_or_default();
        for (file, officer) in OFFICERS.into_iter().enumerate() {
            let x = file as f64 - 3.5;
            for (y, kind, white) in [
                (-3.5, officer, true),
                (-2.5, PieceKind::Pawn, true),
                (2.5, PieceKind::Pawn, false),
                (3.5, officer, false),
            ] {
                pieces.push((number(kind), DVec2::new(x, y), white));
            }
        }
        Self {
            square_mm,
            board_mm: height_mm + KINGS_HEAD * square_mm,
            hole: hole_mm / square_mm,
            kinds: KINDS.map(ChessPiece::new),
            pieces,
            lights: Lighting { up: DVec3::Z, lamp: DVec3::new(-0.45, -0.3, 0.84).normalize() },
        }
    }

    /// The place in the part frame, mm, of a place on the board: `file` and `rank` in squares from the
    /// outer corner of a1, so that squares meet at whole numbers.
    #[must_use]
    pub fn place(&self, file: f64, rank: f64) -> DVec3 {
        let (x, y) = ((file - 4.0) * self.square_mm, (rank - 4.0) * self.square_mm);
        DVec3::new(-x, y, self.board_mm)
    }

    /// The board's frame: a half turn about Y, and squares for millimetres.
    fn inside(&self, ray: &Ray) -> Ray {
        let Ray { origin: o, direction: d } = *ray;
        let origin = DVec3::new(-o.x, o.y, self.board_mm - o.z) / self.square_mm;
        Ray { origin, direction: DVec3::new(-d.x, d.y, -d.z) }
    }

    fn nearest_hit(&self, ray: &Ray) -> Option<(f64, BoardHit)> {
        let floor = |z: f64| {
            let t = (z - ray.origin.z) / ray.direction.z;
            if t > 0.0 { t } else { f64::INFINITY }
        };
        let mut found = None;
        let mut end = floor(0.0);
        let on_board = ray.at(end).truncate();
        if end.is_finite() && on_board.abs().max_element() <= 4.0 + BORDER {
            found = Some((end, BoardHit::Board(on_board)));
        } else {
            end = floor(-THICK);
            if end.is_finite() {
                found = Some((end, BoardHit::Table));
            }
        }
        if let Some((t, white, normal)) = self.piece(ray, end) {
            found = Some((t, BoardHit::Piece { white, normal }));
        }
        found
    }

    /// The first piece nearer than `end`.
    fn piece(&self, ray: &Ray, mut end: f64) -> Option<(f64, bool, DVec3)> {
        let mut found = None;
        for &(kind, place, white) in &self.pieces {
            // The Black knights look to White.
            let side = DVec3::new(1.0, if white { 1.0 } else { -1.0 }, 1.0);
            let origin = (ray.origin - place.extend(0.0)) * side;
            let local = Ray { origin, direction: ray.direction * side };
            if let Some(contact) = self.kinds[kind].intersect(&local, end) {
                end = contact.t;
                found = Some((contact.t, white, contact.normal * side));
            }
        }
        found
    }

    /// Whether the lamp reaches a place.
    fn is_lit(&self, place: DVec3, normal: DVec3) -> bool {
        let ray = Ray { origin: place + normal * CLEAR, direction: self.lights.lamp };
        normal.dot(self.lights.lamp) > 0.0 && self.piece(&ray, f64::INFINITY).is_none()
    }

    fn board_material(&self, at: DVec2) -> Option<Material> {
        if at.length() < self.hole {
            return None;
        }
        let wide = at.abs().max_element();
        if wide > 4.0 {
            let line = (4.06..4.1).contains(&wide);
            return Some(Material::new(if line { 0xc9a46b } else { 0x4a2c1a }, 0.05));
        }
        let [file, rank] = [at.x, at.y].map(|x| (x + 4.0).floor() as i64);
        let dark = (file + rank) % 2 == 0;
        Some(Material::new(if dark { 0x7a4a2b } else { 0xf0d9b5 }, 0.05))
    }
}

impl World for Chessboard {
    fn light(&self, ray: &Ray, _: f64) -> [f32; 3] {
        let ray = self.inside(ray);
        let shade = |matter: &Material, t: f64, normal: DVec3| {
            let lit = self.is_lit(ray.at(t), normal);
            self.lights.shade(matter, normal, ray.direction, lit)
        };
        match self.nearest_hit(&ray) {
            None => backdrop(ray.direction.z.max(0.0)),
            Some((t, BoardHit::Piece { white, normal })) => {
                let matter = if white {
                    Material::new(0xf4ead4, 0.25)
                } else {
                    Material::new(0x35302e, 0.35)
                };
                shade(&matter, t, normal)
            }
            Some((t, BoardHit::Board(at))) => match self.board_material(at) {
                Some(wood) => shade(&wood, t, DVec3::Z),
                None => hex(0x141210),
            },
            Some((t, BoardHit::Table)) => {
                // Into haze towards the horizon, where the sky begins.
                let cloth = shade(&Material::new(0x5f7a68, 0.0), t, DVec3::Z);
                let haze = (1.0 - 1.0 / (1.0 + t / 40.0)) as f32;
                let sky = backdrop(0.0);
                std::array::from_fn(|c| cloth[c] + (sky[c] - cloth[c]) * haze)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOARD: (f64, f64) = (60.0, 12.0);

    fn board() -> Chessboard {
        Chessboard::new(BOARD.0, BOARD.1, 20.0)
    }

    fn towards(place: DVec3) -> Ray {
        let origin = DVec3::new(3.0, -2.0, BOARD.1);
        Ray { origin, direction: (place - origin).normalize() }
    }

    #[test]
    fn squares_alternate_and_a1_is_dark() {
        let board = board();
        let bright = |file: f64, rank: f64| {
            board.light(&towards(board.place(file, rank)), 1e-3).iter().sum::<f32>()
        };
        // Empty squares of the files b to g in the middle ranks but for the hole.
        for rank in [2, 3, 4, 5] {
            for file in [0, 1, 6, 7] {
                let colour = bright(f64::from(file) + 0.5, f64::from(rank) + 0.5);
                let other = bright(
                    f64::from(file) + 0.5,
                    f64::from(rank) + 1.5 - 2.0 * f64::from(rank / 5),
                );
                assert_eq!(colour < other, (file + rank) % 2 == 0, "{file} {rank}");
            }
        }
        assert_eq!(board.light(&towards(board.place(4.0, 4.0)), 1e-3), hex(0x141210));
    }

    #[test]
    fn every_piece_stands_on_its_square_in_its_colour() {
        let board = board();
        for file in 0..8 {
            for (rank, white) in [(0, true), (1, true), (6, false), (7, false)] {
                let foot = board.place(f64::from(file) + 0.5, f64::from(rank) + 0.5);
                // Straight down on it.
                let ray = Ray { origin: foot - DVec3::Z * 500.0, direction: DVec3::Z };
                let Some((t, BoardHit::Piece { white: found, .. })) =
                    board.nearest_hit(&board.inside(&ray))
                else {
                    panic!("no piece on {file} {rank}");
                };
                assert_eq!(found, white);
                let height = 500.0 / BOARD.0 - t;
                assert!(
                    (0.8..1.7).contains(&height) && (rank % 5 != 1 || height < 0.85),
                    "{height}"
                );
            }
        }
    }

    #[test]
    fn the_sky_is_up_and_the_table_below() {
        let board = board();
        let seen = |z: f64| {
            let direction = DVec3::new(0.9, 0.1, z).normalize();
            board.light(&Ray { origin: DVec3::new(0.0, 0.0, BOARD.1), direction }, 1e-3)
        };
        // Up is -Z.
        let (sky, table) = (seen(-0.5), seen(0.25));
        assert!(sky[2] > sky[0] && table[1] > table[0] && table[1] > table[2], "{sky:?} {table:?}");
    }

    #[test]
    fn pieces_throw_shadows_away_from_the_lamp() {
        let board = board();
        let lamp = board.lights.lamp;
        let pawn = DVec3::new(0.5, -2.5, 0.0);
        let aside = DVec3::new(lamp.x, lamp.y, 0.0).normalize() * 0.45;
        assert!(!board.is_lit(pawn - aside, DVec3::Z));
        assert!(board.is_lit(DVec3::new(0.5, -0.5, 0.0), DVec3::Z));
    }
}
