#!/usr/bin/env python3
"""Checks the manifest of a sweep on many machines: `check_kubernetes.py PROGRAM`.

Fails if a resource is not what the schemas of Kubernetes allow (strictly: no unknown fields), or if the containers' commands,
one after the other in folders that stand for the volumes, do not make the files that a sweep on one machine makes.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import kubernetes_validate
import yaml

MANIFEST = Path(__file__).resolve().parents[2] / "deploy/kubernetes/sweep.yaml"
# The first version that the manifest is for, and the last whose schema is known.
VERSIONS = ["1.33", "1.37"]


def main(program):
    resources = list(yaml.safe_load_all(MANIFEST.read_text()))
    for resource in resources:
        for version in VERSIONS:
            validate(resource, version)
    print(f"{len(resources)} resources are valid in Kubernetes {' and '.join(VERSIONS)}")
    by_kind = {(resource["kind"], resource["metadata"]["name"]): resource for resource in resources}
    shards, merge = by_kind["Job", "baudbot-sweep"]["spec"], by_kind["Job", "baudbot-merge"]["spec"]
    with tempfile.TemporaryDirectory() as place:
        place = Path(place)
        mounted = {mount: place / mount.strip("/") for mount in ("/experiment", "/out")}
        for folder in mounted.values():
            folder.mkdir()
        for name, text in by_kind["ConfigMap", "baudbot-sweep"]["data"].items():
            (place / "experiment" / name).write_text(text)
        # The last first: the order does not matter.
        for index in reversed(range(shards["completions"])):
            run(program, shards, mounted, index)
        run(program, merge, mounted, None)
        alone = place / "alone"
        alone.mkdir()
        subprocess.run([program, "sweep", place / "experiment/experiment.toml", "--quiet", "--jobs", "1"], cwd=alone)
        compare(alone / "first.sweep", place / "out/first.sweep")
    print(f"{shards['completions']} shards and their merge make what one machine makes")


def validate(resource, version):
    try:
        kubernetes_validate.validate(resource, version, strict=True)
    except kubernetes_validate.ValidationError as problem:
        path = ".".join(str(item) for item in problem.path)
        kind, name = resource["kind"], resource["metadata"]["name"]
        raise ValueError(f"{kind} {name}, Kubernetes {version}: {path}: {problem.message}") from None


def run(program, job, mounted, index):
    """A container's command, on this machine."""
    pod = job["template"]["spec"]
    (container,) = pod["containers"]
    volumes = {volume["name"] for volume in pod["volumes"]}
    mounts = {mount["mountPath"]: mount["name"] for mount in container["volumeMounts"]}
    missing = set(mounts.values()) - volumes, set(mounted) - set(mounts)
    if any(missing):
        raise ValueError(f"volumes that are not there, or not mounted: {missing}")
    known = {variable["name"] for variable in container.get("env", [])}
    args = []
    for arg in container["args"]:
        for mount, folder in mounted.items():
            arg = str(folder) + arg.removeprefix(mount) if arg.startswith(f"{mount}/") else arg
        if "JOB_COMPLETION_INDEX" in known:
            arg = arg.replace("$(JOB_COMPLETION_INDEX)", str(index))
        args.append(arg)
    done = subprocess.run([program, *args], cwd=mounted[container["workingDir"]], capture_output=True, text=True)
    # An experiment with runs that fail would end with another code.
    if done.returncode != 0:
        raise ValueError(f"{args} ended with {done.returncode}: {done.stderr}")


def compare(expected, found):
    names = {path.name for path in expected.iterdir() if path.name != ".lock"}
    if names != {path.name for path in found.iterdir() if path.name != ".lock"} or "rows.csv" not in names:
        raise ValueError(f"there are {os.listdir(found)} instead of {os.listdir(expected)}")
    for name in names - {"rows.jsonl"}:
        if (expected / name).read_bytes() != (found / name).read_bytes():
            raise ValueError(f"{name} differs")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: check_kubernetes.py PROGRAM")
    try:
        main(str(Path(sys.argv[1]).resolve()))
    except ValueError as problem:
        sys.exit(f"{MANIFEST.name}: {problem}")
