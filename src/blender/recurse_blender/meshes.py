"""Export of meshes to binary PLY files, by array operations."""
import numpy as np


def _read(collection, attribute, shape, dtype):
    out = np.empty(len(collection) * (np.prod(shape, dtype=int) if shape else 1), dtype)
    collection.foreach_get(attribute, out)
    return out.reshape((-1, *shape)) if shape else out


def _corner_normals(mesh):
    if hasattr(mesh, "corner_normals"):  # Blender 4.1
        return _read(mesh.corner_normals, "vector", (3,), np.float32)
    mesh.calc_normals_split()
    return _read(mesh.loops, "normal", (3,), np.float32)


def ply(positions, triangles, normals=None, uvs=None):
    """Contents of a PLY file, as a list of bytes."""
    columns = [positions] + [part for part in (normals, uvs) if part is not None]
    names = ["x", "y", "z"] + (["nx", "ny", "nz"] if normals is not None else []) + (["u", "v"] if uvs is not None else [])
    head = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(positions)
            + "".join(f"property float {name}\n" for name in names)
            + "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % len(triangles))
    faces = np.empty(len(triangles), np.dtype([("count", "u1"), ("indices", "<i4", 3)]))
    faces["count"], faces["indices"] = 3, triangles
    return [head.encode(), np.concatenate(columns, axis=1).astype("<f4").tobytes(), faces.tobytes()]


def pieces(mesh):
    """Triangles of each material: pairs of its slot and the contents of a PLY file."""
    mesh.calc_loop_triangles()
    if not mesh.loop_triangles:
        return
    positions = _read(mesh.vertices, "co", (3,), np.float32)
    triangles = _read(mesh.loop_triangles, "vertices", (3,), np.int32)
    slots = _read(mesh.loop_triangles, "material_index", (), np.int32)
    is_smooth = _read(mesh.polygons, "use_smooth", (), bool)
    normals = uvs = None
    layer = mesh.uv_layers.active
    if is_smooth.any() or layer:
        # Each corner of a face becomes a vertex, since corners differ in normals and texture coordinates.
        triangles = _read(mesh.loop_triangles, "loops", (3,), np.int32)
        positions = positions[_read(mesh.loops, "vertex_index", (), np.int32)]
        if is_smooth.any():
            normals = _corner_normals(mesh)
        if layer:
            uvs = _read(layer.data, "uv", (2,), np.float32)
    for slot in np.unique(slots):
        used = triangles[slots == slot]
        if len(used) == len(triangles):
            yield int(slot), ply(positions, used, normals, uvs)
            continue
        corners, indices = np.unique(used, return_inverse=True)
        yield int(slot), ply(positions[corners], indices.reshape(-1, 3), None if normals is None else normals[corners],
                             None if uvs is None else uvs[corners])
