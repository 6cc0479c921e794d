//! The words that name a scene: the one place where they are understood.

use super::{Scene, SceneError, thesis};

/// Prefix of the thesis' scenes.
const THESIS: &str = "thesis:";

impl Scene {
    /// Generates or reads the scene called `spec`: `thesis:LEVEL`.
    ///
    /// # Errors
    /// [`SceneError`], always one line.
    pub fn load(spec: &str) -> Result<Self, SceneError> {
        if let Some(name) = spec.strip_prefix(THESIS) {
            return load_level(spec, name);
        }
        Err(unknown(
            spec,
            format!("it is no known kind of scene{}", did_you_mean(spec, &all_names())),
        ))
    }
}

fn load_level(spec: &str, name: &str) -> Result<Scene, SceneError> {
    let names: Vec<String> = thesis::LEVELS
        .iter()
        .map(|info| format!("{THESIS}{}", info.name))
        .collect();
    match thesis::LEVELS.iter().find(|info| info.name == name) {
        Some(info) => Ok(thesis::generate(info.level)),
        None => Err(unknown(
            spec,
            format!("there is no such level{}", did_you_mean(spec, &names)),
        )),
    }
}

fn unknown(spec: &str, reason: String) -> SceneError {
    SceneError::Unknown {
        spec: spec.escape_debug().to_string(),
        reason,
    }
}

fn all_names() -> Vec<String> {
    thesis::LEVELS
        .iter()
        .map(|info| format!("{THESIS}{}", info.name))
        .collect()
}

/// `; did you mean a or b?` with the nearest of `names`, or nothing where none is near.
fn did_you_mean(word: &str, names: &[String]) -> String {
    let short = |name: &str| {
        name.split_once(':')
            .map_or(usize::MAX, |(_, bare)| edit_distance(word, bare))
    };
    let distances: Vec<_> = names
        .iter()
        .map(|name| edit_distance(word, name).min(short(name)))
        .collect();
    let least = distances.iter().copied().min().unwrap_or(usize::MAX);
    if least > word.chars().count().div_ceil(3).min(4) {
        return String::new();
    }
    let nearest: Vec<_> = names
        .iter()
        .zip(distances)
        .filter(|&(_, d)| d == least)
        .map(|(name, _)| format!("'{name}'"))
        .take(3)
        .collect();
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
    fn unknown_words_are_told_in_one_line_with_the_nearest_names() {
        for (spec, expected) in [
            ("thesis:smal", "did you mean 'thesis:small'?"),
            ("thesis:", "no such level"),
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
        for (a, b, distance) in [
            ("", "abc", 3),
            ("kitten", "sitting", 3),
            ("same", "same", 0),
            ("ab", "ba", 2),
        ] {
            assert_eq!(edit_distance(a, b), distance);
        }
    }
}
