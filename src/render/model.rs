//! OBJ models as worlds: triangles with matt colours or pictures on them, under an open sky.

use std::cell::RefCell;
use std::io::Cursor;
use std::path::Path;

use thiserror::Error;

use super::World;
use super::material::{Lighting, Material, backdrop};
use super::panorama::MipPyramid;
use crate::geom::{DVec2, DVec3, Ray, TriMesh};
use crate::raster::{Raster, RasterError};
use crate::trace::Scene;

/// sRGB code of facets without a material.
const PLAIN: u32 = 0xb8b8b8;

/// Why a file is no model.
#[derive(Debug, Error)]
pub enum ModelError {
    /// Not an OBJ.
    #[error("not a readable OBJ: {0}; export the model again as triangles")]
    Obj(tobj::LoadError),
    /// A file that it names cannot be read.
    #[error("{0}")]
    File(String),
    /// A material has a colour that is none.
    #[error("{file}: line {line}: Kd must be one or three numbers, found {found:?}")]
    Colour {
        /// The material library.
        file: String,
        /// Line in it, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// A material's picture cannot be read.
    #[error("{file}: {source}")]
    Picture {
        /// The picture.
        file: String,
        /// Why.
        source: RasterError,
    },
    /// A coordinate is not a finite number.
    #[error("facet {facet} of the model has a coordinate that is not a finite number")]
    NotFinite {
        /// The facet, from 0.
        facet: usize,
    },
    /// There is nothing in it.
    #[error("the model holds no facets")]
    Empty,
}

/// Triangles around the mirror, in the part frame: the matt colour (`Kd`) or picture (`map_Kd`) of
/// their materials, seen from both sides, in the light of a sky and of a lamp above (+Z). They throw no
/// shadows.
#[derive(Debug, Clone)]
pub struct Model {
    scene: Scene,
    materials: Vec<TexturedMaterial>,
    facets: Vec<TexturedFacet>,
}

#[derive(Debug, Clone)]
struct TexturedMaterial {
    matter: Material,
    picture: Option<MipPyramid>,
}

#[derive(Debug, Clone, Copy)]
struct TexturedFacet {
    material: usize,
    /// Places of its corners in the material's picture: shares from the left and from the foot.
    places: [DVec2; 3],
}

const LIGHTS: Lighting = Lighting { up: DVec3::Z, lamp: DVec3::new(0.36, -0.48, 0.8) };

impl Model {
    /// Reads an OBJ whose unit is `unit_mm`; `read` gives the bytes of the files beside it that it
    /// names.
    ///
    /// # Errors
    /// [`ModelError`].
    pub fn read(
        obj: &[u8],
        unit_mm: f64,
        read: impl Fn(&Path) -> Result<Vec<u8>, String>,
    ) -> Result<Self, ModelError> {
        let options = tobj::LoadOptions {
            triangulate: true,
            ignore_points: true,
            ignore_lines: true,
            ..Default::default()
        };
        let failure = RefCell::new(None);
        let library = |path: &Path| {
            let bytes = read(path).map_err(ModelError::File);
            let text = bytes.and_then(|bytes| checked(path, &String::from_utf8_lossy(&bytes)));
            text.map_or_else(
                |error| {
                    failure.borrow_mut().get_or_insert(error);
                    Err(tobj::LoadError::OpenFileFailed)
                },
                |text| tobj::load_mtl_buf(&mut text.as_bytes()),
            )
        };
        let (models, library) = tobj::load_obj_buf(&mut Cursor::new(obj), &options, library)
            .map_err(ModelError::Obj)?;
        if let Some(error) = failure.into_inner() {
            return Err(error);
        }
        let library = library.map_err(ModelError::Obj)?;
        let plain = TexturedMaterial { matter: Material::new(PLAIN, 0.0), picture: None };
        let mut materials = vec![plain];
        for material in &library {
            materials.push(TexturedMaterial::new(material, &read)?);
        }
        let (mesh, facets) = gathered(&models, unit_mm, materials.len())?;
        Ok(Self { scene: Scene::new(mesh), materials, facets })
    }
}

impl TexturedMaterial {
    fn new(
        from: &tobj::Material,
        read: impl Fn(&Path) -> Result<Vec<u8>, String>,
    ) -> Result<Self, ModelError> {
        let mut matter = Material::new(PLAIN, 0.0);
        if let Some(colour) = from.diffuse {
            matter.colour = colour.map(|c| c as f32);
        }
        let Some(file) = &from.diffuse_texture else { return Ok(Self { matter, picture: None }) };
        // Windows' paths are understood everywhere.
        let name = picture_name(file).replace('\\', "/");
        let bytes = read(Path::new(&name)).map_err(ModelError::File)?;
        let picture =
            Raster::decode(&bytes).map_err(|source| ModelError::Picture { file: name, source })?;
        Ok(Self { matter, picture: Some(MipPyramid::new(picture)) })
    }
}

/// The name in a `map_Kd` line, which may hold blanks: what follows the options, each of which has a word
/// or numbers.
fn picture_name(line: &str) -> &str {
    let mut rest = line.trim();
    while rest.starts_with('-') {
        let mut words = rest.split_whitespace();
        let (option, value) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        rest = after(after(rest, option), value);
        while let Some(number) = rest.split_whitespace().next().filter(|w| w.parse::<f64>().is_ok())
        {
            rest = after(rest, number);
        }
    }
    rest
}

/// What follows the word that `text` starts with.
fn after<'a>(text: &'a str, word: &str) -> &'a str {
    text.strip_prefix(word).unwrap_or(text).trim_start()
}

