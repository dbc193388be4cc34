//! Faults of the program as events, where every line is to be JSON.

use std::panic::PanicHookInfo;

/// Makes an event of each panic, in place of the lines that the standard library prints.
pub(crate) fn log() {
    std::panic::set_hook(Box::new(|fault| {
        let place = fault.location().map(ToString::to_string).unwrap_or_default();
        let thread = std::thread::current();
        let message = message(fault);
        tracing::error!(place, thread = thread.name(), "a fault of the program, please report it: {message}");
    }));
}

fn message<'a>(fault: &'a PanicHookInfo<'_>) -> &'a str {
    let payload = fault.payload();
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("it has no message")
}
