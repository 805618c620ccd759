//! The log of an instance: enabled categories and the host's sink.

use std::fmt::Arguments;

use crate::engine::Pulse;
use crate::variables::LogCategory;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    Ok,
    /// Something is doubtful; the run goes on.
    Warning,
    /// A refused value that changes nothing (fmi3Discard).
    Discard,
    /// A refused call or a failed step.
    Error,
    /// The instance is lost.
    Fatal,
}

pub type LogSink = Box<dyn Fn(Severity, LogCategory, &str)>;

/// The log of one instance: lines of the categories that the host has switched on and, if it insists, all warnings and
/// errors.
pub struct Log {
    sink: Option<LogSink>,
    enabled: [bool; LogCategory::ITEMS.len()],
    insists: bool,
}

impl Log {
    /// A log to `sink`, or to nowhere. `on` switches all categories on. A log that `insists` always writes warnings and
    /// errors.
    pub fn new(sink: Option<LogSink>, on: bool, insists: bool) -> Self {
        Self { sink, enabled: [on; LogCategory::ITEMS.len()], insists }
    }

    /// Switches `categories` on or off, all of them if there are none; the others stay as they are.
    pub fn switch(&mut self, on: bool, categories: &[LogCategory]) {
        if categories.is_empty() {
            self.enabled.fill(on);
        }
        categories.iter().for_each(|category| self.enabled[*category as usize] = on);
    }

    /// Whether a line of `category` that is no warning or error would be written.
    pub fn wants(&self, category: LogCategory) -> bool {
        self.sink.is_some() && self.enabled[category as usize]
    }

    pub fn write(&self, severity: Severity, category: LogCategory, text: Arguments<'_>) {
        if let Some(sink) = &self.sink
            && (self.insists && severity >= Severity::Warning || self.wants(category))
        {
            sink(severity, category, &text.to_string());
        }
    }

    pub fn solver(&self, text: Arguments<'_>) {
        self.write(Severity::Ok, LogCategory::Solver, text);
    }

    /// Writes a line with numbers of 17 digits, which read back as the same doubles.
    pub fn pulse(&self, pulse: Pulse) {
        if !self.wants(LogCategory::Events) {
            return;
        }
        let values = Pulse::VALUES.map(|(name, of)| format!(" {name}={:.16e}", of(&pulse)));
        let text = format_args!("contact={}{}", pulse.contact + 1, values.concat());
        self.write(Severity::Ok, LogCategory::Events, text);
    }

    pub fn error(&self, text: Arguments<'_>) {
        self.write(Severity::Error, LogCategory::Error, text);
    }
}
