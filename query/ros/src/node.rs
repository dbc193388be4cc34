//! The node: its topics, and what comes in by them.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, anyhow};
use futures::channel::mpsc::{UnboundedSender, unbounded};
use futures::executor::block_on;
use futures::stream::{LocalBoxStream, StreamExt as _, select_all};
use grasp_answer::index_file::{self, IndexFileError};
use grasp_terminal::error::message as in_words;
use grasp_terminal::text::counted;
use ros2_client::qos::{History, WhenFull};
use ros2_client::{
    Context, Name, Node, NodeName, NodeOptions, ParameterValue, Publisher, QosProfile, Subscription,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::answer::grasp::Robot;
use crate::arguments::{Arguments, Options, Transport};
use crate::domain::Domain;
use crate::log::{Level, Log};
use crate::messages::Message;
use crate::messages::geometry::PoseStamped;
use crate::messages::sensor::{CameraInfo, CompressedImage, Image};
use crate::names::{Names, beside};
use crate::newest::Newest;
use crate::worker::{Answers, Job, Picture, Tally, Worker};

/// What comes in.
enum Event {
    Picture(Picture),
    Info(Arc<CameraInfo>),
    Object(Arc<PoseStamped>),
    /// A message that cannot be read, by its topic.
    Unreadable(String, String),
    /// The end.
    Stop,
}

/// Pictures are sensor data: the newest counts, and what is lost is lost. A reader without
/// guarantees is given what writers with and without them send.
fn to_read() -> QosProfile {
    QosProfile::subscription_default()
}

/// Answers arrive; but a reader that has stopped keeps nobody waiting.
fn to_publish() -> QosProfile {
    QosProfile::publisher_default()
        .history(History::KeepLast { depth: 10 })
        .reliability_reliable(WhenFull::Wait(Duration::from_millis(5)))
}

/// How long to wait for a first picture before a warning.
const PATIENCE: Duration = Duration::from_secs(10);

/// The topics' full names.
#[derive(Debug)]
struct Topics {
    pictures: String,
    info: String,
    object: String,
    detections: String,
    pose: String,
    markers: String,
    grasp: String,
}

impl Topics {
    fn new(names: &Names, transport: Transport) -> anyhow::Result<Self> {
        let image = names.topic("image")?;
        Ok(Self {
            // Where a camera puts it, unless it is told otherwise.
            info: names.remapped("camera_info")?.unwrap_or_else(|| beside(&image, "camera_info")),
            pictures: match transport {
                Transport::Raw => image,
                Transport::Compressed => format!("{image}/compressed"),
            },
            object: names.topic("object_pose")?,
            detections: names.topic("~/detections")?,
            pose: names.topic("~/pose")?,
            markers: names.topic("~/markers")?,
            grasp: names.topic("~/grasp")?,
        })
    }
}

fn reader<M: Message + 'static>(node: &mut Node, topic: &str) -> anyhow::Result<Subscription<M>> {
    let name = Name::parse(topic)?;
    let made = node.create_topic(&name, M::type_name(), &to_read());
    let made = made.and_then(|topic| node.create_subscription(&topic, None));
    made.map_err(|error| anyhow!("cannot read {topic}: {error}"))
}

fn writer<M: Message + Serialize>(node: &mut Node, topic: &str) -> anyhow::Result<Publisher<M>> {
    let name = Name::parse(topic)?;
    let made = node.create_topic(&name, M::type_name(), &to_publish());
    let made = made.and_then(|topic| node.create_publisher(&topic, None));
    made.map_err(|error| anyhow!("cannot publish {topic}: {error}"))
}

/// What comes in by a topic.
fn events<'a, M: DeserializeOwned + 'static>(
    subscription: &'a Subscription<M>,
    topic: &'a str,
    event: impl Fn(M) -> Event + 'a,
) -> LocalBoxStream<'a, Event> {
    let read = move |message: Result<(M, _), ros2_client::ReadError>| match message {
        Ok((message, _)) => event(message),
        Err(error) => Event::Unreadable(topic.to_owned(), error.to_string()),
    };
    subscription.async_stream().map(read).boxed_local()
}

