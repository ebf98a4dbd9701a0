//! The Python package for brains, as it is in `client/python`.

macro_rules! files {
    ($($path:literal,)*) => {
        &[$(($path, include_str!(concat!("../../../client/python/", $path))),)*]
    };
}

/// Its files, by their paths in the package.
pub(super) const PACKAGE: &[(&str, &str)] = files![
    "README.md",
    "pyproject.toml",
    "src/baudbot/__init__.py",
    "src/baudbot/aio.py",
    "src/baudbot/attach.py",
    "src/baudbot/beliefs.py",
    "src/baudbot/body.py",
    "src/baudbot/brain.py",
    "src/baudbot/channel.py",
    "src/baudbot/client.py",
    "src/baudbot/commands.py",
    "src/baudbot/errors.py",
    "src/baudbot/mcap_file.py",
    "src/baudbot/names.py",
    "src/baudbot/paces.py",
    "src/baudbot/program.py",
    "src/baudbot/py.typed",
    "src/baudbot/reconnect.py",
    "src/baudbot/recordings.py",
    "src/baudbot/scenarios/__init__.py",
    "src/baudbot/scenarios/arsim.toml",
    "src/baudbot/scenarios/khepera.toml",
    "src/baudbot/scenarios/wander.toml",
    "src/baudbot/session.py",
    "src/baudbot/settings.py",
    "src/baudbot/trainer.py",
    "src/baudbot/turn.py",
    "src/baudbot/v1/__init__.py",
    "src/baudbot/v1/brain_link_pb2.py",
    "src/baudbot/v1/brain_link_pb2.pyi",
    "src/baudbot/v1/brain_link_pb2_grpc.py",
    "src/baudbot/v1/brain_link_pb2_grpc.pyi",
    "src/baudbot/v1/budget_pb2.py",
    "src/baudbot/v1/budget_pb2.pyi",
    "src/baudbot/v1/control_pb2.py",
    "src/baudbot/v1/control_pb2.pyi",
    "src/baudbot/v1/control_pb2_grpc.py",
    "src/baudbot/v1/control_pb2_grpc.pyi",
    "src/baudbot/v1/observe_pb2.py",
    "src/baudbot/v1/observe_pb2.pyi",
    "src/baudbot/v1/observe_pb2_grpc.py",
    "src/baudbot/v1/observe_pb2_grpc.pyi",
    "src/baudbot/v1/page_pb2.py",
    "src/baudbot/v1/page_pb2.pyi",
    "src/baudbot/v1/recording_pb2.py",
    "src/baudbot/v1/recording_pb2.pyi",
    "src/baudbot/v1/trainer_pb2.py",
    "src/baudbot/v1/trainer_pb2.pyi",
    "src/baudbot/v1/trainer_pb2_grpc.py",
    "src/baudbot/v1/trainer_pb2_grpc.pyi",
    "src/baudbot/v1/world_pb2.py",
    "src/baudbot/v1/world_pb2.pyi",
    "src/baudbot/world.py",
];

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::*;

    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_none_or(|extension| extension != "pyc") {
                found.push(path);
            }
        }
    }

    #[test]
    fn no_file_of_the_package_is_missing() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../client/python");
        let mut found = vec![root.join("README.md"), root.join("pyproject.toml")];
        walk(&root.join("src"), &mut found);
        let mut paths: Vec<_> =
            found.iter().map(|path| path.strip_prefix(&root).unwrap().to_str().unwrap()).collect();
        paths.sort_unstable();
        assert_eq!(PACKAGE.iter().map(|(path, _)| *path).collect::<Vec<_>>(), paths);
    }
}
