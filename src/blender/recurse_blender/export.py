"""Export of a Blender scene to a scene file."""
import math

import numpy as np

from . import lights, meshes, metaballs, vdb
from .materials import Materials
from .text import Folder, Warnings, matrix, number, numbers, quoted
from .textures import Textures

#: Camera space of scene files has z forward, Blender's has it backward.
TURNED = np.diag([1.0, 1.0, -1.0, 1.0])
CONVERTED = ("CURVE", "SURFACE", "FONT", "META")  # types that Blender lists twice: first as they are, then as meshes
GEOMETRY = ("MESH", "CURVES", *CONVERTED)


class Piece:
    """Geometry of an object: a shape for each material."""

    def __init__(self, name):
        self.name = name
        self.parts = []  # pairs: class and parameters of a shape; Surface


class Exporter:
    """Writes one frame. `size`: width and height of the image [pixels]. `crop`: fractions x0, x1, y0, y1."""

    def __init__(self, depsgraph, folder, size, crop=None):
        self.depsgraph, self.scene = depsgraph, depsgraph.scene
        self.folder = Folder(folder)
        self.warnings = Warnings()
        self.size, self.crop = size, crop
        self.textures = Textures(self.folder, self.warnings)
        self.materials = Materials(self.textures, self.folder, self.warnings)
        self.pieces = {}
        self.placed = {}  # matrices of the instances of a piece, by the key of the piece
        self.moves = {}  # matrices at the end of the shutter, by the key of the instance
        self.shines = False  # whether an object visibly emits light
        self.lamp_lines, self.curve_lines, self.volume_lines = [], [], []

    def write(self, frame_set=None):
        """Returns the text of the scene file. `frame_set(frame, part)` changes the time, for motion blur."""
        scene = self.scene
        camera = scene.camera
        if not camera:
            raise ValueError("the scene has no camera")
        start = end = None
        now = scene.frame_current, scene.frame_subframe
        if scene.render.use_motion_blur and frame_set:
            start, end = self._shutter()
            frame_set(math.floor(end), end - math.floor(end))
            camera_end = self._camera_matrix()
            self.moves = {key: place for key, place in self._places()}
            frame_set(math.floor(start), start - math.floor(start))
        camera_text = self._camera(camera_end if start is not None else None)
        self._collect()
        world = lights.world(scene.world, self.textures)
        if start is not None:
            frame_set(*now)
        lines = [f"# Written from Blender: {scene.name}", *self._settings(), camera_text, "WorldBegin",
                 *self.textures.lines, *self.materials.media_lines, *self.materials.lines, *world, *self.lamp_lines,
                 *self.curve_lines, *self.volume_lines, *self._shapes()]
        return "\n".join(lines) + "\n"

    def _shutter(self):
        scene = self.scene
        half = scene.render.motion_blur_shutter / 2
        now = scene.frame_current + scene.frame_subframe
        position = getattr(getattr(scene, "cycles", None), "motion_blur_position", "CENTER")
        first = {"START": now, "END": now - 2 * half}.get(position, now - half)
        return first, first + 2 * half

    # Settings and camera

    def _settings(self):
        film = f'Film "rgb" "integer xresolution" {self.size[0]} "integer yresolution" {self.size[1]}'
        if self.crop:
            film += f' "float cropwindow" {numbers(self.crop)}'
        return [film, 'PixelFilter "gaussian" "float xradius" 1.5 "float yradius" 1.5 "float sigma" 0.5',
                *self.scene.recurse.directives()]

    def _camera_matrix(self):
        """Matrix from the world to the camera space of scene files."""
        place = np.array(self.scene.camera.evaluated_get(self.depsgraph).matrix_world.normalized(), float)
        return TURNED @ np.linalg.inv(place)

    def _camera(self, at_end):
        camera = self.scene.camera.evaluated_get(self.depsgraph)
        data, render = camera.data, self.scene.render
        before = np.eye(4)
        if data.type == "PANO":
            kind = data.cycles.panorama_type if hasattr(data, "cycles") else getattr(data, "panorama_type", "")
            if kind != "EQUIRECTANGULAR":
                self.warnings.add(f"{camera.name}: the panorama '{kind.lower()}' is rendered as equirectangular")
            # The forward direction is at the centre of the image.
            before = np.array([[0, 0, -1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], float)
            self.window = None
            text = '"spherical" "string mapping" "equirectangular"'
        else:
            projection = np.array(camera.calc_matrix_camera(
                self.depsgraph, x=self.size[0], y=self.size[1], scale_x=render.pixel_aspect_x,
                scale_y=render.pixel_aspect_y), float)
            # Edges of the image on the plane z = 1; for parallel rays at any depth.
            self.window = window = []
            for axis in (0, 1):
                shift = -projection[axis, 3] if data.type == "ORTHO" else projection[axis, 2]
                window += [(shift - 1) / projection[axis, axis], (shift + 1) / projection[axis, axis]]
            text = '"orthographic"' if data.type == "ORTHO" else '"perspective" "float fov" 90'
            text += f' "float screenwindow" {numbers(window)}' + self._lens(camera)
        lines = self._transforms(before @ self._camera_matrix(), None if at_end is None else before @ at_end)
        return "\n".join([*lines, f"Camera {text}"])

    def _lens(self, camera):
        data = camera.data
        dof = data.dof
        if not dof.use_dof:
            return ""
        length = data.ortho_scale if data.type == "ORTHO" else data.lens * 1e-3
        radius = length / (2 * max(dof.aperture_fstop, 1e-6))
        distance = dof.focus_distance
        if dof.focus_object:
            other = dof.focus_object.evaluated_get(self.depsgraph).matrix_world.translation
            place = camera.matrix_world.normalized()
            distance = -(place.inverted() @ other).z
        if dof.aperture_ratio != 1:
            self.warnings.add(f"{camera.name}: the ratio of its aperture is left out")
        text = f' "float lensradius" {number(radius)} "float focaldistance" {number(max(distance, 1e-6))}'
        if dof.aperture_blades >= 3:
            text += (f' "integer apertureblades" {dof.aperture_blades} "float aperturerotation" '
                     f"{number(math.degrees(dof.aperture_rotation))}")
        return text

    # Objects

    def _places(self):
        """Keys and matrices of all instances."""
        for instance in self.depsgraph.object_instances:
            yield self._place_key(instance), np.array(instance.matrix_world, float)

    @staticmethod
    def _place_key(instance):
        parent = instance.parent.original.name_full if instance.parent else ""
        return instance.object.original.name_full, parent, tuple(instance.persistent_id)

    def _collect(self):
        for instance in self.depsgraph.object_instances:
            source = instance.object
            if not instance.show_self or source.type not in GEOMETRY + ("LIGHT",):
                if source.type == "VOLUME":
                    self._volume(source, np.array(instance.matrix_world, float))
                continue
            if source.type == "MESH" and source.original.type in CONVERTED:
                continue  # mesh of a curve, which is exported itself
            place = np.array(instance.matrix_world, float)
            if source.type == "LIGHT":
                self._lamp(source, place)
                continue
            if getattr(source, "is_holdout", False) or getattr(source, "is_shadow_catcher", False):
                self.warnings.add(f"{source.name}: holdouts and shadow catchers are rendered as normal objects")
            if not source.visible_camera:
                self.warnings.add(f"{source.name}: the camera sees it, although it should be invisible")
            key = self._geometry_key(source)
            if key not in self.pieces:
                self.pieces[key] = self._piece(source)
            self.placed.setdefault(key, []).append((place, self._place_key(instance)))
            if not instance.is_instance:
                self._hair(source)

    def _lamp(self, source, place):
        light = source.data
        is_hidden = not source.visible_camera and self._is_in_picture(light, place)
        text = lights.lamp(light, place, is_hidden, self.textures)
        if text is None:
            file = self.folder.picture(light.name, lights.sun_map(light, place, lights.power_of(light, self.textures)))
            text = f'LightSource "infinite" "string filename" {quoted(file)} "string mapping" "latlong"'
        self.shines |= "AreaLightSource" in text and not is_hidden
        self.lamp_lines.append(text)

    def _is_in_picture(self, light, place):
        """Whether the lamp's surface may be visible to the camera."""
        at = self._camera_matrix() @ place[:, 3]
        radius = light.shadow_soft_size if light.type == "POINT" else 0
        if light.type == "AREA":
            radius = np.linalg.norm(lights.size_of(light, place)) / 2
            towards_camera = np.linalg.inv(self._camera_matrix())[:3, 3] - place[:3, 3]
            if towards_camera @ place[:3, 2] > 0:
                return False  # dark on its back
        if self.window is None:
            return True
        depth = at[2] + radius if self.scene.camera.data.type != "ORTHO" else 1
        if depth <= 0:
            return False
        x0, x1, y0, y1 = np.array(self.window) * depth
        return x0 - radius <= at[0] <= x1 + radius and y0 - radius <= at[1] <= y1 + radius

    @staticmethod
    def _geometry_key(source):
        """Key of an object's geometry, equal for objects that share an unmodified mesh."""
        slots = tuple(slot.material.name_full if slot.material else "" for slot in source.material_slots)
        if source.modifiers or source.type != "MESH" or (source.data.shape_keys if source.data else False):
            return "object", source.original.name_full, slots
        return "mesh", source.data.original.name_full if source.data.original else source.data.name_full, slots

    def _piece(self, source):
        out = Piece(source.name)
        try:
            mesh = source.to_mesh()
        except RuntimeError:
            mesh = None
        if mesh is None:
            self.warnings.add(f"{source.name}: it has no mesh, and is left out")
            return out
        try:
            for slot, parts in meshes.pieces(mesh):
                slots = source.material_slots
                material = slots[min(slot, len(slots) - 1)].material if len(slots) else None
                surface = self.materials.surface(material)
                self.shines |= surface.emits
                balls = None if surface.emits else self._metaballs(source)  # emitters are sampled, so must be meshes
                if balls:
                    out.parts.append((balls, surface))
                    break
                file = self.folder.file(source.name, ".ply", parts)
                out.parts.append((f'"plymesh" "string filename" {quoted(file)}', surface))
        finally:
            source.to_mesh_clear()
        return out

    def _volume(self, source, place):
        """Writes a box around the medium of a volume file."""
        slots = source.material_slots
        parameters = self.materials.volume(slots[0].material if len(slots) else None)
        if not parameters:
            self.warnings.add(f"{source.name}: the volume has no shader, and is left out")
            return
        try:
            file = vdb.nano_file(source.data, self.folder.path)
            lower, upper = vdb.bounds(file)
        except (OSError, ValueError) as reason:
            self.warnings.add(f"{source.name}: the volume is left out: {reason}")
            return
        name = f"volume {len(self.volume_lines) + 1} of {source.name}"
        self.volume_lines.append("\n".join([
            "AttributeBegin", f"Transform {matrix(place)}",
            f'MakeNamedMedium {quoted(name)} "string type" "nanovdb" "string filename" {quoted(file)}{parameters}',
            f'MediumInterface {quoted(name)} ""', 'Material "interface"',
            f'Shape "box" "point3 p1" {numbers(lower)} "point3 p2" {numbers(upper)}', "AttributeEnd"]))

    def _metaballs(self, source):
        """Class and parameters of a shape of metaballs; None if they must be a mesh."""
        if source.type != "META":
            return None
        family = [other.evaluated_get(self.depsgraph) for other in self.scene.objects if not other.hide_render]
        balls = metaballs.shape(source, family)
        if not balls:
            self.warnings.add(f"{source.name}: metaballs other than balls are rendered as a mesh")
        return balls

    def _hair(self, source):
        """Writes the hair of particle systems, one curve for each hair."""
        for system in getattr(source, "particle_systems", []):
            settings = system.settings
            if settings.type != "HAIR" or settings.render_type != "PATH":
                continue
            steps = 2 ** settings.render_step + 1
            slots = source.material_slots
            material = slots[min(settings.material, len(slots)) - 1].material if len(slots) else None
            surface = self.materials.surface(material)
            root, tip = (settings.root_radius * settings.radius_scale, settings.tip_radius * settings.radius_scale)
            count = len(system.particles) + len(system.child_particles)
            first = len(system.particles) if system.child_particles and settings.child_type != "NONE" else 0
            for number_of_hair in range(first, count):
                points = []
                for step in range(steps):
                    point = np.array(system.co_hair(object=source, particle_no=number_of_hair, step=step)[:])
                    if not point.any() or (points and np.allclose(points[-1], point)):
                        continue
                    points.append(point)
                if len(points) > 1:
                    self.curve_lines.append(self._curve(np.array(points), root, tip, surface))

    @staticmethod
    def _curve(points, root, tip, surface):
        """Cubic B-spline through the ends. `root`, `tip`: widths; Blender calls them radii, but uses them as widths."""
        ends = np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])
        return "\n".join(["AttributeBegin", f"NamedMaterial {quoted(surface.material)}" if surface.material else 'Material "interface"',
                          f'Shape "curve" "string basis" "bspline" "string type" "cylinder" "point3 P" {numbers(ends)} '
                          f'"float width0" {number(root)} "float width1" {number(tip)}', "AttributeEnd"])

    def _part(self, text, surface):
        """Directives of a shape in its own space."""
        lines = []
        if surface.medium:
            lines.append(f'MediumInterface {quoted(surface.medium)} ""')
        lines.append(f"NamedMaterial {quoted(surface.material)}" if surface.material else 'Material "interface"')
        if surface.emits:
            lines.append(f'AreaLightSource "diffuse" "rgb L" {numbers(np.maximum(surface.emission, 0))} "bool twosided" true')
        shape = f"Shape {text}"
        if surface.alpha is not None:
            shape += " " + self.textures.parameter("alpha", surface.alpha, False)
        return lines + [shape]

    @staticmethod
    def _transforms(first, last):
        """Directives of the current transform: one matrix, or two for motion if the second differs."""
        if last is None or np.allclose(last, first, rtol=1e-6, atol=1e-9):
            return [f"Transform {matrix(first)}"]
        return ["ActiveTransform StartTime", f"Transform {matrix(first)}", "ActiveTransform EndTime",
                f"Transform {matrix(last)}", "ActiveTransform All"]

    @staticmethod
    def _is_nothing(surface):
        """Whether a surface neither scatters nor emits, and bounds no medium."""
        return not surface.material and not surface.medium and not surface.emits

    def _shapes(self):
        for key, places in self.placed.items():
            piece = self.pieces[key]
            parts = [(text, surface) for text, surface in piece.parts if not self._is_nothing(surface)]
            shared = [part for part in parts if not part[1].emits and not part[1].medium] if len(places) > 1 else []
            if shared:  # emitters and media cannot be instanced
                name = f"{piece.name} {key[0]}"
                yield f"ObjectBegin {quoted(name)}"
                for text, surface in shared:
                    yield "\n".join(["AttributeBegin", *self._part(text, surface), "AttributeEnd"])
                yield "ObjectEnd"
            for place, place_key in places:
                lines = ["AttributeBegin", *self._transforms(place, self.moves.get(place_key))]
                if shared:
                    lines.append(f"ObjectInstance {quoted(name)}")
                for text, surface in parts:
                    if (text, surface) not in shared:
                        lines += ["AttributeBegin", *self._part(text, surface), "AttributeEnd"]
                yield "\n".join([*lines, "AttributeEnd"])
