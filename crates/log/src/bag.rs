//! Folders of bags of ROS 2: which files of them are read, and what to do about files that cannot be read as they are.

use crate::LogError;
use std::fs;
use std::path::{Path, PathBuf};

/// What is known of a bag, in its folder.
const METADATA: &str = "metadata.yaml";

/// The MCAP files of a bag in the order of its recording; none of a folder that is no bag.
///
/// # Errors
/// [`LogError`]: a file that is not there, or not in MCAP, with what to do.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>, LogError> {
    let metadata = folder.join(METADATA);
    let files = if metadata.is_file() {
        let text = fs::read_to_string(&metadata).map_err(LogError::io(&metadata))?;
        let names = listed(&text);
        if names.is_empty() {
            let message = "has no relative_file_paths, allowed: that of a bag of ROS 2, or name the .mcap file itself";
            return Err(LogError::whole(&metadata, message));
        }
        names.iter().map(|name| folder.join(name)).collect()
    } else {
        splits(folder)?
    };
    for file in &files {
        if is_mcap(file) && file.is_file() {
            continue;
        }
        // Compressed files have the ending behind their name, which the list may leave out.
        let endings = ["zstd", "zst", "lz4"].into_iter();
        let compressed = endings
            .map(|ending| PathBuf::from(format!("{}.{ending}", file.display())))
            .find(|file| file.is_file());
        let found = compressed.as_ref().unwrap_or(file);
        let message = match advice(found) {
            Some(advice) => advice,
            None if !file.exists() => format!("{METADATA} lists it, and it is not there"),
            None => "is in a bag, allowed: MCAP files (.mcap)".to_owned(),
        };
        return Err(LogError::whole(found, message));
    }
    Ok(files)
}

/// The files of a bag whose recording was killed before its list was written: those of one name, or all that can be no
/// table.
fn splits(folder: &Path) -> Result<Vec<PathBuf>, LogError> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(LogError::io(folder))? {
        let path = entry.map_err(LogError::io(folder))?.path();
        let is_of_bag = is_mcap(&path) || advice(&path).is_some();
        if path.is_file() && is_of_bag {
            files.push(path);
        }
    }
    // By their numbers: 10 is behind 9.
    files.sort_by_key(|file| (numbered(file), file.clone()));
    let is_one = files.windows(2).all(|w| {
        let [a, b] = [&w[0], &w[1]].map(|file| numbered(file));
        a.0 == b.0 && a.1.is_some() && b.1.is_some()
    });
    Ok(if is_one { files } else { Vec::new() })
}

/// Name and number of a file `NAME_NUMBER.mcap`.
fn numbered(file: &Path) -> (String, Option<u64>) {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.split('.').next().unwrap_or_default();
    match stem.rsplit_once('_') {
        Some((name, number)) if number.parse::<u64>().is_ok() => {
            (name.to_owned(), number.parse().ok())
        }
        _ => (stem.to_owned(), None),
    }
}

/// The files that the metadata of a bag list, in either form of YAML.
fn listed(metadata: &str) -> Vec<String> {
    let plain = |text: &str| {
        let text = text.trim().trim_matches(['"', '\'']);
        (!text.is_empty()).then(|| text.to_owned())
    };
    let Some((_, rest)) = metadata.split_once("relative_file_paths:") else {
        return Vec::new();
    };
    let items: Vec<&str> = match rest.trim_start().strip_prefix('[') {
        Some(inside) => {
            let (items, _) = inside.split_once(']').unwrap_or((inside, ""));
            items.split(',').collect()
        }
        None => {
            let lines = rest.lines().skip(1).map(str::trim_start);
            lines.map_while(|line| line.strip_prefix("- ")).collect()
        }
    };
    items.into_iter().filter_map(plain).collect()
}

/// Whether a file is of topics, by its extension.
pub fn is_mcap(file: &Path) -> bool {
    let extension = file.extension();
    extension.is_some_and(|e| e.eq_ignore_ascii_case("mcap"))
}

/// What to do about a file that no reader takes as it is, by its ending.
pub fn advice(file: &Path) -> Option<String> {
    let ending = file.extension()?.to_string_lossy().to_lowercase();
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let unpack =
        |command: &str| format!("is compressed as a whole; unpack it first: `{command} {name}`");
    Some(match ending.as_str() {
        "zstd" | "zst" => unpack("zstd -d"),
        "gz" => unpack("gunzip"),
        "bz2" => unpack("bunzip2"),
        "xz" => unpack("unxz"),
        "lz4" => unpack("lz4 -d"),
        "zip" => unpack("unzip"),
        "db3" | "sqlite3" => "is a bag of ROS 2 in SQLite, allowed: MCAP; convert its folder: `ros2 bag convert -i FOLDER -o mcap.yaml`, \
             with mcap.yaml the lines `output_bags:`, `- uri: FOLDER_mcap`, `  storage_id: mcap`, `  all_topics: true`"
            .to_owned(),
        "bag" => "is a bag of ROS 1, allowed: MCAP with messages of ROS 2; convert it: `pip install rosbags`, then \
             `rosbags-convert --src FILE --dst FOLDER --dst-storage mcap`"
            .to_owned(),
        "yaml" if name == METADATA => "lists the files of a bag; name its folder, or the .mcap file in it".to_owned(),
        "xlsx" | "xls" | "ods" => "is a spreadsheet; save the sheet as CSV".to_owned(),
        "arrow" | "feather" => "is a file of Arrow; write it as Parquet: pyarrow.parquet.write_table".to_owned(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both forms in which ROS 2 and its tools write the list.
    #[test]
    fn metadata_list_their_files() {
        let block = "rosbag2_bagfile_information:\n  version: 9\n  relative_file_paths:\n    - a_0.mcap\n    - \"a_1.mcap\"\n  files:\n    - path: a_0.mcap\n";
        assert_eq!(listed(block), ["a_0.mcap", "a_1.mcap"]);
        let inline = "x:\n  relative_file_paths: [a_0.mcap,\n    'a_1.mcap']\n  duration: 1\n";
        assert_eq!(listed(inline), ["a_0.mcap", "a_1.mcap"]);
        assert!(listed("x: 1\n").is_empty());
    }

    #[test]
    fn splits_are_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a_10.mcap", "a_9.mcap", "notes.txt"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let found = files(folder.path()).unwrap();
        let names: Vec<_> = found.iter().filter_map(|f| f.file_name()).collect();
        assert_eq!(names, ["a_9.mcap", "a_10.mcap"]);
        fs::write(folder.path().join("other.mcap"), "").unwrap();
        assert!(files(folder.path()).unwrap().is_empty());
        fs::write(
            folder.path().join(METADATA),
            "relative_file_paths: [a_0.db3]",
        )
        .unwrap();
        assert!(
            files(folder.path())
                .unwrap_err()
                .to_string()
                .contains("a_0.db3")
        );
    }
}
