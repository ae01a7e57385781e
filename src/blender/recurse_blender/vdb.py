"""Volume files: the NanoVDB file next to the OpenVDB file that Blender reads, or a converted one."""
import hashlib
import os
import shutil
import struct
import subprocess

import bpy
import numpy as np

MAGIC = b"NanoVDB0"
HEADER, GRID_ENTRY, BOX, NAME_SIZE = 16, 176, 40, 136  # sizes, then offsets in an entry [bytes]
MARGIN = 0.02  # margin of the shape around the grid, relative to the grid's diagonal
CONVERTER = "nanovdb_convert"  # a tool of OpenVDB


def nano_file(volume, folder):
    """NanoVDB file of a volume's data, converted to a file in `folder` if necessary. Raises ValueError if impossible."""
    file = bpy.path.abspath(volume.grids.frame_filepath or volume.filepath, library=volume.library)
    beside = os.path.splitext(file)[0] + ".nvdb"
    if os.path.isfile(beside):
        return beside
    converter = shutil.which(CONVERTER)
    if not converter:
        raise ValueError(f"there is neither {beside} nor the program {CONVERTER}, which makes it")
    if not os.path.isfile(file):
        raise ValueError(f"there is no {file}")
    key = f"{file} {os.path.getsize(file)} {os.stat(file).st_mtime_ns}"
    made = os.path.join(folder, "data", hashlib.blake2b(key.encode(), digest_size=12).hexdigest() + ".nvdb")
    if not os.path.isfile(made):
        os.makedirs(os.path.dirname(made), exist_ok=True)
        done = subprocess.run([converter, "-f", file, made], capture_output=True, text=True, check=False)
        if done.returncode != 0 or not os.path.isfile(made):
            raise ValueError(f"{CONVERTER} failed: {done.stderr.strip() or done.stdout.strip()}")
    return made


def bounds(file):
    """Lower and upper corner of the bounds of all grids in a file's first segment, in the space of the volume, with a
    margin. Raises ValueError."""
    with open(file, "rb") as data:
        head = data.read(HEADER)
        if head[:len(MAGIC)] != MAGIC:
            raise ValueError(f"{file} is no NanoVDB file")
        boxes = []
        for _ in range(struct.unpack_from("<H", head, 12)[0]):
            entry = data.read(GRID_ENTRY)
            if len(entry) < GRID_ENTRY:
                raise ValueError(f"{file} ends too early")
            boxes.append(struct.unpack_from("<6d", entry, BOX))
            data.seek(struct.unpack_from("<I", entry, NAME_SIZE)[0], os.SEEK_CUR)
    if not boxes:
        raise ValueError(f"{file} has no grids")
    boxes = np.array(boxes).reshape(-1, 2, 3)
    lower, upper = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    margin = MARGIN * np.linalg.norm(upper - lower)
    return lower - margin, upper + margin
