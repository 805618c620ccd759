//! Output for the user. That a reader has closed the pipe is no error; where standard error cannot be written, as on a
//! full disk, the exit code remains.

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
