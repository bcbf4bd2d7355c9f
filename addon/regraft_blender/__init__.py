"""Regraft for Blender: previews of animated scenes by ray tracing.

The engine "Regraft" hands the scene to the native library, which keeps its ray-tracing structures
alive from frame to frame; see docs/api.md for the library. Nothing here imports bpy until
`register` is called, so that the parts that do without Blender can be used and tested without it.
"""

from __future__ import annotations

bl_info = {
    "name": "Regraft",
    "description": "Previews of animated scenes, traced with structures that stay alive",
    "author": "Regraft contributors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render properties, and View3D > Sidebar > Regraft",
    "category": "Render",
}


def register() -> None:
    """Add engine, settings, panels and operators to Blender; twice is as good as once."""
    from . import registration

    registration.register()


def unregister() -> None:
    """Take everything out again, viewports that are just rendering included."""
    from . import registration

    registration.unregister()
