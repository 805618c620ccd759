//! Checks of names and values, with suggestions for misspelt ones.

use newtons_cradle::variables::{Row, Shape, StartValue, TABLE, Type};

/// The longest part of a user's line that a message repeats, characters.
const LONGEST_LINE: usize = 100;

/// A text for messages, with long lines cut.
pub fn brief(text: &str) -> String {
    let line = |line: &str| match line.char_indices().nth(LONGEST_LINE) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line.to_owned(),
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

/// `; did you mean "..."?` with the known name most similar to `wrong`, compared as a whole or after its last dot: at
/// most a third of its letters, or one, may differ. Empty if none is similar.
pub fn did_you_mean<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let wrong = wrong.to_lowercase();
    let distance = |name: &str| {
        let name = name.to_lowercase();
        let last = name.rsplit('.').next().unwrap_or_default();
        strsim::damerau_levenshtein(&wrong, &name).min(1 + strsim::damerau_levenshtein(&wrong, last))
    };
    let enough = (1 + wrong.chars().count() / 3).max(2);
    let like = known.into_iter().map(|name| (distance(name), name)).filter(|(far, _)| *far < enough);
    like.min().map(|(_, name)| format!("; did you mean \"{name}\"?")).unwrap_or_default()
}

/// The row of a variable that has a start value in a cradle of `balls` balls; else the reason for which it cannot be
/// set, and what can.
pub fn settable(name: &str, balls: usize) -> Result<&'static Row, String> {
    let indexed = name.strip_suffix(']').and_then(|name| name.split_once('['));
    let (family, index) = indexed.map_or((name, None), |(family, index)| (family, Some(index)));
    let Some(row) = TABLE.iter().find(|row| row.name == family) else {
        let settable = || TABLE.iter().filter(|row| row.settable());
        let mut hint = did_you_mean(family, settable().map(|row| row.name));
        if hint.is_empty() {
            let all = |row: &Row| row.name_of(if row.shape == Shape::Balls { "1..n" } else { "1..n-1" });
            let names: Vec<String> = settable().map(all).collect();
            hint = format!("; allowed: {}", names.join(", "));
        }
        return Err(format!("no variable has the name \"{name}\"{hint}"));
    };
    if !row.settable() {
        let instead = match row.name {
            "x" => "; x_start[i] is the position at the start",
            "v" => "; v_start[i] is the velocity at the start",
            "F" => "; F_ext[i] is a force on a ball",
            _ => "",
        };
        let causality = format!("{:?}", row.causality).to_lowercase();
        return Err(format!("{name} cannot be set, because its causality is {causality}{instead}"));
    }
    let count = row.shape.len(balls);
    match index {
        Some(_) if row.shape == Shape::Scalar => Err(format!("{family} is a single value and takes no index")),
        Some(index) if !index.parse().is_ok_and(|index: usize| (1..=count).contains(&index)) => {
            let allowed = if count == 0 { "there are none".to_owned() } else { format!("allowed: 1 to {count}") };
            Err(format!("{name}: index {index} is refused; {allowed}, in a cradle of {balls} ball(s)"))
        }
        _ => Ok(row),
    }
}

/// The error if a `value` of `row` is text where a number is needed, such as a number with its unit.
pub fn not_a_number(row: &Row, value: &StartValue) -> Option<String> {
    let StartValue::Item(text) = value else { return None };
    if row.access.data_type() != Type::Real {
        return None;
    }
    let refused = format!("{} = {} is refused", row.name, brief(text));
    let of_unit = |c: char| c.is_ascii_alphabetic() && !matches!(c, 'e' | 'E') || c.is_whitespace() || c == '%';
    let is_number = |text: &&str| text.parse::<f64>().is_ok();
    let number = text.find(of_unit).and_then(|end| text.get(..end)).filter(is_number);
    if is_of_other_base(text) {
        return Some(format!("{refused}; allowed: a decimal number"));
    }
    Some(match number {
        Some(number) if row.unit() == "1" => format!("{refused}: leave the unit out, {number} has no unit"),
        Some(number) => format!("{refused}: leave the unit out, {number} is in {}", row.unit()),
        None if is_number(&text.as_str()) => format!("{refused}: write the number without quotes"),
        None if text.starts_with('[') || text.ends_with(']') => format!("{refused}: write the list without brackets"),
        None => format!("{refused}; allowed: a number"),
    })
}

/// Whether a text begins like a number in base 2, 8 or 16, such as `-0x1F`.
fn is_of_other_base(text: &str) -> bool {
    let digits = text.trim_start_matches(['-', '+']).strip_prefix('0').unwrap_or_default();
    [('b', 2), ('o', 8), ('x', 16)].iter().any(|(letter, base)| {
        let digits = digits.strip_prefix([*letter, letter.to_ascii_uppercase()]);
        digits.and_then(|digits| digits.chars().next()).is_some_and(|digit| digit.is_digit(*base))
    })
}
