//! Cradles with a name. Their parameter files are built into the program.

/// A cradle with a name, in the form of a parameter file.
pub struct Preset {
    /// What `--preset` calls it.
    pub name: &'static str,
    /// The parameter file; its first line says what it is.
    pub file: &'static str,
}

impl Preset {
    /// One line for the help.
    pub fn title(&self) -> &'static str {
        self.file.lines().next().unwrap_or_default().trim_start_matches("# ")
    }

    /// The preset of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }
}

macro_rules! preset {
    ($name:literal) => {
        Preset { name: $name, file: include_str!(concat!("../../presets/", $name, ".toml")) }
    };
}

/// Every preset.
pub static PRESETS: &[Preset] =
    &[preset!("figure3"), preset!("figure4"), preset!("figure5"), preset!("figure6"), preset!("desk")];
