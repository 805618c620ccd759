//! What the program says to its user. A reader that has closed the pipe has read enough; whoever cannot be told on
//! standard error, as on a full disk, still gets the exit code.

use std::io::{self, ErrorKind, Write};

use cradle_packaging::Error;

/// Writes to standard output.
pub fn say(text: impl std::fmt::Display) -> Result<(), Error> {
    let mut output = io::stdout().lock();
    match write!(output, "{text}").and_then(|()| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Failure(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes a line to standard error.
pub fn tell(line: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "{line}");
}
