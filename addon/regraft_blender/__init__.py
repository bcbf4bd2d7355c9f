"""Regraft for Blender: previews of animated scenes by ray tracing.

The engine "Regraft" hands the scene to the native library, which keeps its ray-tracing structures
alive from frame to frame; see docs/api.md for the library.
"""

from __future__ import annotations

import logging

import bpy

from . import compat, engine, handlers, session
from .ui import operators, panels, properties

bl_info = {
    "name": "Regraft",
    "description": "Previews of animated scenes, traced with structures that stay alive",
    "author": "Regraft contributors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render properties, and View3D > Sidebar > Regraft",
    "category": "Render",
}

log = logging.getLogger(__name__)

CLASSES = (
    *properties.CLASSES,
    *operators.CLASSES,
    engine.RegraftEngine,
    *panels.CLASSES,
)


def register() -> None:
    """Add engine, settings, panels and operators to Blender; twice is as good as once."""
    for cls in CLASSES:
        if not getattr(cls, "is_registered", False):
            bpy.utils.register_class(cls)
    properties.attach()
    panels.attach()
    handlers.register()
    compat.forget()
    if compat.problem():
        log.warning("Regraft is registered, but cannot render: %s", compat.problem())


def unregister() -> None:
    """Take everything out again, viewports that are just rendering included."""
    session.close_all()
    handlers.unregister()
    panels.detach()
    properties.detach()
    for cls in reversed(CLASSES):
        if getattr(cls, "is_registered", False):
            bpy.utils.unregister_class(cls)
