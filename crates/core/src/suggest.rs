//! "Did you mean": the nearest of the names that would have been right.

/// A tail for an error line: the nearest name if one is near, else all of them.
pub fn among(text: &str, names: &[&str]) -> String {
    let near = names
        .iter()
        .map(|name| {
            (
                strsim::damerau_levenshtein(&text.to_lowercase(), &name.to_lowercase()),
                name,
            )
        })
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, name)| *distance <= 2.max(name.len() / 3));
    match near {
        Some((_, name)) => format!("; did you mean \"{name}\"?"),
        None if names.is_empty() => String::new(),
        None => format!("; use one of: {}", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_the_nearest_or_lists_all() {
        assert_eq!(
            super::among("gausian", &["box", "gaussian"]),
            "; did you mean \"gaussian\"?"
        );
        assert_eq!(
            super::among("sharp", &["box", "tent"]),
            "; use one of: box, tent"
        );
    }
}
