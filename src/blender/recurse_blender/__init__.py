"""Recurse as a render engine of Blender."""
import bpy

from . import engine, settings

bl_info = {
    "name": "Recurse",
    "description": "Photon mapping and path tracing by the program recurse",
    "author": "The Recurse project",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render properties > Render Engine",
    "category": "Render",
}

#: Panels of Blender that suit all engines with shader nodes.
SHARED_PANELS = ("RENDER_PT_", "OUTPUT_PT_", "VIEWLAYER_PT_", "DATA_PT_camera", "DATA_PT_lens", "CAMERA_PT_", "MATERIAL_PT_",
                 "CYCLES_PT_context_material", "CYCLES_MATERIAL_PT_surface", "CYCLES_MATERIAL_PT_volume", "CYCLES_LIGHT_PT_",
                 "CYCLES_WORLD_PT_surface", "WORLD_PT_", "CYCLES_CAMERA_PT_dof", "PARTICLE_PT_", "TEXTURE_PT_")
HIDDEN = ("RENDER_PT_eevee", "RENDER_PT_simplify", "RENDER_PT_gpencil", "MATERIAL_PT_freestyle", "RENDER_PT_freestyle")


class RecursePreferences(bpy.types.AddonPreferences):
    """Preferences of the add-on."""

    bl_idname = __package__
    program: bpy.props.StringProperty(name="Program", subtype="FILE_PATH",
                                      description="The program recurse; empty: the one in PATH")

    def draw(self, _context):
        self.layout.prop(self, "program")


CLASSES = (*settings.CLASSES, *engine.CLASSES, RecursePreferences)


def _panels():
    for panel in bpy.types.Panel.__subclasses__():
        name = panel.__name__
        if hasattr(panel, "COMPAT_ENGINES") and name.startswith(SHARED_PANELS) and not name.startswith(HIDDEN):
            if {"BLENDER_RENDER", "CYCLES", "BLENDER_EEVEE"} & panel.COMPAT_ENGINES:
                yield panel


def register():
    """Called by Blender."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.recurse = bpy.props.PointerProperty(type=settings.RecurseSettings)
    for panel in _panels():
        panel.COMPAT_ENGINES.add("RECURSE")


def unregister():
    """Called by Blender."""
    for panel in _panels():
        panel.COMPAT_ENGINES.discard("RECURSE")
    del bpy.types.Scene.recurse
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