/// The parameters; none of them can be changed while the node runs.
fn node_options(options: &Options) -> NodeOptions {
    let declared = options.parameters();
    let fixed = declared.clone();
    let validator = move |name: &str, value: &ParameterValue| {
        let known = fixed.iter().find(|(known, _)| *known == name);
        match known {
            Some((_, own)) if own != value => {
                Err(format!("{name} is read when the node starts: start it anew with -p {name}:=VALUE"))
            }
            _ => Ok(()),
        }
    };
    let node = NodeOptions::new().parameter_validator(Box::new(validator));
    declared.into_iter().fold(node, |node, (name, value)| node.declare_parameter(name, value))
}

/// Runs the node until it is told to end.
///
/// # Errors
/// Where it cannot begin; and where the index is changed under it.
pub(crate) fn run(arguments: Arguments) -> anyhow::Result<()> {
    let Arguments { options, names, level, ignored } = arguments;
    let index_path = options.index().unwrap_or_else(index_file::default_path);
    let index = index_file::open_for_pictures(&index_path, options.no_mmap).map_err(|error| match error {
        IndexFileError::Missing { .. } => anyhow!("{error}, or by the parameter index"),
        error => error.into(),
    })?;
    let robot = options.robot().map(|(hand, files, arm)| Robot::read(hand, files, arm, &options.world_frame));
    let robot = robot.transpose()?;
    let topics = Topics::new(&names, options.image_transport)?;
    let is_rectified = options.is_rectified(&names.topic("image")?);
    let domain = Domain::from_environment(|name| std::env::var(name).ok())?;

    let context = Context::from_domain_participant(domain.enter()?)
        .map_err(|error| anyhow!("cannot enter the graph of ROS: {error}"))?;
    let mut node = context
        .new_node(NodeName::new(names.namespace(), names.node())?, node_options(&options))
        .map_err(|error| anyhow!("cannot begin the node {}: {error}", names.node_path()))?;
    let log = Log::new(&names.node_path(), level, Some(node.logging_handle()));
    for ignored in ignored {
        log.say(Level::Warn, &format!("ignored {ignored}"));
    }

    let answers = Answers {
        detections: writer(&mut node, &topics.detections)?,
        pose: writer(&mut node, &topics.pose)?,
        markers: writer(&mut node, &topics.markers)?,
        grasp: writer(&mut node, &topics.grasp)?,
    };
    let (sender, stop) = unbounded();
    let stopping = sender.clone();
    let stopped = move || drop(stopping.unbounded_send(Event::Stop));
    ctrlc::set_handler(stopped).context("cannot listen for Ctrl-C")?;

    let info: Subscription<CameraInfo> = reader(&mut node, &topics.info)?;
    let object: Subscription<PoseStamped> = reader(&mut node, &topics.object)?;
    let mut raw: Option<Subscription<Image>> = None;
    let mut compressed: Option<Subscription<CompressedImage>> = None;
    match options.image_transport {
        Transport::Raw => raw = Some(reader(&mut node, &topics.pictures)?),
        Transport::Compressed => compressed = Some(reader(&mut node, &topics.pictures)?),
    }
    let raw = raw
        .iter()
        .map(|reader| events(reader, &topics.pictures, |image| Event::Picture(Picture::Raw(image))));
    let compressed = compressed
        .iter()
        .map(|reader| events(reader, &topics.pictures, |image| Event::Picture(Picture::Compressed(image))));
    let others = [
        events(&info, &topics.info, |info| Event::Info(Arc::new(info))),
        events(&object, &topics.object, |object| Event::Object(Arc::new(object))),
        stop.boxed_local(),
    ];
    let mut coming = select_all(raw.chain(compressed).chain(others));

    let spinner = node.spinner().map_err(|error| anyhow!("cannot offer parameters: {error}"))?;
    let spinning = thread::spawn(move || block_on(spinner.spin()));
    log.info(&format!(
        "{} of {}; pictures from {}, answers to {} and beside it, in domain {}",
        counted(index.len() as u64, ["entry", "entries"]),
        index_path.display(),
        topics.pictures,
        topics.detections,
        domain.id()
    ));

    let jobs = Newest::new();
    let worker = Worker::new(&index_path, &index, &options, is_rectified, robot, answers, &log);
    let silence = no_picture(&topics.pictures, options.image_transport);
    let tally = answer(worker, &mut coming, sender, &silence, &jobs, &log)?;
    log.info(&summary(&tally, jobs.dropped()));
    drop(coming);
    node.stop_spinner();
    if let Ok(Err(error)) = spinning.join() {
        log.say(Level::Error, &in_words([&error as &(dyn std::error::Error + 'static)]));
    }
    Ok(())
}

/// Has the pictures that are `coming` answered until the end comes, which the work sends by
/// `sender` where it ends by itself. Where no picture comes, `silence` says why that may be.
fn answer(
    worker: Worker<'_>,
    coming: &mut (impl futures::Stream<Item = Event> + Unpin),
    sender: UnboundedSender<Event>,
    silence: &str,
    jobs: &Newest<Job>,
    log: &Log,
) -> anyhow::Result<Tally> {
    thread::scope(|scope| {
        scope.spawn(|| {
            if !jobs.has_come_within(PATIENCE) {
                log.say(Level::Warn, silence);
            }
        });
        let working = scope.spawn(move || {
            // However the work ends, by a panic as well: pictures would come in vain.
            let _end = EndOnDrop(sender);
            worker.run(jobs)
        });
        block_on(receive(coming, jobs, log));
        jobs.close();
        working.join().unwrap_or_else(|_| Err(anyhow!("the work has panicked: report this")))
    })
}

/// Ends the node where it is dropped.
struct EndOnDrop(UnboundedSender<Event>);

impl Drop for EndOnDrop {
    fn drop(&mut self) {
        // Whoever listens no more has ended.
        let _ = self.0.unbounded_send(Event::Stop);
    }
}

/// Keeps what has come last of camera and object, and hands on each picture with it.
async fn receive(coming: &mut (impl futures::Stream<Item = Event> + Unpin), jobs: &Newest<Job>, log: &Log) {
    let mut info: Option<Arc<CameraInfo>> = None;
    let mut object: Option<Arc<PoseStamped>> = None;
    while let Some(event) = coming.next().await {
        match event {
            Event::Picture(picture) => {
                let (info, object) = (info.clone(), object.clone());
                jobs.put(Job { picture, came: Instant::now(), info, object });
            }
            Event::Info(new) => info = Some(new),
            Event::Object(new) => object = Some(new),
            Event::Unreadable(topic, error) => {
                log.warn(&topic, &format!("a message on {topic} cannot be read: {error}"));
            }
            Event::Stop => return,
        }
    }
}

/// Why a node that was started wrongly seems to do nothing.
fn no_picture(topic: &str, transport: Transport) -> String {
    let (package, name) = match transport {
        Transport::Raw => Image::TYPE,
        Transport::Compressed => CompressedImage::TYPE,
    };
    format!(
        "no picture has come on {topic} in {} s: {package}/{name} is waited for there; -r image:=TOPIC names another topic, and \
         -p image_transport:= is raw or compressed",
        PATIENCE.as_secs()
    )
}

/// What was done, in a line.
fn summary(tally: &Tally, dropped: u64) -> String {
    let Tally { recognised, unknown, empty, unreadable, latencies } = tally;
    format!(
        "{} answered: {recognised} recognised, {unknown} unknown, {empty} without a hand; {dropped} dropped for newer ones, \
         {unreadable} not to be read; picture in to answer out {latencies}",
        counted(recognised + unknown + empty, ["picture", "pictures"]),
    )
}
