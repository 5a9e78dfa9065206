//! A question that the user, or a line of a script, answers with `yes`.

use std::io::BufRead;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use armbridge_client::{ctrl_c, stdio};

/// Between two looks whether ctrl-c was pressed.
const LOOK: Duration = Duration::from_millis(50);

/// Asks on standard error. Only `yes` is yes; input that ends, and ctrl-c, are no.
pub(super) fn is_agreed(question: &str) -> bool {
    stdio::note(question);
    stdio::note_text("Type yes to go on: ");
    let (sender, answers) = channel();
    // Reading waits for ever, ctrl-c or not. The thread ends with the line, or with the
    // program.
    std::thread::spawn(move || {
        let mut line = String::new();
        let read = std::io::stdin().lock().read_line(&mut line);
        // After ctrl-c nothing receives it.
        let _ = sender.send(read.map(|_| line));
    });
    loop {
        match answers.recv_timeout(LOOK) {
            Ok(answer) => {
                let is_yes = answer.is_ok_and(|line| line.trim().eq_ignore_ascii_case("yes"));
                if !is_yes {
                    stdio::note("");
                }
                return is_yes;
            }
            Err(RecvTimeoutError::Timeout) if !ctrl_c::is_raised() => {}
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                stdio::note("");
                return false;
            }
        }
    }
}
