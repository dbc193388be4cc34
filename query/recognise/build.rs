//! Makes what the program carries of data that people can read or train.
//!
//! What is made here costs a process start nothing. Evaluating the 32 Gaussian kernels of the skin
//! mixture for 64^3 colours at start would cost more than the whole recognition of a picture, and
//! rounding the networks' weights to integers as much as looking by them.

use std::error::Error;
use std::path::Path;
use std::{env, fs};

use grasp_network::QuantisedNetwork;

/// The networks of scenes.
const NETWORKS: [&str; 4] = ["scene.network", "naming.network", "thing.network", "mask.network"];

/// Cells along each colour axis. Must be the `SIDE` of `src/segment/skin.rs`.
const SIDE: usize = 64;
/// Steps of the stored log-odds per natural unit. Must be the `STEPS` of `src/segment/skin.rs`.
const STEPS: f64 = 8.0;

/// One Gaussian kernel with diagonal covariance over RGB in 0..=255.
struct Kernel {
    skin: bool,
    log_weight: f64,
    mean: [f64; 3],
    variance: [f64; 3],
}

impl Kernel {
    fn from_row(row: &csv::StringRecord) -> Result<Self, Box<dyn Error>> {
        let number = |column: usize| -> Result<f64, Box<dyn Error>> {
            Ok(row.get(column).ok_or("a kernel needs eight columns")?.parse()?)
        };
        let mean = [number(1)?, number(2)?, number(3)?];
        let variance = [number(4)?, number(5)?, number(6)?];
        let determinant: f64 = variance.iter().product();
        Ok(Self {
            skin: row.get(0) == Some("skin"),
            // The constant (2 pi)^(-3/2) is common to all kernels and cancels in the odds.
            log_weight: number(7)?.ln() - 0.5 * determinant.ln(),
            mean,
            variance,
        })
    }

    fn log_density(&self, rgb: [f64; 3]) -> f64 {
        let mut log = self.log_weight;
        for ((value, mean), variance) in rgb.iter().zip(self.mean).zip(self.variance) {
            log -= (value - mean) * (value - mean) / (2.0 * variance);
        }
        log
    }
}

/// ln(sum(exp(x))) without underflow: a saturated blue is far from every kernel.
fn log_sum_exp(logs: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = logs.clone().fold(f64::NEG_INFINITY, f64::max);
    largest + logs.map(|log| (log - largest).exp()).sum::<f64>().ln()
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=data");
    let out = env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR")?;
    let (data, out) = (Path::new("data"), Path::new(&out));
    fs::write(out.join("skin-log-odds.bin"), skin_log_odds(&data.join("skin-mixture.csv"))?)?;
    for name in NETWORKS {
        fs::write(out.join(name), QuantisedNetwork::prepare(&fs::read(data.join(name))?)?)?;
    }
    Ok(())
}

/// The log-odds of skin at the centre of each cell of colours, in steps.
fn skin_log_odds(source: &Path) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut kernels = Vec::new();
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(source)?;
    for row in reader.records() {
        kernels.push(Kernel::from_row(&row?)?);
    }

    let centre = |cell: usize| (cell as f64 + 0.5) * 256.0 / SIDE as f64 - 0.5;
    let mut table = Vec::with_capacity(SIDE * SIDE * SIDE);
    for r in 0..SIDE {
        for g in 0..SIDE {
            for b in 0..SIDE {
                let rgb = [centre(r), centre(g), centre(b)];
                let log = |skin: bool| {
                    log_sum_exp(kernels.iter().filter(move |k| k.skin == skin).map(|k| k.log_density(rgb)))
                };
                let odds = ((log(true) - log(false)) * STEPS).round();
                table.push(odds.clamp(-127.0, 127.0) as i8 as u8);
            }
        }
    }
    Ok(table)
}