/// The lines of a material library that are understood: names, matt colours and pictures.
fn checked(path: &Path, text: &str) -> Result<String, ModelError> {
    let mut out = String::new();
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("newmtl" | "map_Kd") => out.push_str(line.trim()),
            Some("Kd") => {
                let rest: Vec<&str> = words.collect();
                let numbers: Vec<f64> = rest
                    .iter()
                    .filter_map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()))
                    .collect();
                let [r, g, b] = match numbers[..] {
                    [grey] if rest.len() == 1 => [grey; 3],
                    [r, g, b] if rest.len() == 3 => [r, g, b],
                    _ => {
                        let (file, line) = (path.display().to_string(), index + 1);
                        return Err(ModelError::Colour { file, line, found: rest.join(" ") });
                    }
                };
                out.push_str(&format!("Kd {r} {g} {b}"));
            }
            _ => continue,
        }
        out.push('\n');
    }
    Ok(out)
}

/// The triangles of all parts, and what is on them.
fn gathered(
    models: &[tobj::Model],
    unit_mm: f64,
    materials: usize,
) -> Result<(TriMesh, Vec<TexturedFacet>), ModelError> {
    let (mut mesh, mut facets) = (TriMesh::default(), Vec::new());
    for tobj::Model { mesh: part, .. } in models {
        let first = mesh.vertices.len() as u32;
        let vertices = part.positions.chunks_exact(3).map(DVec3::from_slice);
        mesh.vertices.extend(vertices.map(|v| v * unit_mm));
        let material = part.material_id.map_or(0, |id| id + 1).min(materials - 1);
        for (k, corners) in part.indices.chunks_exact(3).enumerate() {
            let triangle = [corners[0], corners[1], corners[2]].map(|v| v + first);
            if !triangle.iter().all(|&v| mesh.vertices[v as usize].is_finite()) {
                return Err(ModelError::NotFinite { facet: mesh.triangles.len() });
            }
            let place = |corner: usize| {
                let index = part.texcoord_indices.get(3 * k + corner)?;
                let at = part.texcoords.get(2 * *index as usize..)?;
                Some(DVec2::new(*at.first()?, *at.get(1)?))
            };
            let places = [0, 1, 2].map(|corner| place(corner).unwrap_or_default());
            mesh.triangles.push(triangle);
            facets.push(TexturedFacet { material, places });
        }
    }
    if facets.is_empty() { Err(ModelError::Empty) } else { Ok((mesh, facets)) }
}

impl World for Model {
    fn light(&self, ray: &Ray, footprint_rad: f64) -> [f32; 3] {
        let Some(hit) = self.scene.nearest_hit(ray) else { return backdrop(ray.direction.z) };
        let facet = &self.facets[hit.facet as usize];
        let TexturedMaterial { mut matter, ref picture } = self.materials[facet.material];
        let area = self.scene.mesh().area_vector(hit.facet as usize);
        if let Some(picture) = picture {
            let [a, b, c] = facet.places;
            let [p, q, r] = hit.barycentric;
            let at = a * p + b * q + c * r;
            let [width, height] = picture.size();
            let texels = (b - a).perp_dot(c - a).abs() * (width * height) as f64;
            let per_mm = (texels / area.length()).sqrt();
            let v = 1.0 - at.y;
            matter.colour = picture.light(at.x, v - v.floor(), footprint_rad * hit.t * per_mm);
        }
        let normal = area.normalize_or(DVec3::Z);
        let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        LIGHTS.shade(&matter, normal, ray.direction, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALLS: &str = "mtllib walls.mtl
v 10 -5 -5\nv 10 5 -5\nv 10 5 5\nv 10 -5 5
v -10 -5 -5\nv -10 5 -5\nv -10 5 5\nv -10 -5 5
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
usemtl red\nf 1 2 3 4
usemtl shown\nf 5/1 6/2 7/3 8/4
";
    const LIBRARY: &str = "newmtl red\nKa 1\nKd 0.8 0.1 0.1\nNs 3\n\nnewmtl shown\nKd 1\nmap_Kd -s 1 1 1 dir\\four.png\n";

    /// Four pixels: red, green over blue, white.
    fn four() -> Vec<u8> {
        let rgb = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]];
        Raster { width: 2, height: 2, rgb }.to_png().unwrap()
    }

