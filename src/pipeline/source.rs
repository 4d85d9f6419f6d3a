//! Where profiles come from: a file, or one of the shipped ones by its bare name; and the heights, the map, the
//! meshes and the calibration that a profile names.

use crate::export::{read_obj, read_stl};
use crate::profile::{
    Complaints, GridError, NamedFiles, Profile, ProfileFile, SagGrid, ShapeSpec, shipped,
};
use crate::publish::{self, FileError};
use std::borrow::Cow;
use std::cell::RefCell;
use std::path::Path;
use thiserror::Error;

/// Far more bytes than a profile may have, which says so itself of those that have somewhat more.
const MOST_TEXT: u64 = 16_000_000;
/// Some 200 bytes for each node of the largest grid.
const MOST_HEIGHTS: u64 = 800_000_000;
/// An STL of ten million facets, far more than a holder's or a robot's has.
const MOST_MESH: u64 = 500_000_084;

impl Profile {
    /// The measured form error that the profile names, if it names one.
    ///
    /// # Errors
    /// [`SourceError`] when its file cannot be read or has a fault.
    pub fn form_map(&self) -> Result<Option<Cow<'_, SagGrid>>, SourceError> {
        let Some(file) = &self.tolerance.map_file else { return Ok(None) };
        Ok(Some(match &self.form_map {
            Some(map) => Cow::Borrowed(map),
            None => Cow::Owned(grid(self.folder(), file)?.0),
        }))
    }

    /// The folder of the files that the profile names.
    fn folder(&self) -> &Path {
        Path::new(&self.named).parent().unwrap_or(Path::new(""))
    }

    /// With the heights that the profile names.
    fn with_heights(mut self) -> Result<Self, SourceError> {
        if let ShapeSpec::Grid { file } = &self.shape {
            let (heights, file) = grid(self.folder(), file)?;
            self.heights = Some(heights);
            self.files.push(file);
        }
        Ok(self)
    }
}

/// Why there is no profile.
#[derive(Debug, Error)]
pub enum SourceError {
    /// The file has faults, all listed.
    #[error("{0}")]
    Faulty(#[from] Complaints),
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file of heights has a fault.
    #[error("{path}: {source}")]
    Grid {
        /// The file.
        path: String,
        /// What is wrong.
        source: GridError,
    },
    /// The name cannot be a folder's.
    #[error("{named}: the file's name gives no name for the output folder; rename the file")]
    Nameless {
        /// As typed.
        named: String,
    },
    /// Neither a file nor a shipped profile.
    #[error("{named}: no such file, and no profile of that name is shipped{hint}")]
    Unknown {
        /// As typed.
        named: String,
        /// What could be meant.
        hint: String,
    },
}

/// Text of a profile, not checked yet.
#[derive(Debug, Clone)]
pub struct ProfileText {
    /// Name that output goes under.
    pub name: String,
    /// Name by which it was found: the files that it names lie beside that.
    pub named: String,
    /// TOML, as far as it is text.
    pub bytes: Cow<'static, [u8]>,
}

impl ProfileText {
    /// The text that `named` means: that of a file if there is one, else of a shipped profile.
    ///
    /// # Errors
    /// [`SourceError`] when there is none, or it cannot be read.
    pub fn find(named: &str) -> Result<Self, SourceError> {
        let path = Path::new(named);
        // A folder called like a shipped profile (an output of it, say) does not hide it.
        if let (Some(profile), false) = (Self::shipped(named), path.is_file()) {
            return Ok(profile);
        }
        if !path.exists() {
            return Err(SourceError::Unknown { named: named.into(), hint: hint(named) });
        }
        let bytes = publish::read_at_most(path, MOST_TEXT)?.into();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        if matches!(&*stem, "" | "." | "..") {
            return Err(SourceError::Nameless { named: named.into() });
        }
        Ok(Self { name: stem.into_owned(), named: named.into(), bytes })
    }

    /// The text of a shipped profile; none where none is called so.
    #[must_use]
    pub fn shipped(name: &str) -> Option<Self> {
        let profile = shipped().iter().find(|profile| profile.name == name)?;
        let (name, bytes) = (profile.name.to_owned(), profile.text.as_bytes().into());
        Some(Self { named: name.clone(), name, bytes })
    }

