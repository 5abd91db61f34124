//! Ctrl+C, SIGTERM and SIGHUP: stop at once, leave no half file.

use std::sync::Arc;

use super::console::leave_bar;
use super::exit::{Code, Failure, Outcome};
use crate::app::interrupted;
use crate::export::when_no_file_is_open;
use crate::render::Progress;

/// From now on a signal cancels `progress`, which ends a picture at its next tile and a file at its next write,
/// and then the program; a temporary file is removed before.
///
/// # Errors
/// When the system takes no handler.
pub fn watch(progress: &Arc<Progress>) -> Outcome {
    let progress = Arc::clone(progress);
    let stop = move || {
        progress.cancel();
        leave_bar();
        interrupted();
        // Reading, parsing and building know nothing of cancelling: the program ends here, in the handler's
        // thread, and does not wait for them.
        when_no_file_is_open(|| std::process::exit(Code::Interrupted as i32))
    };
    ctrlc::set_handler(stop).map_err(|e| Failure::Failed(format!("cannot watch for Ctrl+C: {e}")))
}
