//! The time of generation.

use crate::error::Error;

/// The time of generation as `YYYY-MM-DDThh:mm:ssZ`: what `SOURCE_DATE_EPOCH` asks for, or 1980-01-01, the earliest
/// time that a zip file can hold. The clock is not asked, so that the same arguments give the same bytes.
pub fn generation() -> Result<String, Error> {
    let Ok(text) = std::env::var("SOURCE_DATE_EPOCH") else { return Ok(iso_8601(ZIP_EPOCH)) };
    let seconds =
        text.parse().ok().filter(|seconds| *seconds <= MAX_SECONDS).ok_or_else(|| {
            Error::Usage(format!("SOURCE_DATE_EPOCH = {text} is refused; allowed: 0 to {MAX_SECONDS} s"))
        })?;
    Ok(iso_8601(seconds))
}

/// 1980-01-01, s since 1970.
const ZIP_EPOCH: u64 = 315_532_800;

/// The end of the year 9999.
const MAX_SECONDS: u64 = 253_402_300_799;

fn iso_8601(seconds: u64) -> String {
    let (mut days, second) = (seconds / 86_400, seconds % 86_400);
    let mut year = 1970;
    while days >= days_of(year) {
        days -= days_of(year);
        year += 1;
    }
    let february = if days_of(year) == 366 { 29 } else { 28 };
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if days < length {
            break;
        }
        days -= length;
        month += 1;
    }
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{:02}T{hour:02}:{minute:02}:{second:02}Z", days + 1)
}

fn days_of(year: u64) -> u64 {
    let leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    if leap { 366 } else { 365 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(iso_8601(0), "1970-01-01T00:00:00Z");
        assert_eq!(iso_8601(ZIP_EPOCH), "1980-01-01T00:00:00Z");
        assert_eq!(iso_8601(951_827_696), "2000-02-29T12:34:56Z");
        assert_eq!(iso_8601(1_735_689_599), "2024-12-31T23:59:59Z");
        assert_eq!(iso_8601(MAX_SECONDS), "9999-12-31T23:59:59Z");
    }
}