    /// The profile with the calibration, the map, the meshes and the heights that it names, from its own folder.
    ///
    /// # Errors
    /// [`SourceError`], with every complaint about the text.
    pub fn checked(&self) -> Result<Profile, SourceError> {
        let Self { name, named, bytes } = self;
        let folder = Path::new(named).parent().unwrap_or(Path::new(""));
        let found = RefCell::new(Vec::new());
        let read = |file: &str, most_bytes: u64| {
            let read = publish::read_named(&folder.join(file), most_bytes);
            let bytes = read.map_err(|error| error.to_string())?;
            let (mut all, one) = (found.borrow_mut(), ProfileFile::new(file, &bytes));
            if !all.contains(&one) {
                all.push(one);
            }
            Ok(bytes)
        };
        let mesh = |file: &str| {
            let bytes = read(file, MOST_MESH)?;
            let is_obj =
                Path::new(file).extension().is_some_and(|end| end.eq_ignore_ascii_case("obj"));
            let read = if is_obj { read_obj(&bytes) } else { read_stl(&bytes) };
            read.map(|found| found.mesh).map_err(|error| format!("{file}: {error}"))
        };
        let files = NamedFiles { bytes: &read, mesh: &mesh };
        let profile = Profile::parse_with(name, named, bytes, files)?;
        Profile { named: named.clone(), files: found.into_inner(), ..profile }.with_heights()
    }
}

/// What may have been meant by a name that is none.
fn hint(named: &str) -> String {
    let closest = shipped()
        .iter()
        .map(|profile| (strsim::jaro_winkler(named, profile.name), profile.name))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match closest {
        Some((likeness, name)) if likeness > 0.8 => format!("; did you mean {name}?"),
        _ => " (morion profiles lists those)".into(),
    }
}

/// Loads and checks the profile that `named` means: a file if there is one, else a shipped profile;
/// and the calibration, the map, the meshes and the heights that it names, from its own folder.
///
/// # Errors
/// [`SourceError`], with every complaint about the file.
pub fn load(named: &str) -> Result<Profile, SourceError> {
    ProfileText::find(named)?.checked()
}

/// The heights in `file`, relative to `folder`.
fn grid(folder: &Path, file: &str) -> Result<(SagGrid, ProfileFile), SourceError> {
    let path = folder.join(file);
    let bytes = publish::read_named(&path, MOST_HEIGHTS)?;
    let heights = SagGrid::parse(&bytes)
        .map_err(|source| SourceError::Grid { path: path.display().to_string(), source })?;
    Ok((heights, ProfileFile::new(file, &bytes)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{DVec3, TriMesh};
    use crate::optics::CameraModel;
    use crate::profile::Aperture;
    use std::fs;

    const GIVEN: &str = "camera.orthographic.pixels = [640, 480]
part = { width_mm = 3, height_mm = 3, base_mm = 5 }
mirror.grid.file = \"data/sag.csv\"
mesh.chord_um = 2
export.formats = [\"stl\"]
";

    #[test]
    fn heights_are_found_beside_the_profile_and_their_faults_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("given.toml");
        fs::write(&path, GIVEN).unwrap();
        let named = path.to_str().unwrap();
        let missing = load(named).unwrap_err().to_string();
        assert!(missing.contains("cannot read") && missing.contains("sag.csv"), "{missing}");

        fs::create_dir(folder.path().join("data")).unwrap();
        let mut lines: Vec<String> =
            (0..16).map(|k| format!("{},{},0.5", k % 4 - 2, k / 4 - 2)).collect();
        let write = |lines: &[String]| {
            fs::write(folder.path().join("data/sag.csv"), lines.join("\n")).unwrap();
        };
        write(&lines);
        let source = load(named).unwrap();
        assert_eq!(source.files, [ProfileFile::new("data/sag.csv", lines.join("\n").as_bytes())]);
        assert_eq!(source.heights.unwrap().z_mm, [0.5; 16]);

        lines[6] = "0,-1,low".into();
        write(&lines);
        let fault = load(named).unwrap_err().to_string();
        assert!(
            fault.ends_with(
                "sag.csv: line 7: Z must be a finite number of millimetres, found \"low\""
            ),
            "{fault}"
        );
    }

    const CALIBRATED: &str = "[camera.calibrated]
file = \"data/camera.yaml\"
distance_mm = 200
[projection.cylindrical]
azimuth_deg = [-90, 90]
elevation_deg = [-30, 30]
[layout.strip]
[method.vector-field]
degree = 12
[part]
width_mm = 60
base_mm = 5
[mesh]
chord_um = 2
[export]
formats = [\"stl\"]
";
    const CAMERA: &str = "image_width: 640
image_height: 480
K: [[820.5, 0, 331.25], [0, 819.5, 236.75], [0, 0, 1]]
D: [-0.3, 0.1, 0.001, 0]
";

    #[test]
    fn a_calibration_is_found_beside_the_profile_and_its_faults_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calibrated.toml");
        fs::write(&path, CALIBRATED).unwrap();
        fs::create_dir(folder.path().join("data")).unwrap();
        let named = path.to_str().unwrap();
        let camera = folder.path().join("data/camera.yaml");
        let fault = |text: &str| {
            fs::write(&camera, text).unwrap();
            load(named).unwrap_err().to_string()
        };
        let missing = load(named).unwrap_err().to_string();
        assert!(missing.contains("camera.calibrated.file: cannot read"), "{missing}");

        let told = fault(&CAMERA.replace("331.25", "wide"));
        let place = format!("{named}:2:8: camera.calibrated.file: data/camera.yaml: line 3: ");
        let wanted = format!("{place}K must be a finite number, found the text \"wide\"");
        assert_eq!(told.trim_end(), wanted);
        let told = fault(&CAMERA.replace("-0.3, 0.1", "-3, 0"));
        assert!(told.contains("camera.yaml: the pixel in column "), "{told}");
        assert!(told.contains("the distortion folds the picture over there"), "{told}");
        let told = fault(&"#".repeat(1_000_001));
        assert!(told.contains("it has more than 1000000 bytes"), "{told}");
        #[cfg(unix)]
        {
            fs::remove_file(&camera).unwrap();
            std::os::unix::fs::symlink("/dev/zero", &camera).unwrap();
            let told = load(named).unwrap_err().to_string();
            assert!(told.contains("it is a pipe or a device"), "{told}");
            fs::remove_file(&camera).unwrap();
        }

        fs::write(&camera, CAMERA).unwrap();
        let found = load(named).unwrap();
        assert_eq!(found.camera_file.as_deref(), Some("data/camera.yaml"));
        assert_eq!(found.files, [ProfileFile::new("data/camera.yaml", CAMERA.as_bytes())]);
        let CameraModel::Calibrated { pixels, focal_px, principal_px, distance_mm, .. } =
            found.camera
        else {
            panic!("{:?}", found.camera)
        };
        assert_eq!((pixels, focal_px), ([640, 480], [820.5, 819.5]));
        assert_eq!((principal_px, distance_mm), ([331.75, 237.25], 200.0));

        // The same numbers as keys are the same camera, which needs no file.
        let keys = "pixels = [640, 480]\nfocal_px = [820.5, 819.5]\nprincipal_px = [331.25, 236.75]\n\
                    distortion = [-0.3, 0.1, 0.001, 0]\nlens_mm = 8\nf_number = 4";
        let keys = CALIBRATED.replace("file = \"data/camera.yaml\"", keys);
        let same = Profile::parse("keys", "keys.toml", keys.as_bytes()).unwrap();
        assert_eq!((same.camera, same.camera_file), (found.camera, None));
        assert_eq!(same.lens.aperture, Some(Aperture::Pupil { pupil_mm: 2.0 }));
        assert_eq!(same.lens.focal_mm, Some(8.0));
    }

    /// A build knows another camera by the numbers of its file.
    #[test]
    fn another_calibration_is_another_input_of_a_build() {
        let read = |camera: String| {
            let read = move |_: &str, _| Ok(camera.clone().into_bytes());
            let files = NamedFiles { bytes: &read, ..NamedFiles::NONE };
            Profile::parse_with("p", "p.toml", CALIBRATED.as_bytes(), files).unwrap()
        };
        let inputs = |camera: String| super::super::build_cache::inputs(&read(camera));
        assert_eq!(inputs(CAMERA.to_owned()), inputs(CAMERA.to_owned() + "# again\n"));
        assert_ne!(inputs(CAMERA.to_owned()), inputs(CAMERA.replace("0.001", "0.002")));
    }

    /// A build knows another obstacle by the triangles of its file.
    #[test]
    fn another_mesh_of_an_obstacle_is_another_input_of_a_build() {
        let text = format!("{GIVEN}\n[[obstacle]]\nstl.file = \"bracket.stl\"\n");
        let text =
            text.replace("mirror.grid.file = \"data/sag.csv\"", "mirror.polynomial.radius_mm = -9");
        let inputs = |high: f64| {
            let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::new(0.0, 1.0, high)];
            let mesh = move |_: &str| {
                Ok(TriMesh { vertices: vertices.clone(), triangles: vec![[0, 1, 2]] })
            };
            let files = NamedFiles { mesh: &mesh, ..NamedFiles::NONE };
            let profile = Profile::parse_with("p", "p.toml", text.as_bytes(), files);
            super::super::build_cache::inputs(&profile.unwrap_or_else(|e| panic!("{e}")))
        };
        assert_eq!(inputs(2.0), inputs(2.0));
        assert_ne!(inputs(2.0), inputs(2.5));
    }
}
