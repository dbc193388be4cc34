//! Events as lines for people.

use std::fmt::{self, Debug, Write as _};

use grasp_terminal::text::{printable, printable_lines};
use tracing::field::{Field, Visit};
use tracing::{Event, Subscriber};
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::registry::LookupSpan;

/// `subject: message`, or the message alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lines;

impl<S, N> FormatEvent<S, N> for Lines
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(
        &self,
        _: &FmtContext<'_, S, N>,
        mut writer: Writer<'_>,
        event: &Event<'_>,
    ) -> fmt::Result {
        let mut shown = Shown::default();
        event.record(&mut shown);
        writeln!(writer, "{}", shown.line())
    }
}

/// What people see of an event.
#[derive(Debug, Default)]
struct Shown {
    subject: String,
    message: String,
}

impl Shown {
    /// Names in it may come from files and from other machines: a terminal is not changed by them.
    fn line(&self) -> String {
        let message = printable_lines(&self.message);
        if self.subject.is_empty() { message } else { format!("{}: {message}", printable(&self.subject)) }
    }
}

impl Visit for Shown {
    fn record_str(&mut self, field: &Field, value: &str) {
        if field.name() == "subject" {
            value.clone_into(&mut self.subject);
        } else {
            self.record_debug(field, &format_args!("{value}"));
        }
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        let text = match field.name() {
            "subject" => &mut self.subject,
            "message" => &mut self.message,
            _ => return,
        };
        // Writing to a String cannot fail.
        let _ = write!(text, "{value:?}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;
    use std::sync::{Arc, Mutex};
    use tracing_subscriber::layer::SubscriberExt as _;

    #[derive(Clone, Default)]
    struct Written(Arc<Mutex<Vec<u8>>>);

    impl io::Write for Written {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn people_see_subject_and_message_and_nothing_that_changes_their_terminal() {
        let written = Written::default();
        let writer = written.clone();
        let layer = tracing_subscriber::fmt::layer().event_format(Lines).with_writer(move || writer.clone());
        tracing::subscriber::with_default(tracing_subscriber::registry().with(layer), || {
            let file = "odd\u{1b}[2J.png".to_owned();
            tracing::info!(entries = 5, "grasp.idx at {}", "http://127.0.0.1:1/");
            tracing::warn!(subject = "grasp-query", "2 of 3 indexes are searched");
            tracing::warn!(subject = %file, status = 1, "no hand\nlook closer\r");
        });
        assert_eq!(
            String::from_utf8(written.0.lock().unwrap().clone()).unwrap(),
            "grasp.idx at http://127.0.0.1:1/\ngrasp-query: 2 of 3 indexes are searched\n\
             odd\\u{1b}[2J.png: no hand\nlook closer\\r\n"
        );
    }
}
