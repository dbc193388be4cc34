//! `grasp-builder experiment networks`.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use grasp_program::Global;
use grasp_terminal::text::shown;
use serde_json::{Map, Value, json};

use crate::cli::plan::hand_model;
use crate::descriptor::read_network;
use crate::interrupt;
use crate::train::{Kind, Measured, measure};

/// How well trained networks do on hands that no training draws, or on a hand of your own.
///
/// All networks are asked about the same renders, drawn as for the curve of a training: other hands
/// at the grasp, seen from everywhere, and these hands in a fifth of the recorded poses. Figures
/// are named as in the curve: the share that is named rightly (`top1`), the same by the ten nearest
/// renders of hands as training draws them (`neighbours_top1`), and the median error of the
/// rotation. Networks of scenes are asked about other hands alone, and also which hand it is
/// (`side`) and for their masks (`iou`, intersection over union).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder experiment networks builder/data/hand.network
  grasp-builder experiment networks old.network new.network --scenes 480
  grasp-builder experiment networks hand.network --hand-model HAND.glb   on a mesh of your own
  grasp-builder experiment networks query/recognise/data/thing.network --kind thing --json

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(super) struct Networks {
    /// Networks of one kind, as `train` writes them.
    #[arg(required = true, value_name = "NETWORK")]
    networks: Vec<PathBuf>,
    /// What kind they are.
    #[arg(long, value_enum, default_value_t)]
    kind: Kind,
    /// Scenes that are drawn of each kind; each is seen from twelve sides. A share of right ones
    /// has a standard error of 2 points at 48 scenes, of half a point at 768. Neighbours are
    /// searched among the renders of twice as many: their figures rise with it.
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    scenes: u64,
    /// A rigged hand (GLB, 25 joints of WebXR) in the place of all drawn ones.
    #[arg(long, value_name = "HAND.glb")]
    hand_model: Option<PathBuf>,
    /// Search for neighbours among scenes without the poses that `train --hold-out-poses` leaves
    /// out (--kind hand): for networks that were trained so.
    #[arg(long)]
    hold_out_poses: bool,
    /// Print JSON Lines, one object a network.
    #[arg(long)]
    json: bool,
}

impl Networks {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let networks = self.networks.iter().map(|path| read_network(path)).collect::<Result<Vec<_>, _>>()?;
        let model = self.hand_model.as_deref().map(hand_model).transpose()?;
        let measured = Measured {
            kind: self.kind,
            scenes: self.scenes,
            hold_out_poses: self.hold_out_poses,
            hand_model: model.map(Arc::new),
        };
        let figures = measure(&measured, &networks, global.progress(), &interrupt::check)?;
        let mut stdout = std::io::stdout().lock();
        for ((path, network), figures) in self.networks.iter().zip(&networks).zip(figures) {
            let fingerprint = format!("{:016x}", network.fingerprint());
            if self.json {
                let values = figures.iter().map(|figure| (figure.name.clone(), json!(figure.value)));
                let figures: Map<String, Value> = values.collect();
                let record = json!({
                    "file": path.display().to_string(),
                    "fingerprint": fingerprint,
                    "scenes": self.scenes,
                    "figures": figures,
                });
                writeln!(stdout, "{record}")?;
                continue;
            }
            writeln!(stdout, "{} ({fingerprint})", shown(path))?;
            for figure in figures {
                writeln!(stdout, "  {figure}")?;
            }
        }
        Ok(())
    }
}
