"""Settings of a scene, and their panels."""
import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from .text import number

INTEGRATORS = [
    ("photonmap", "Photon mapping", "Photons for indirect light and caustics, new ones in each pass"),
    ("path", "Path tracing", "Unbiased; caustics of small lamps are noisy"),
    ("vcm", "Vertex connection and merging", "Bidirectional paths with photons"),
    ("bdpt", "Bidirectional path tracing", "Unbiased; connects paths from the camera and from lamps"),
    ("whitted", "Whitted", "Direct light, mirrors and glass"),
    ("ambientocclusion", "Ambient occlusion", "Fraction of a uniform sky that reaches each point"),
]
WITH_DEPTH = ("photonmap", "path", "vcm", "bdpt", "whitted")


class RecurseSettings(bpy.types.PropertyGroup):
    """Settings of a scene."""

    integrator: EnumProperty(name="Integrator", items=INTEGRATORS, default="photonmap", description="Algorithm that computes light")
    samples: IntProperty(name="Samples", default=64, min=1, max=1 << 30, description="Samples per pixel")
    time_limit: FloatProperty(name="Time Limit", default=0, min=0, unit="TIME_ABSOLUTE",
                              description="Maximum time for a picture [s]; 0: no limit")
    error_target: FloatProperty(name="Error Target", default=0, min=0, max=1, precision=3,
                                description="Relative error at which the render stops; 0: none")
    adaptive: BoolProperty(name="Adaptive", default=False, description="More samples where the error is larger")
    photons: IntProperty(name="Photons", default=0, min=0, max=2000000000,
                         description="Number of photons in each pass; 0: chosen by the size of the picture")
    caustics_only: BoolProperty(name="Caustics Only", default=False,
                                description="Photons for caustics only, and path tracing for all other light")
    max_depth: IntProperty(name="Max Bounces", default=-1, min=-1, max=1000000000,
                           description="Maximum number of scattering events of a path; -1: no limit")
    seed: IntProperty(name="Seed", default=0, min=0, description="Seed of the random numbers; another seed gives an independent picture")
    threads: IntProperty(name="Threads", default=0, min=0, max=4096, description="Number of threads; 0: one for each core")
    classes: StringProperty(name="Path Classes", default="",
                            description="A pass for each class of light paths: caustic=LS+DE; direct=LDE")
    use_albedo: BoolProperty(name="Albedo", default=False, description="Add the pass Albedo, for denoisers")

    def directives(self):
        """Directives of the integrator and the sampler."""
        line = f'Integrator "{self.integrator}"'
        if self.integrator in WITH_DEPTH and self.max_depth >= 0:
            line += f' "integer maxdepth" {self.max_depth}'
        if self.integrator in ("photonmap", "vcm") and self.photons > 0:
            line += f' "integer photons" {self.photons}' + (' "integer passes" 0' if self.integrator == "photonmap" else "")
        if self.integrator == "photonmap" and self.caustics_only:
            line += ' "bool causticsonly" true'
        return [line, f'Sampler "sobol" "integer pixelsamples" {self.samples} "integer seed" {self.seed}']

    def options(self):
        """Options that only the command line has."""
        out = []
        if self.time_limit > 0:
            out += ["--time-limit", number(self.time_limit)]
        if self.error_target > 0:
            out += ["--error-target", number(self.error_target)]
        if not (self.time_limit > 0 or self.error_target > 0):
            out += ["--spp", str(self.samples)]
        if self.adaptive and "--spp" in out:
            out.append("--adaptive")
        if self.threads > 0:
            out += ["--nthreads", str(self.threads)]
        for name, expression in self.class_list():
            out += ["--class", f"{name}={expression}"]
        return out

    def class_list(self):
        """Names and expressions of path classes."""
        pairs = [text.partition("=") for text in self.classes.split(";") if text.strip()]
        return [(name.strip(), (expression or name).strip()) for name, _, expression in pairs]


class _Panel(bpy.types.Panel):
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"RECURSE"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def column(self, context, *names):
        """Column of the settings with these names."""
        self.layout.use_property_split = True
        column = self.layout.column()
        for name in names:
            column.prop(context.scene.recurse, name)
        return column


class RECURSE_PT_sampling(_Panel):
    bl_label = "Sampling"

    def draw(self, context):
        self.column(context, "integrator", "samples", "time_limit", "error_target", "adaptive", "max_depth", "seed", "threads")


class RECURSE_PT_photons(_Panel):
    bl_label = "Photons"

    def draw(self, context):
        self.column(context, "photons", "caustics_only").active = context.scene.recurse.integrator in ("photonmap", "vcm")


class RECURSE_PT_passes(_Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        column = self.column(context, "use_albedo", "classes")
        for name in ("use_pass_z", "use_pass_normal", "use_pass_cryptomatte_object", "use_pass_cryptomatte_material"):
            column.prop(context.view_layer, name)


class RECURSE_PT_file(_Panel):
    bl_label = "Scene File"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.operator("recurse.write_scene")


CLASSES = (RecurseSettings, RECURSE_PT_sampling, RECURSE_PT_photons, RECURSE_PT_passes, RECURSE_PT_file)
