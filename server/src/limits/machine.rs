//! The memory that the process may have.

use std::fs::read_to_string;
use std::path::Path;

/// The memory of the machine, or that of the group of processes (cgroup) that this one is in, if that is less; `None`
/// where the system does not report it.
pub(super) fn memory_bytes() -> Option<u64> {
    let machine = read_to_string("/proc/meminfo").ok().and_then(|text| total(&text));
    let groups = read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = groups.lines().filter_map(|line| of_group(line, Path::new("/sys/fs/cgroup"))).min();
    machine.into_iter().chain(group).min()
}

/// The total memory from the text of `/proc/meminfo`.
fn total(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

/// The least limit of a group and those around it, from a line of `/proc/self/cgroup`.
fn of_group(line: &str, root: &Path) -> Option<u64> {
    let (hierarchy, path) = line.split_once(':').and_then(|(_, rest)| rest.split_once(':'))?;
    let (root, file) = match hierarchy {
        "" => (root.to_owned(), "memory.max"),
        "memory" => (root.join("memory"), "memory.limit_in_bytes"),
        _ => return None,
    };
    let folder = root.join(path.trim_start_matches('/'));
    // In a container the path may be that outside of it.
    let folder = if folder.is_dir() { folder } else { root.clone() };
    let folders = folder.ancestors().take_while(|folder| folder.starts_with(&root));
    folders.filter_map(|folder| read_to_string(folder.join(file)).ok()?.trim().parse().ok()).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_memory_of_a_group_is_the_least_of_those_around_it() {
        let root = std::env::temp_dir().join(format!("baudbot-cgroup-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&root);
        std::fs::create_dir_all(root.join("user/server")).unwrap();
        std::fs::create_dir_all(root.join("memory/a")).unwrap();
        std::fs::write(root.join("user/memory.max"), "1000\n").unwrap();
        std::fs::write(root.join("user/server/memory.max"), "max\n").unwrap();
        std::fs::write(root.join("memory/a/memory.limit_in_bytes"), "77").unwrap();
        assert_eq!(of_group("0::/user/server", &root), Some(1000));
        assert_eq!(of_group("0::/elsewhere", &root), None);
        assert_eq!(of_group("4:memory:/a", &root), Some(77));
        assert_eq!(of_group("5:cpu,cpuacct:/a", &root), None);
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn the_memory_of_this_machine_is_known() {
        assert_eq!(total("MemTotal:       16384 kB\nMemFree: 1 kB\n"), Some(16 << 20));
        assert!(memory_bytes().is_some_and(|bytes| bytes > 64 << 20));
    }
}
