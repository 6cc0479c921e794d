//! The words that name a scene: the one place where they are understood.

use super::{Scene, SceneError, families, file, thesis, twist};
use std::path::Path;

/// Prefix of the thesis' scenes.
const THESIS: &str = "thesis:";
/// Prefix of generated scenes.
const GEN: &str = "gen:";
/// What stands between a scene and the angle that it is twisted by.
const TWIST: &str = "+twist=";

impl Scene {
    /// Generates or reads the scene called `spec`: `thesis:LEVEL`, `gen:NAME:TRIANGLES[:SEED]`, or the path of a file; with
    /// `+twist=DEGREES` behind it, the same scene with its vertices moved by [`twist`].
    ///
    /// # Errors
    /// [`SceneError`], always one line.
    pub fn load(spec: &str) -> Result<Self, SceneError> {
        Self::load_watched(spec, &mut |_, _| {})
    }

    /// As [`Self::load`]; `progress` is told how many bytes of a file have been read, of how many.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_watched(spec: &str, progress: &mut file::LoadProgress<'_>) -> Result<Self, SceneError> {
        if let Some((still, degrees)) = spec.split_once(TWIST).filter(|_| !Path::new(spec).exists()) {
            return load_twisted(spec, still, degrees, progress);
        }
        let mut scene = if let Some(name) = spec.strip_prefix(THESIS) {
            load_level(spec, name)?
        } else if let Some(words) = spec.strip_prefix(GEN) {
            load_family(spec, words)?
        } else {
            load_file(spec, progress)?
        };
        scene.name = spec.to_owned();
        Ok(scene)
    }
}

fn load_twisted(
    spec: &str,
    still: &str,
    degrees: &str,
    progress: &mut file::LoadProgress<'_>,
) -> Result<Scene, SceneError> {
    let angle = degrees.parse().ok().filter(|angle: &f64| angle.is_finite());
    let angle = angle.ok_or_else(|| unknown(spec, format!("a number of degrees is wanted behind {TWIST}")))?;
    let mut scene = Scene::load_watched(still, progress)?;
    if !twist(&mut scene, angle) {
        return Err(unknown(spec, "it is too large to be twisted: vertices would become infinite".into()));
    }
    scene.name = spec.to_owned();
    Ok(scene)
}

fn load_level(spec: &str, name: &str) -> Result<Scene, SceneError> {
    match thesis::LEVELS.iter().find(|info| info.name == name) {
        Some(info) => Ok(thesis::generate(info.level)),
        None => Err(unknown(spec, format!("there is no such level{}", did_you_mean(name, &level_names())))),
    }
}

fn load_family(spec: &str, words: &str) -> Result<Scene, SceneError> {
    let mut words = words.split(':');
    let name = words.next().unwrap_or_default();
    let Some(family) = families::FAMILIES.iter().find(|family| family.name == name) else {
        let hint = did_you_mean(name, &family_names());
        return Err(unknown(spec, format!("there is no such family{hint}")));
    };
    let form = format!("the form is {GEN}{name}:TRIANGLES[:SEED]");
    let most = families::MOST_TRIANGLES;
    let count = match words.next().map(str::parse) {
        Some(Ok(count)) if (1..=most).contains(&count) => count,
        Some(_) => {
            return Err(unknown(spec, format!("the triangles must be a number from 1 to {most}; {form}")));
        }
        None => return Err(unknown(spec, format!("the number of triangles is missing; {form}"))),
    };
    let seed = match words.next().map(str::parse) {
        Some(Ok(seed)) => seed,
        Some(Err(_)) => {
            return Err(unknown(spec, format!("the seed must be a number from 0 to 2^64 - 1; {form}")));
        }
        None => families::DEFAULT_SEED,
    };
    match words.next() {
        Some(_) => Err(unknown(spec, format!("there are too many parts; {form}"))),
        None => Ok(family.generate(count, seed)),
    }
}

/// A word without an ending that names no file is a slip of the pen, not a file that is missing.
fn load_file(spec: &str, progress: &mut file::LoadProgress<'_>) -> Result<Scene, SceneError> {
    let path = Path::new(spec);
    if path.extension().is_none() && !path.exists() {
        let hint = did_you_mean(spec, &[level_names(), family_names()].concat());
        return Err(unknown(spec, format!("it is neither {THESIS}… nor {GEN}… nor a file{hint}")));
    }
    file::load_watched(path, progress)
}

