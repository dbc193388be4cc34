//! `grasp-query recognise --server`: the same output, by a service that is running.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::output::{Output, OutputFormat, report};
use super::{Drawings, Feed, Recognise, is_stream};
use grasp_answer::explain;
use grasp_answer::human;
use grasp_answer::record::Record;
use grasp_recognise::picture;
use grasp_serve::client::{Address, Answer, Client, ClientError, Parts};
use grasp_serve::wire::parameters::PictureParameters;
use grasp_serve::wire::{DESCRIBED, Format};

/// A picture's answer, or the record of why the service was not asked or did not want it.
enum Reply {
    /// The picture's name, and what the service says.
    Service(String, Answer),
    Own(Record),
}

/// What is asked of every picture, and whom.
struct Asking<'a> {
    client: Client,
    drawings: Option<&'a Drawings>,
    parameters: PictureParameters,
    /// All but the picture.
    parts: Parts,
    wanted: Format,
}

impl Recognise {
    /// As a run by an own index, but for who answers.
    pub(super) fn run_remote(
        &self,
        address: &Address,
        images: &[PathBuf],
        drawings: Option<&Drawings>,
    ) -> anyhow::Result<u8> {
        // What is wrong with a mask or a robot is said in the same words, and before anything is
        // sent.
        self.source()?;
        self.recognise.refuse_networks()?;
        self.index.refuse_beside_a_service()?;
        self.robot.read()?;
        let token = self.token_file.as_deref().map(crate::cli::token::read).transpose()?;
        let asking = self.asking(Client::new(address.clone(), token), drawings)?;
        let mut output = Output {
            format: self.format(),
            status: grasp_program::status::SUCCESS,
            out: io::stdout().lock(),
        };
        if let Some(camera) = self.robot.device()? {
            self.feed_remote(Feed::camera(camera)?, &asking, &mut output)?;
        }
        let at_once = 4 * rayon::current_num_threads();
        for group in super::groups(images) {
            if let [only] = group
                && is_stream(only)
            {
                self.feed_remote(Feed::Stream(only.clone()), &asking, &mut output)?;
                continue;
            }
            for batch in group.chunks(at_once) {
                let ask = |path: &PathBuf| {
                    let name = path.display().to_string();
                    match picture::read(path) {
                        Ok(bytes) => self.ask(&asking, name, None, bytes),
                        Err(error) => Ok(Reply::Own(Record::not_recognised(name, None, &error.into()))),
                    }
                };
                let replies: Vec<anyhow::Result<Reply>> = match batch {
                    [single] => vec![ask(single)],
                    several => several.par_iter().map(ask).collect(),
                };
                for reply in replies {
                    output.write_reply(&reply?)?;
                }
            }
        }
        Ok(self.status_of(&output))
    }

    fn feed_remote(
        &self,
        feed: Feed,
        asking: &Asking<'_>,
        output: &mut Output<impl Write>,
    ) -> anyhow::Result<()> {
        let name = feed.name();
        feed.each_frame(|frame, given| {
            self.refuse_more(&name, frame)?;
            let reply = match given {
                Ok(given) => {
                    // The service is sent the frame alone.
                    if let Some(warning) = given.warning() {
                        tracing::warn!(subject = human::name(&name, frame), "warning: {warning}");
                    }
                    self.ask(asking, name.clone(), frame, given.bytes)?
                }
                Err(record) => Reply::Own(record),
            };
            output.write_reply(&reply)
        })
    }

    /// What is asked of every picture.
    fn asking<'a>(&self, client: Client, drawings: Option<&'a Drawings>) -> anyhow::Result<Asking<'a>> {
        let read = |path: &Path| picture::read(path);
        let (robot, described) = self.robot.hand()?.unzip();
        let described = described.flatten();
        let [object, camera] = self.robot.files();
        let (arm, arm_file) = self.robot.arm().map_or((None, None), |(name, file)| (Some(name), file));
        let parameters = PictureParameters {
            segmented: self.segmented,
            depth_range: self.depth_range.map(|range| range.to_string()),
            timings: self.timings,
            robot: robot.map(|name| if described.is_some() { DESCRIBED } else { name }.to_owned()),
            arm: arm.map(|name| if arm_file.is_some() { DESCRIBED } else { name }.to_owned()),
            ..PictureParameters::from_options(&self.recognise.options()?)
        };
        let parts = Parts {
            picture: Vec::new(),
            mask: self.mask.as_deref().map(read).transpose()?,
            depth: self.depth.as_deref().map(read).transpose()?,
            landmarks: self.landmarks_json.as_deref().map(read).transpose()?,
            robot: described.map(String::into_bytes),
            object: object.map(read).transpose()?,
            camera: camera.map(read).transpose()?,
            arm: arm_file.map(read).transpose()?,
        };
        let wanted = match self.format() {
            OutputFormat::Json => Format::Json,
            OutputFormat::Text => Format::Text,
            OutputFormat::Moveit => Format::Moveit,
        };
        Ok(Asking { client, drawings, parameters, parts, wanted })
    }

    fn ask(
        &self,
        asking: &Asking<'_>,
        name: String,
        frame: Option<u64>,
        picture: Vec<u8>,
    ) -> anyhow::Result<Reply> {
        let Asking { client, drawings, wanted, .. } = asking;
        let parameters = PictureParameters { file: Some(name.clone()), frame, ..asking.parameters.clone() };
        let parts = Parts { picture, ..asking.parts.clone() };
        let answer = match client.recognise(&parameters, &parts, *wanted) {
            Ok(answer) => answer,
            Err(ClientError::Refused { is_picture: true, message, .. }) => {
                return Ok(Reply::Own(Record::failed(name, frame, "too_large", message)));
            }
            Err(error) => return Err(error.into()),
        };
        if let (Some(drawings), true) = (drawings, answer.is_answer) {
            let drawing = client.recognise(&parameters, &parts, Format::Drawing)?;
            self.drawn(&name, frame, drawings.path(&name, frame), |path| {
                Ok(explain::save(&decoded(&drawing.body)?, path)?)
            });
        }
        Ok(Reply::Service(human::name(&name, frame), answer))
    }
}

/// A drawing as the service sends it.
fn decoded(png: &[u8]) -> image::ImageResult<image::RgbImage> {
    Ok(image::load_from_memory_with_format(png, image::ImageFormat::Png)?.into_rgb8())
}

impl<W: Write> Output<W> {
    fn write_reply(&mut self, reply: &Reply) -> anyhow::Result<()> {
        let (name, answer) = match reply {
            Reply::Own(record) => return self.write(record),
            Reply::Service(name, answer) => (name, answer),
        };
        self.status = self.status.max(answer.exit);
        if self.format == OutputFormat::Moveit && answer.is_answer {
            self.write_message(name, &String::from_utf8_lossy(&answer.body))?;
        } else if self.format == OutputFormat::Json || answer.is_answer {
            self.out.write_all(&answer.body)?;
        } else {
            report(answer.exit, name, &String::from_utf8_lossy(&answer.body));
        }
        Ok(self.out.flush()?)
    }
}
