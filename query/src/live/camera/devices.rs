//! The cameras' devices.

use std::io;
use std::path::{Path, PathBuf};

use super::error::CameraDevice;

/// The device that is meant by a camera's number or path; `None` where the text is neither.
pub fn device(text: &str) -> Option<PathBuf> {
    let is_number = !text.is_empty() && text.len() <= 4 && text.bytes().all(|byte| byte.is_ascii_digit());
    match is_number {
        // `0`, and `00` as well.
        true => Some(format!("/dev/video{}", text.parse::<u16>().ok()?).into()),
        false => text.starts_with("/dev/").then(|| text.into()),
    }
}

/// The devices of a folder like `/dev` that are called `videoN`, by their numbers, with the names
/// that a folder like `/sys/class/video4linux` has for them.
#[cfg_attr(not(all(target_os = "linux", feature = "camera")), allow(dead_code, reason = "none are read"))]
pub(super) fn devices_in(devices: &Path, names: &Path) -> Vec<CameraDevice> {
    let numbered = |entry: io::Result<std::fs::DirEntry>| {
        let name = entry.ok()?.file_name().into_string().ok()?;
        let number: u32 = name.strip_prefix("video")?.parse().ok()?;
        Some((number, name))
    };
    let mut found: Vec<(u32, String)> =
        devices.read_dir().into_iter().flatten().filter_map(numbered).collect();
    found.sort();
    let found = found.into_iter().map(|(_, device)| {
        let name = std::fs::read(names.join(&device).join("name")).unwrap_or_default();
        let name = String::from_utf8_lossy(&name).trim().to_owned();
        let name = if name.is_empty() { "without a name".to_owned() } else { name };
        CameraDevice { path: devices.join(device), name }
    });
    found.collect()
}

#[cfg(test)]
mod tests {
    use super::super::error::devices_in_words;
    use super::*;

    #[test]
    fn a_camera_is_named_by_its_number_or_its_device() {
        assert_eq!(device("0"), Some("/dev/video0".into()));
        assert_eq!(device("07"), Some("/dev/video7".into()));
        assert_eq!(device("/dev/v4l/by-id/usb-cam"), Some("/dev/v4l/by-id/usb-cam".into()));
        for text in ["", "-1", "camera.toml", "99999", "video0"] {
            assert_eq!(device(text), None, "{text}");
        }
    }

    #[test]
    fn devices_are_found_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        for device in ["video10", "video2", "video", "vbi0", "videox", "null"] {
            std::fs::write(folder.path().join(device), "").unwrap();
        }
        std::fs::create_dir_all(folder.path().join("names/video2")).unwrap();
        std::fs::write(folder.path().join("names/video2/name"), "HD \x1b[2J Cam\n").unwrap();
        let found = devices_in(folder.path(), &folder.path().join("names"));
        assert_eq!(
            found.iter().map(|camera| camera.path.clone()).collect::<Vec<_>>(),
            [folder.path().join("video2"), folder.path().join("video10")]
        );
        let words = devices_in_words(&found).replace(&folder.path().display().to_string(), "/dev");
        insta::assert_snapshot!(words, @r"there are /dev/video2 (HD \u{1b}[2J Cam), /dev/video10 (without a name)");
        insta::assert_snapshot!(devices_in_words(&devices_in(Path::new("/none"), Path::new("/none"))), @"no camera is connected; pictures, and streams of them, can be read from files and `-`");
    }
}