fn unknown(spec: &str, reason: String) -> SceneError {
    SceneError::Unknown { spec: spec.escape_debug().to_string(), reason }
}

fn level_names() -> Vec<String> {
    thesis::LEVELS.iter().map(|info| format!("{THESIS}{}", info.name)).collect()
}

fn family_names() -> Vec<String> {
    families::FAMILIES.iter().map(|family| format!("{GEN}{}", family.name)).collect()
}

/// `; did you mean a or b?` with the nearest of `names`, or nothing where none is near.
fn did_you_mean(word: &str, names: &[String]) -> String {
    let short = |name: &str| name.split_once(':').map_or(usize::MAX, |(_, bare)| edit_distance(word, bare));
    let distances: Vec<_> = names.iter().map(|name| edit_distance(word, name).min(short(name))).collect();
    let least = distances.iter().copied().min().unwrap_or(usize::MAX);
    if least > word.chars().count().div_ceil(3).min(4) {
        return String::new();
    }
    let nearest: Vec<_> =
        names.iter().zip(distances).filter(|&(_, d)| d == least).map(|(name, _)| format!("'{name}'")).take(3).collect();
    format!("; did you mean {}?", nearest.join(" or "))
}

/// Levenshtein's distance, in characters.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, &y) in b.iter().enumerate() {
            let cost = (diagonal + usize::from(x != y)).min(row[j] + 1).min(row[j + 1] + 1);
            diagonal = std::mem::replace(&mut row[j + 1], cost);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_load_by_name() {
        let scene = Scene::load("thesis:tiny").unwrap();
        assert_eq!((scene.name.as_str(), scene.triangles.len()), ("thesis:tiny", 648));
    }

    #[test]
    fn families_load_by_name_count_and_seed() {
        let scene = Scene::load("gen:soup:30").unwrap();
        assert_eq!((scene.name.as_str(), scene.triangles.len()), ("gen:soup:30", 30));
        let seeded = |spec| Scene::load(spec).unwrap().triangles;
        assert_eq!(seeded("gen:soup:30:1"), scene.triangles);
        assert_ne!(seeded("gen:soup:30:2"), scene.triangles);
    }

    #[test]
    fn any_scene_can_be_twisted() {
        let (still, twisted) = (Scene::load("gen:soup:30").unwrap(), Scene::load("gen:soup:30+twist=-40.5").unwrap());
        assert_eq!((twisted.name.as_str(), twisted.triangles.len()), ("gen:soup:30+twist=-40.5", 30));
        assert_ne!(still.triangles, twisted.triangles);
        assert_eq!(
            Scene::load("thesis:tiny+twist=0").unwrap().triangles,
            Scene::load("thesis:tiny").unwrap().triangles
        );
    }

    #[test]
    fn unknown_words_are_told_in_one_line_with_the_nearest_names() {
        for (spec, expected) in [
            ("thesis:smal", "did you mean 'thesis:small'?"),
            ("thesis:", "no such level"),
            ("gen:sphere:10", "did you mean 'gen:spheres'?"),
            ("gen:soup", "number of triangles is missing; the form is gen:soup:TRIANGLES[:SEED]"),
            ("gen:soup:0", "from 1 to"),
            ("gen:soup:-3", "from 1 to"),
            ("gen:soup:99999999999999999999999", "from 1 to"),
            ("gen:soup:1000000000", "from 1 to"),
            ("gen:soup:3:x", "seed must be"),
            ("gen:soup:3:1:4", "too many parts"),
            ("gen:soup:3+twist=", "number of degrees"),
            ("gen:soup:3+twist=inf", "number of degrees"),
            ("gen:soup:3+twist=1+twist=1", "number of degrees"),
            ("gen:sop:3+twist=1", "did you mean 'gen:soup'?"),
            ("soup", "did you mean 'gen:soup'?"),
            ("tiny", "did you mean 'thesis:tiny'?"),
            ("nothing\nlike it", "nothing\\nlike it"),
            ("", "unknown scene ''"),
        ] {
            let error = Scene::load(spec).unwrap_err();
            let line = error.to_string();
            assert!(matches!(error, SceneError::Unknown { .. }), "{line}");
            assert!(line.contains(expected) && !line.contains('\n'), "{line}");
        }
    }

    #[test]
    fn edit_distances() {
        for (a, b, distance) in [("", "abc", 3), ("kitten", "sitting", 3), ("same", "same", 0), ("ab", "ba", 2)] {
            assert_eq!(edit_distance(a, b), distance);
        }
    }
}
