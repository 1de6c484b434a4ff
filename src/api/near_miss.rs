//! What somebody may have meant who wrote a name that does not exist.

use std::fmt;

/// The known name that is nearest to a wrong one, if it is near. Shown as the end of a sentence: `; did you mean "phong"?`
pub(super) enum NearMiss<'a> {
    None,
    /// The same but for upper and lower case.
    Case(&'a str),
    Spelling(&'a str),
}

impl<'a> NearMiss<'a> {
    pub fn among(wrong: &str, known: impl Iterator<Item = &'a str> + Clone) -> Self {
        let trimmed = wrong.trim();
        if let Some(name) = known.clone().find(|name| name.eq_ignore_ascii_case(trimmed)) {
            return if name == trimmed { Self::Spelling(name) } else { Self::Case(name) };
        }
        // One letter in three may be wrong.
        let most = (trimmed.len() / 3).max(1);
        let near = known.map(|name| (distance(trimmed, name), name)).min_by_key(|(distance, _)| *distance);
        match near {
            Some((distance, name)) if distance <= most => Self::Spelling(name),
            _ => Self::None,
        }
    }
}

impl fmt::Display for NearMiss<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => Ok(()),
            Self::Case(name) => write!(f, "; did you mean \"{name}\"? Upper and lower case count"),
            Self::Spelling(name) => write!(f, "; did you mean \"{name}\"?"),
        }
    }
}

/// Longest name that is looked at; others are far from everything.
const LONGEST: usize = 32;

/// Letters to insert, delete or change (Levenshtein 1966), case aside.
fn distance(a: &str, b: &str) -> usize {
    if a.len() > LONGEST || b.len() > LONGEST {
        return usize::MAX;
    }
    let mut row: [usize; LONGEST + 1] = std::array::from_fn(|i| i);
    for (i, x) in a.bytes().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.bytes().enumerate() {
            let changed = diagonal + usize::from(!x.eq_ignore_ascii_case(&y));
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_misses_are_named_and_others_are_not() {
        let known = ["phong", "diffuse", "latlong", "glass"];
        let told = |wrong: &str| NearMiss::among(wrong, known.into_iter()).to_string();
        assert_eq!(told("Phong"), "; did you mean \"phong\"? Upper and lower case count");
        assert_eq!(told("phong "), "; did you mean \"phong\"?");
        assert_eq!(told("difuse"), "; did you mean \"diffuse\"?");
        assert_eq!(told("GLAS"), "; did you mean \"glass\"?");
        for wrong in ["", "banana", "x", &"phong".repeat(20)] {
            assert_eq!(told(wrong), "", "{wrong}");
        }
        assert_eq!((distance("kitten", "sitting"), distance("", "abc"), distance("abc", "")), (3, 3, 3));
    }
}