    fn model(obj: &str, library: &str, unit_mm: f64) -> Result<Model, ModelError> {
        Model::read(obj.as_bytes(), unit_mm, |path| match path.to_str() {
            Some("walls.mtl") => Ok(library.into()),
            Some("dir/four.png") => Ok(four()),
            other => Err(format!("cannot read {other:?}")),
        })
    }

    fn seen(model: &Model, direction: DVec3) -> [f32; 3] {
        model.light(&Ray { origin: DVec3::ZERO, direction: direction.normalize() }, 1e-6)
    }

    #[test]
    fn names_of_pictures_may_hold_blanks_and_stand_after_options() {
        for (line, name) in [
            ("tex.png", "tex.png"),
            (" my tex.png", "my tex.png"),
            ("-o 0.5 0.5 -clamp on my tex.png", "my tex.png"),
            ("-bm 2 a-b.png", "a-b.png"),
        ] {
            assert_eq!(picture_name(line), name, "{line}");
        }
    }

    #[test]
    fn walls_have_the_colours_of_their_materials() {
        let model = model(WALLS, LIBRARY, 2.0).unwrap();
        let [r, g, b] = seen(&model, DVec3::X);
        assert!(r > 0.2 && (g / r - 0.125).abs() < 1e-6 && g == b, "{r} {g} {b}");
        // Seen from inside along -X: the picture's u grows along Y, v along Z.
        let corner = |y: f64, z: f64| seen(&model, DVec3::new(-10.0, y, z));
        for (place, brightest) in [
            ((-2.5, 2.5), [true, false, false]),
            ((2.5, 2.5), [false, true, false]),
            ((-2.5, -2.5), [false, false, true]),
            ((2.5, -2.5), [true; 3]),
        ] {
            let light = corner(place.0, place.1);
            assert_eq!(light.map(|c| c > 0.1), brightest, "{place:?} {light:?}");
        }
        assert_eq!(seen(&model, DVec3::Z), backdrop(1.0));
    }

    #[test]
    fn faults_are_named() {
        let message = |obj: &str, library: &str| model(obj, library, 1.0).unwrap_err().to_string();
        for (library, expected) in [
            (
                "newmtl red\nKd 0.5 0.5\n",
                "walls.mtl: line 2: Kd must be one or three numbers, found \"0.5 0.5\"",
            ),
            ("newmtl red\n\nKd a b c\n", "walls.mtl: line 3: Kd must"),
            ("newmtl red\nmap_Kd gone.png\n", "cannot read Some(\"gone.png\")"),
            ("newmtl red\nmap_Kd walls.mtl\n", "walls.mtl: this is no PNG, JPEG or EXR picture"),
        ] {
            let found = message(WALLS, library);
            assert!(found.contains(expected), "{found}");
        }
        let renamed = WALLS.replace("walls.mtl", "other.mtl");
        assert!(message(&renamed, LIBRARY).contains("other.mtl"));
        assert!(message("v 0 0 0\n", "").contains("no facets"));
        assert!(message("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "").contains("facet 0"));
        assert!(message("v 0 0\n", "").contains("not a readable OBJ"));
        assert!(message("v 0 0 0\nf 1 2 3\n", "").contains("out of bounds"));
    }

    #[test]
    fn facets_without_materials_are_plain_and_lit_from_above() {
        let floor =
            "v -9 -9 -2\nv 9 -9 -2\nv 0 9 -2\nf 1 2 3\nv -9 -9 2\nv 9 -9 2\nv 0 9 2\nf 4 5 6\n";
        let model = model(floor, "", 1.0).unwrap();
        let [floor, ceiling] = [DVec3::NEG_Z, DVec3::Z].map(|way| seen(&model, way));
        assert!(floor[0] > 2.0 * ceiling[0] && ceiling[0] > 0.0);
    }
}
