# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the container image to standard output, as an archive for `docker load` and `podman load`.

    /usr/bin/python3 docker/image_archive.py STAGE VERSION REVISION >ARCHIVE

STAGE is a folder that contains the result of docker/collect as `image`, like the stage `collect` of the Dockerfile. The
program builds the last stage of the Dockerfile with buildah, which needs neither a daemon nor the network. The same
arguments, files and SOURCE_DATE_EPOCH give the same bytes, whatever the times of the files.
"""

import hashlib
import io
import json
import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile

DOCKERFILE = pathlib.Path(__file__).resolve().parent / "Dockerfile"


def build(folder, stage, version, revision):
    """Builds the image and returns the path of its archive."""
    context = folder / "context"  # stays empty, because the last stage copies from the stage before it only
    context.mkdir()
    archive = folder / "image.tar"
    buildah = ("buildah", "--root", folder / "images", "--runroot", folder / "state", "--storage-driver", "vfs")
    subprocess.run((*buildah, "build", "--quiet", "--isolation=chroot", "--format=docker", "--identity-label=false",
                    f"--timestamp={os.environ['SOURCE_DATE_EPOCH']}", f"--build-context=collect={stage.resolve()}",
                    f"--build-arg=VERSION={version}", f"--build-arg=REVISION={revision}", f"--file={DOCKERFILE}",
                    "--tag=image", context), check=True, stdout=subprocess.DEVNULL)
    subprocess.run((*buildah, "push", "--quiet", "image", f"docker-archive:{archive}"), check=True)
    return archive


def without_names_of_the_build(text):
    """Removes the random names of buildah's container from the configuration of an image."""
    settings = json.loads(text)
    for name in ("container", "container_config"):
        del settings[name]
    del settings["config"]["Hostname"]
    return json.dumps(settings).encode()


def rewrite(archive, output, tags):
    """Copies an image to a new archive, with other tags."""
    with tarfile.open(archive) as built, tarfile.open(fileobj=output, mode="w|", format=tarfile.USTAR_FORMAT) as copy:
        def add(name, size, file):
            entry = tarfile.TarInfo(name)
            entry.size = size
            entry.mtime = int(os.environ["SOURCE_DATE_EPOCH"])
            copy.addfile(entry, file)

        [image] = json.load(built.extractfile("manifest.json"))
        settings = without_names_of_the_build(built.extractfile(image["Config"]).read())
        image["Config"] = f"{hashlib.sha256(settings).hexdigest()}.json"
        image["RepoTags"] = tags
        manifest = json.dumps([image]).encode()
        add("manifest.json", len(manifest), io.BytesIO(manifest))
        add(image["Config"], len(settings), io.BytesIO(settings))
        for name in image["Layers"]:
            add(name, built.getmember(name).size, built.extractfile(name))


def main():
    stage, version, revision = sys.argv[1:]
    os.umask(0o022)
    with tempfile.TemporaryDirectory() as folder:
        archive = build(pathlib.Path(folder), pathlib.Path(stage), version, revision)
        rewrite(archive, sys.stdout.buffer, [f"ccdt-server:{version}", "ccdt-server:latest"])


if __name__ == "__main__":
    main()
